"""Minutes of synthetic talk as a microphone may hear it, and what the network should say at each moment of it."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import soxr
from scipy.signal import butter, lfilter, sosfilt
from voices import DEVELOPMENT

from attune.evaluation.noises import background
from attune.evaluation.speakers import at_level, in_room, noise
from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE, Frame, Samples
from attune.speech.echo import EchoCanceller
from attune.speech.stop_network import HOP, STEP

SECONDS_PER_STEP = STEP * HOP / SAMPLE_RATE
LENGTH = 9.0
ORDERS = frozenset({"stop", "stop_within", "relative"})
STOP, RELATIVE, ORDER = range(3)
_HOMOPHONE = re.compile(r"\b(?:weights?|waits?|wade|way|old on|told on)\b")
_LIKE_PEOPLE = 0.55
"""Share of voices other than espeak-ng's, so that it learns no sound of an engine."""


@dataclass(frozen=True, slots=True)
class Clip:
    """A phrase said by a voice."""

    voice: str
    kind: str
    text: str
    samples: Any


@dataclass(frozen=True, slots=True)
class Said:
    """A clip in a stream; times in seconds."""

    clip: Clip
    start: float
    end: float
    gap_before: float
    gap_after: float


@dataclass(slots=True)
class Stream:
    """Sound and targets.

    Attributes:
        target: Shape (steps, 3).
        counts: Of the same shape: where the target is to be met.
        somewhere: (output, first step, last step): the output is to be 1 somewhere in between.
    """

    samples: Samples
    said: list[Said]
    target: Any
    counts: Any
    somewhere: list[tuple[int, int, int]] = field(default_factory=list)


