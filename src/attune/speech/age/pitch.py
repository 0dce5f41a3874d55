"""The fundamental frequency of a voice, and how periodic it is, by autocorrelation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.speech.audio import SAMPLE_RATE, Samples

LOWEST, HIGHEST = 65.0, 350.0
"""Range of adult voices [Hz]."""
WINDOW, HOP = 1024, 256
"""Samples of a window, and between the beginnings of two."""
_PERIODIC = 0.6
"""Share of a window's energy that must repeat for it to count as voiced."""
_QUIET = 0.1
"""Windows under this share of the loudest one are pauses."""


@dataclass(frozen=True, slots=True)
class PitchTrack:
    """The voiced windows of a sound; the arrays have one entry for each, in order.

    Attributes:
        starts: First sample of the window.
        frequencies: Fundamental frequency [Hz].
        periodicity: Share of the energy that repeats after one period, up to 1.
    """

    starts: NDArray[np.int64]
    frequencies: NDArray[np.float64]
    periodicity: NDArray[np.float64]

    @property
    def seconds(self) -> float:
        """How long the voice sounds [s]."""
        return len(self.starts) * HOP / SAMPLE_RATE


def pitch_track(samples: Samples) -> PitchTrack:
    """The fundamental frequency of each voiced window; an empty track when nothing is voiced."""
    if len(samples) < WINDOW:
        return PitchTrack(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))
    windows = np.lib.stride_tricks.sliding_window_view(samples, WINDOW)[::HOP].astype(np.float64)
    windows = windows - windows.mean(axis=1, keepdims=True)
    loudness = np.sqrt(np.mean(windows**2, axis=1))
    (heard,) = np.nonzero(loudness > _QUIET * max(float(loudness.max()), 1e-9))
    taper = np.hanning(WINDOW)
    correlation = _autocorrelation(windows[heard] * taper)
    # Dividing by the taper's own correlation takes away its preference for short periods.
    correlation /= np.maximum(correlation[:, :1], 1e-12) * (_autocorrelation(taper[None]) / np.sum(taper**2))
    first, last = int(SAMPLE_RATE / HIGHEST), int(SAMPLE_RATE / LOWEST)
    lags = correlation[:, first : last + 1]
    best = lags.max(axis=1, initial=0.0)
    voiced = best > _PERIODIC
    # The shortest period that repeats nearly as well as the best one: a multiple of the period repeats as well.
    shortest = first + np.argmax(lags >= 0.9 * best[:, None], axis=1)
    peaks = [_peak(row, lag, last) for row, lag in zip(correlation[voiced], shortest[voiced], strict=True)]
    periods, heights = np.array(peaks, dtype=np.float64).reshape(-1, 2).T
    return PitchTrack(heard[voiced] * HOP, SAMPLE_RATE / periods, np.minimum(heights, 1.0))


def parabola(before: float, top: float, after: float) -> tuple[float, float]:
    """Where between -0.5 and 0.5 the parabola through three equidistant points has its top, and its height there."""
    bend = before - 2 * top + after
    if bend >= 0:
        return 0.0, top
    shift = float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5))
    return shift, top - 0.25 * (before - after) * shift


def _autocorrelation(windows: NDArray[np.float64]) -> NDArray[np.float64]:
    spectrum = np.fft.rfft(windows, 2 * WINDOW, axis=1)
    return np.fft.irfft(np.abs(spectrum) ** 2, axis=1)[:, : int(SAMPLE_RATE / LOWEST) + 2]


def _peak(correlation: NDArray[np.float64], lag: int, last: int) -> tuple[float, float]:
    """Walk uphill from a lag to the top of its peak: lag between samples, and height."""
    while lag < last and correlation[lag + 1] > correlation[lag]:
        lag += 1
    shift, height = parabola(correlation[lag - 1], correlation[lag], correlation[lag + 1])
    return lag + shift, height
