"""Watches the microphone's level and says, in one line, what keeps it from hearing well."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from attune.speech.audio import SAMPLE_RATE, Frame, Samples

Problem = Literal["dead", "offset", "hum", "too_loud", "too_quiet"]

_ADVICE: dict[Problem, str] = {
    "dead": "the microphone gives no sound at all: is it muted, unplugged, or the wrong one? See `attune devices`",
    "offset": "the microphone's sound has a constant offset: check its cable and its input",
    "hum": "the microphone hums constantly: check its cable and its power supply",
    "too_loud": "you are too loud, the sound is clipped: lower the microphone's level or go farther from it",
    "too_quiet": "you are hardly audible: raise the microphone's level or come nearer",
}
_AGAIN_AFTER = 60.0
"""The same problem is told again after this time at the earliest [s]."""
_BLOCK = SAMPLE_RATE
"""The level is looked at once a second."""
_LASTING = 3
"""What is constant has lasted for so many blocks in a row."""
_DEAD = -85.0
"""Root mean square under which there is no sound, not even the microphone's own noise [dB full scale]."""
_OFFSET = 0.02
"""Mean of the samples; 1 is full scale."""
_HUM_LEVEL, _HUM_SHARE = -45.0, 0.8
"""So loud [dB full scale], and so much of the power is in the mains' frequency and its harmonics."""
_MAINS = (50, 60)
_HARMONICS = 8
_CLIPPED, _CLIPPED_SHARE = 0.985, 0.002
"""Samples beyond this are clipped, and so many of a second's are too many."""
_QUIET_SPEECH = -48.0
"""Root mean square of a second of speech [dB full scale]: 25 dB under what is usual."""


@dataclass(frozen=True, slots=True)
class Level:
    """Of one second of sound.

    Attributes:
        level: Root mean square, without a constant offset [dB full scale].
        peak: Largest sample [dB full scale].
        problems: What is wrong with it.
    """

    level: float
    peak: float
    problems: tuple[Problem, ...]


def measure(samples: Samples, *, speech: bool) -> Level:
    """Look at about a second of sound.

    Args:
        samples: 16 kHz mono.
        speech: Whether somebody speaks in it.
    """
    offset = float(np.mean(samples))
    level = _decibel(float(np.std(samples)))
    peak = float(np.abs(samples).max(initial=0.0))
    found: list[Problem] = []
    if level < _DEAD:
        found.append("dead")
    if abs(offset) > _OFFSET:
        found.append("offset")
    if not speech and level > _HUM_LEVEL and _share_of_hum(samples - np.float32(offset)) > _HUM_SHARE:
        found.append("hum")
    if float(np.mean(np.abs(samples) >= _CLIPPED)) > _CLIPPED_SHARE:
        found.append("too_loud")
    elif speech and _DEAD <= level < _QUIET_SPEECH:
        found.append("too_quiet")
    return Level(level, _decibel(peak), tuple(found))


def advice(problem: Problem) -> str:
    """What is wrong and what to do, in one line."""
    return _ADVICE[problem]


class LevelMonitor:
    """Tells each problem once it has lasted, and not again within a minute."""

    def __init__(self) -> None:
        self._frames: list[Samples] = []
        self._speech = 0
        self._lasting: dict[Problem, int] = {}
        self._told: dict[Problem, float] = {}

    def accept(self, frame: Frame, *, speaking: bool) -> tuple[Problem, ...]:
        """Take the next frame, as it comes from the microphone; returns what is to be told now."""
        self._frames.append(frame.samples)
        self._speech += speaking
        if sum(map(len, self._frames)) < _BLOCK:
            return ()
        # A second is of speech if somebody spoke in most of it.
        speech = 2 * self._speech > len(self._frames)
        problems = measure(np.concatenate(self._frames), speech=speech).problems
        self._frames, self._speech = [], 0
        self._lasting = {problem: self._lasting.get(problem, 0) + 1 for problem in problems} | {
            # People pause: their last problem counts until they speak again.
            problem: count
            for problem, count in self._lasting.items()
            if problem == "too_quiet" and not speech
        }
        return tuple(problem for problem in problems if self._is_due(problem, frame.end))

    def _is_due(self, problem: Problem, time: float) -> bool:
        # One clipped second is enough; one soft one is not.
        if self._lasting[problem] < {"too_loud": 1, "too_quiet": 2}.get(problem, _LASTING):
            return False
        if time - self._told.get(problem, -np.inf) < _AGAIN_AFTER:
            return False
        self._told[problem] = time
        return True


def _share_of_hum(samples: Samples) -> float:
    """Which share of the power is at the mains' frequency and its harmonics."""
    power = np.abs(np.fft.rfft(samples * np.hanning(len(samples)).astype(np.float32))) ** 2
    width = SAMPLE_RATE / len(samples)
    whole = float(power.sum())
    if whole <= 0:
        return 0.0
    shares = []
    for mains in _MAINS:
        bins = {
            bin_
            for harmonic in range(1, _HARMONICS + 1)
            for bin_ in range(round(mains * harmonic / width) - 2, round(mains * harmonic / width) + 3)
        }
        shares.append(float(power[sorted(bins)].sum()) / whole)
    return max(shares)


def _decibel(value: float) -> float:
    return 20 * float(np.log10(max(value, 1e-6)))
