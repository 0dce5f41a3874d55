"""Encoder features of clips on disk, so that the classifier trains in minutes and a crash costs one shard.

A cache folder holds one folder per encoder and variant. In it, shards: `NAME.npy`, the frames of up to 256 clips one
after the other (16 bit floats, memory-mapped when read), and `NAME.json`, `{"clips": {file name: [first frame,
number of frames]}, "failed": {file name: reason}}`. Size: a second of speech takes 50 frames of 768 values, 77 kB for
whisper-small (times 13 with all layers; divided by `frame_stride`).
"""

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from uuid import uuid4

import numpy as np
import torch
from numpy.typing import NDArray

from attune.core.errors import AttuneError
from attune.speech.age.features import HOP, SAMPLE_RATE, log_mel
from attune.speech.age.whisper_classifier import WhisperAgeClassifier
from attune.training.clips import ClipError, read_clip
from attune.training.common_voice import Clip

SHARD = 256
"""Clips per shard."""


class CacheError(AttuneError):
    """The cache cannot be used."""


class FeatureCache:
    """Encoder frames of clips, by file name.

    Args:
        folder: Where caches are kept; made if needed.
        model: The encoder and the variant; their fingerprint names the folder.
    """

    def __init__(self, folder: Path, model: WhisperAgeClassifier) -> None:
        options = model.options
        variant = f"{options.layers}-{options.length}-{options.frame_stride}"
        self._folder = folder / f"{encoder_fingerprint(model)}-{variant}"
        self.seconds_per_frame = options.frame_stride * 2 * HOP / SAMPLE_RATE
        self._places: dict[str, tuple[str, int, int]] = {}
        self._shards: dict[str, NDArray[np.float16]] = {}
        self.failed: dict[str, str] = {}
        """File names of clips that cannot be used, and why."""
        self._read_index()

    def __contains__(self, clip: Clip) -> bool:
        return clip.path.name in self._places

    def frames(self, clip: Clip) -> NDArray[np.float16]:
        """Frames of a clip, shape (time, width), or (states, time, width) for all layers.

        Raises:
            KeyError: The clip is not in the cache.
        """
        shard, first, count = self._places[clip.path.name]
        if shard not in self._shards:
            self._shards[shard] = np.load(self._folder / f"{shard}.npy", mmap_mode="r")
        frames = self._shards[shard][first : first + count]
        # Time is the first axis on disk.
        return frames.swapaxes(0, 1) if frames.ndim == 3 else frames

    def length(self, clip: Clip) -> int:
        """Number of frames of a clip."""
        return self._places[clip.path.name][2]

    def add(
        self,
        clips: Sequence[Clip],
        model: WhisperAgeClassifier,
        *,
        device: str = "cpu",
        batch_size: int = 16,
        workers: int = 4,
        share: tuple[int, int] = (0, 1),
        progress: Callable[[int, int], None] = lambda done, total: None,
    ) -> None:
        """Compute what is missing. Interrupted, it goes on with the next shard the next time.

        Args:
            clips: What should be in the cache. Damaged clips are noted in `failed`.
            model: The model that the cache was opened with.
            device: Where the encoder runs.
            batch_size: Clips encoded at once.
            workers: Threads that decode sound.
            share: This process's number and how many share the work; call `refresh` when all are done.
            progress: Called with the clips done and their total.

        Raises:
            CacheError: The disk is full or not writable.
        """
        missing = [clip for clip in clips if clip not in self and clip.path.name not in self.failed]
        shards = [missing[start : start + SHARD] for start in range(0, len(missing), SHARD)][share[0] :: share[1]]
        total = sum(map(len, shards))
        model.encoder.to(device)
        done = 0
        with ThreadPoolExecutor(workers) as pool:
            for shard in shards:
                sounds = list(pool.map(_sound, shard))
                self._write(shard, sounds, model, device, batch_size)
                done += len(shard)
                progress(done, total)
        self.refresh()

    def refresh(self) -> None:
        """Read what other processes have written."""
        self._read_index()

    def _write(
        self,
        clips: Sequence[Clip],
        sounds: Sequence[NDArray[np.float32] | ClipError],
        model: WhisperAgeClassifier,
        device: str,
        batch_size: int,
    ) -> None:
        failed = {
            clip.path.name: str(sound)
            for clip, sound in zip(clips, sounds, strict=True)
            if isinstance(sound, ClipError)
        }
        good = [
            (clip.path.name, sound)
            for clip, sound in zip(clips, sounds, strict=True)
            if not isinstance(sound, ClipError)
        ]
        # Clips of like length together, so that little is filled up.
        good.sort(key=lambda pair: len(pair[1]))
        pieces: list[NDArray[np.float16]] = []
        places: dict[str, tuple[int, int]] = {}
        first = 0
        for start in range(0, len(good), batch_size):
            batch = good[start : start + batch_size]
            features, lengths = collate_features([sound for _, sound in batch], model)
            with torch.inference_mode():
                frames, heard = model.encode(features.to(device), lengths.to(device) if lengths is not None else None)
            stacked = frames.half().cpu().numpy()
            for row, (name, _) in enumerate(batch):
                count = int(heard[row].sum()) if heard is not None else stacked.shape[-2]
                own = stacked[row][..., :count, :]
                pieces.append(own.swapaxes(0, 1) if own.ndim == 3 else own)
                places[name] = (first, count)
                first += count
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            name = uuid4().hex[:12]
            if pieces:
                with (self._folder / f"{name}.npy").open("wb") as file:
                    np.save(file, np.concatenate(pieces))
                    file.flush()
                    os.fsync(file.fileno())
            # The index file makes the shard valid: it comes last, and whole.
            unfinished = self._folder / f"{name}.json.part"
            unfinished.write_text(json.dumps({"clips": places, "failed": failed}), encoding="utf-8")
            unfinished.replace(self._folder / f"{name}.json")
        except OSError as error:
            raise CacheError(f"{self._folder} cannot be written: {error.strerror}", "Free space, or move it") from None

    def _read_index(self) -> None:
        for path in sorted(self._folder.glob("*.json")):
            data = json.loads(path.read_text(encoding="utf-8"))
            self.failed |= data["failed"]
            for name, (first, count) in data["clips"].items():
                self._places[name] = (path.stem, first, count)


def collate_features(
    sounds: Sequence[NDArray[np.float32]], model: WhisperAgeClassifier
) -> tuple[torch.Tensor, torch.Tensor | None]:
    """Log-mel features of a batch, filled up to the longest, and their true lengths (None when all are 30 s)."""
    padded = model.options.length == "padded"
    each = [log_mel(sound, bands=model.config.num_mel_bins, padded=padded) for sound in sounds]
    longest = max(features.shape[1] for features in each)
    batch = np.stack([np.pad(features, ((0, 0), (0, longest - features.shape[1]))) for features in each])
    lengths = None if padded else torch.tensor([features.shape[1] for features in each])
    return torch.from_numpy(batch), lengths


def encoder_fingerprint(model: WhisperAgeClassifier) -> str:
    """Short hash of the encoder's weights."""
    digest = hashlib.sha256(str(HOP).encode())
    for name, value in sorted(model.encoder.state_dict().items()):
        digest.update(name.encode())
        digest.update(value.detach().cpu().float().numpy().tobytes())
    return digest.hexdigest()[:12]


def _sound(clip: Clip) -> NDArray[np.float32] | ClipError:
    try:
        return read_clip(clip.path)
    except ClipError as error:
        return error