class Composer:
    """Makes streams.

    Args:
        folder: Of the clips.
        development: With the voices that are not trained with.
        seed: Draws everything.
    """

    def __init__(self, folder: Path, *, development: bool, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._engines: list[list[Clip]] = []
        for path in (path for path in sorted(folder.glob("*.npz")) if ".new" not in path.name):
            with np.load(path) as found:
                labels = json.loads(str(found["labels"]))
                parts = np.split(found["samples"], found["ends"][:-1])
            clips = [Clip(**label, samples=part) for label, part in zip(labels, parts, strict=True)]
            clips = [clip for clip in clips if (clip.voice in DEVELOPMENT) == development]
            if clips and path.stem != "espeak":
                self._engines.append(clips)
            elif clips:
                self._espeak = clips
        self._everybody = [*self._espeak, *(clip for clips in self._engines for clip in clips)]
        self._small_talk = [clip for clip in self._everybody if clip.kind in {"talk", "request"}]
        count = int(1.5 * LENGTH * SAMPLE_RATE)
        self._noises = [background(kind, 3 * count, self._rng) for kind in ("pink", "white", "babble", "kitchen")]

    def stream(self) -> Stream:
        """The next one."""
        rng = self._rng
        at = rng.uniform(1.0, 1.6)
        parts: list[tuple[Clip, float, Samples]] = []
        level = rng.uniform(-42, -14)
        room = (float(rng.uniform(0.15, 0.8)), float(rng.uniform(-2, 12)), int(rng.integers(2**31)))
        echoes = rng.random() < 0.5
        while True:
            clip = self._clip()
            sound = self._altered(clip)
            if at + len(sound) / SAMPLE_RATE > LENGTH - 1.0:
                break
            parts.append((clip, at, at_level(sound, level + rng.normal(0, 1.5))))
            at += len(sound) / SAMPLE_RATE + (rng.uniform(0.08, 0.6) if rng.random() < 0.2 else rng.uniform(0.9, 2.2))
        samples = np.zeros(int(LENGTH * SAMPLE_RATE), np.float32)
        for _, begin, sound in parts:
            first = int(begin * SAMPLE_RATE)
            if echoes:
                reverberation, direct, seed = room
                sound = in_room(sound, np.random.default_rng(seed), reverberation, direct)  # noqa: PLW2901
            piece = sound[: len(samples) - first]
            samples[first : first + len(piece)] += piece
        samples = self._in_noise(samples, level)
        ends = [begin + len(sound) / SAMPLE_RATE for _, begin, sound in parts]
        said = [
            Said(clip, begin, end, begin - (ends[index - 1] if index else 0.0),
                 (parts[index + 1][1] if index + 1 < len(parts) else LENGTH) - end)
            for index, ((clip, begin, _), end) in enumerate(zip(parts, ends, strict=True))
        ]  # fmt: skip
        return labelled(samples, said)

    def _clip(self) -> Clip:
        people = self._engines and self._rng.random() < _LIKE_PEOPLE
        clips = self._engines[int(self._rng.integers(len(self._engines)))] if people else self._espeak
        return clips[int(self._rng.integers(len(clips)))]

    def _altered(self, clip: Clip) -> Samples:
        """Another speed and pitch, another microphone."""
        rng = self._rng
        samples = clip.samples.astype(np.float32) / 32768
        if rng.random() < 0.75:
            faster = rng.uniform(0.82, 1.22)
            samples = soxr.resample(samples, SAMPLE_RATE * faster, SAMPLE_RATE, quality="LQ")
        if rng.random() < 0.5:
            samples = lfilter([1, rng.uniform(-0.7, 0.7)], [1], samples)
        if rng.random() < 0.2:
            samples = sosfilt(butter(4, rng.uniform(3000, 7500), fs=SAMPLE_RATE, output="sos"), samples)
        return np.asarray(samples, np.float32)

    def _in_noise(self, samples: Samples, level: float) -> Samples:
        rng = self._rng
        sound = samples + noise(len(samples), rng.uniform(-75, -55), rng)
        if rng.random() < 0.65:
            snr = rng.uniform(3, 30)
            kind = int(rng.integers(len(self._noises) + 1))
            if kind < len(self._noises):
                begin = int(rng.integers(len(self._noises[kind]) - len(samples)))
                other = self._noises[kind][begin : begin + len(samples)]
            else:
                # Somebody else's voice, or the robot's.
                snr = max(snr, 8)
                talk = [self._altered(self._small_talk[int(rng.integers(len(self._small_talk)))]) for _ in range(8)]
                other = np.resize(np.concatenate(talk), len(samples))
                other = in_room(other, rng, 0.4, 0.0)[: len(samples)]
                other = other / max(float(np.sqrt(np.mean(other**2))), 1e-9)
            sound = sound + other * 10 ** ((level - snr) / 20)
        sound = np.clip(sound, -1, 1).astype(np.float32)
        if rng.random() < 0.5:
            cleaner = EchoCanceller(echo_cancellation=False, noise_suppression=True)
            frames = sound[: len(sound) // FRAME_SAMPLES * FRAME_SAMPLES].reshape(-1, FRAME_SAMPLES)
            times = np.arange(len(frames)) * FRAME_SAMPLES / SAMPLE_RATE
            sound = np.concatenate([
                cleaner.clean(Frame(frame, time)).samples for frame, time in zip(frames, times, strict=True)
            ])  # fmt: skip
        return sound


def labelled(samples: Samples, said: list[Said]) -> Stream:
    """With the targets."""
    steps = int(len(samples) / SAMPLE_RATE / SECONDS_PER_STEP)
    stream = Stream(samples, said, np.zeros((steps, 3), np.float32), np.ones((steps, 3), np.float32))
    stream.counts[:, ORDER] = 0

    def span(begin: float, end: float) -> slice:
        return slice(max(0, round(begin / SECONDS_PER_STEP)), min(steps, round(end / SECONDS_PER_STEP)))

    for each in said:
        kind, text = each.clip.kind, each.clip.text
        if kind == "opening":
            stream.counts[span(each.start, each.end + 0.6), :2] = 0
        elif kind in ORDERS:
            output = RELATIVE if kind == "relative" else STOP
            repeated = text.count("stop") > 1
            begin = each.start if kind != "stop" or repeated else each.end - 0.24
            stream.counts[span(begin, each.end + 0.8), output] = 0
            stream.counts[span(each.start, each.end + 0.8), RELATIVE] = 0
            if kind == "stop":
                exact = span(each.end, each.end + 0.24)
                stream.target[exact, STOP] = stream.counts[exact, STOP] = 1
            else:
                somewhere = span(each.start + 0.15, each.end + 0.12)
                stream.somewhere.append((output, somewhere.start, max(somewhere.stop, somewhere.start + 1)))
        elif _HOMOPHONE.search(text):
            stream.counts[span(each.start, each.end + 0.6), RELATIVE] = 0
        if each.gap_before >= 0.7 and each.gap_after >= 0.85:
            decided = span(each.end + 0.12, each.end + 0.8)
            stream.target[decided, ORDER] = kind in ORDERS
            stream.counts[decided, ORDER] = 1
    return stream
