"""Batches for training: from cached encoder features, or from the sound itself when the encoder learns too."""

import random
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
import torch
from torch import Tensor

from attune.core.errors import AttuneError
from attune.speech.age.features import SAMPLE_RATE
from attune.speech.age.whisper_classifier import WhisperAgeClassifier
from attune.training.clips import ClipError, read_clip
from attune.training.common_voice import Clip
from attune.training.feature_cache import FeatureCache, collate_features

T = TypeVar("T")
_POOL = 50
"""Batches within which clips are sorted by length."""


class NoGoodClipError(AttuneError):
    """Not one of the clips can be read."""

    def __init__(self, count: int) -> None:
        super().__init__(f"none of {count} clips can be read", "Check the folder 'clips' of the corpus")


@dataclass(frozen=True, slots=True)
class Batch:
    """Inputs of one step.

    Attributes:
        inputs: Encoder frames, or log-mel features.
        mask: Which frames are heard (frames), or the true lengths (features); None when all are full.
        groups: True groups, shape (batch,).
        clips: Indices of the clips in the source.
        seconds: Their lengths [s].
    """

    inputs: Tensor
    mask: Tensor | None
    groups: Tensor
    clips: tuple[int, ...]
    seconds: tuple[float, ...]


class Source(Protocol):
    """Clips that can be drawn as batches."""

    @property
    def clips(self) -> Sequence[Clip]:
        """All clips, damaged ones too if that is not known yet."""
        ...

    @property
    def failed(self) -> dict[str, str]:
        """File names of damaged clips met so far, and why."""
        ...

    def batch(self, indices: Sequence[int]) -> Batch:
        """The clips with these indices, without damaged ones. May be called in a thread."""
        ...

    def lengths(self) -> Sequence[int] | None:
        """Length of each clip in any unit, or None if that is not known."""
        ...


class CachedSource:
    """Encoder features from a cache that holds all good clips.

    Args:
        clips: Those that the cache has, or has noted as damaged.
        cache: Where the features are.
        last_only: Give only the last layer of a cache that holds all.
    """

    def __init__(self, clips: Sequence[Clip], cache: FeatureCache, *, last_only: bool = False) -> None:
        self.clips = [clip for clip in clips if clip in cache]
        self.failed = {clip.path.name: cache.failed[clip.path.name] for clip in clips if clip.path.name in cache.failed}
        if not self.clips:
            raise NoGoodClipError(len(clips))
        self._cache = cache
        self._last_only = last_only

    def lengths(self) -> Sequence[int] | None:
        """Frames of each clip."""
        return [self._cache.length(clip) for clip in self.clips]

    def batch(self, indices: Sequence[int]) -> Batch:
        """Frames of these clips, filled up to the longest."""
        each = [self._cache.frames(self.clips[index]) for index in indices]
        if self._last_only:
            each = [frames[-1] for frames in each]
        counts = [frames.shape[-2] for frames in each]
        inputs = np.zeros((len(each), *each[0].shape[:-2], max(counts), each[0].shape[-1]), np.float32)
        for row, frames, count in zip(inputs, each, counts, strict=True):
            row[..., :count, :] = frames
        heard = torch.arange(max(counts)) < torch.tensor(counts)[:, None]
        groups = torch.tensor([self.clips[index].group for index in indices])
        seconds = tuple(count * self._cache.seconds_per_frame for count in counts)
        return Batch(torch.from_numpy(inputs), heard, groups, tuple(indices), seconds)


class SoundSource:
    """Log-mel features, computed from the recordings each time."""

    def __init__(self, clips: Sequence[Clip], model: WhisperAgeClassifier, workers: int = 4) -> None:
        self.clips = list(clips)
        self.failed: dict[str, str] = {}
        self._model = model
        self._pool = ThreadPoolExecutor(workers)

    def lengths(self) -> Sequence[int] | None:
        """Not known before the recordings are read."""
        return None

    def batch(self, indices: Sequence[int]) -> Batch:
        """Features of these clips; in place of a batch that is all damaged, the next good clip."""
        good = [(index, sound) for index, sound in zip(indices, self._pool.map(self._read, indices), strict=True)]
        sounds = [(index, sound) for index, sound in good if sound is not None]
        if not sounds:
            later = ((indices[-1] + step) % len(self.clips) for step in range(1, len(self.clips) + 1))
            found = next(((index, sound) for index in later if (sound := self._read(index)) is not None), None)
            if found is None:
                raise NoGoodClipError(len(self.clips))
            sounds = [found]
        features, lengths = collate_features([sound for _, sound in sounds], self._model)
        groups = torch.tensor([self.clips[index].group for index, _ in sounds])
        seconds = tuple(len(sound) / SAMPLE_RATE for _, sound in sounds)
        return Batch(features, lengths, groups, tuple(index for index, _ in sounds), seconds)

    def _read(self, index: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]] | None:
        clip = self.clips[index]
        if clip.path.name in self.failed:
            return None
        try:
            return read_clip(clip.path)
        except ClipError as error:
            self.failed[clip.path.name] = str(error)
            return None


def plan_batches(
    count: int, size: int, *, seed: int, lengths: Sequence[int] | None = None, share: tuple[int, int] = (0, 1)
) -> list[list[int]]:
    """One epoch in random order, the same for the same arguments.

    Args:
        count: Clips.
        size: Clips per batch.
        seed: Of the order; take another one each epoch.
        lengths: Clips of like length come together, so that little is filled up.
        share: This process's number and how many there are; all get the same number of batches.
    """
    shuffle = random.Random(seed)
    order = list(range(count))
    shuffle.shuffle(order)
    if lengths is not None:
        pool = size * _POOL
        order = [
            index
            for start in range(0, count, pool)
            for index in sorted(order[start : start + pool], key=lambda each: lengths[each])
        ]
    batches = [order[start : start + size] for start in range(0, count, size)]
    shuffle.shuffle(batches)
    batches += batches[: -len(batches) % share[1]]
    return batches[share[0] :: share[1]]


def read_ahead(calls: Sequence[Callable[[], T]], depth: int = 2) -> Iterator[T]:
    """The results of calls in order, with the next ones under way in a thread."""
    with ThreadPoolExecutor(1) as pool:
        waiting: list[Future[T]] = []
        for call in calls:
            waiting.append(pool.submit(call))
            if len(waiting) > depth:
                yield waiting.pop(0).result()
        for future in waiting:
            yield future.result()
