"""The fundamental frequency of a voice, by autocorrelation."""

import numpy as np
from numpy.typing import NDArray

from attune.speech.audio import SAMPLE_RATE, Samples

LOWEST, HIGHEST = 65.0, 350.0
"""Range of adult voices [Hz]."""
_WINDOW, _HOP = 1024, 256
_PERIODIC = 0.6
"""Share of a window's energy that must repeat for it to count as voiced."""
_QUIET = 0.1
"""Windows under this share of the loudest one are pauses."""


def fundamental_frequencies(samples: Samples) -> NDArray[np.float64]:
    """The fundamental frequency of each voiced window [Hz], shape (windows,); empty when nothing is voiced."""
    if len(samples) < _WINDOW:
        return np.zeros(0)
    windows = np.lib.stride_tricks.sliding_window_view(samples, _WINDOW)[::_HOP].astype(np.float64)
    windows = windows - windows.mean(axis=1, keepdims=True)
    loudness = np.sqrt(np.mean(windows**2, axis=1))
    windows = windows[loudness > _QUIET * max(float(loudness.max()), 1e-9)]
    taper = np.hanning(_WINDOW)
    correlation = _autocorrelation(windows * taper)
    # Dividing by the taper's own correlation takes away its preference for short periods.
    correlation /= np.maximum(correlation[:, :1], 1e-12) * (_autocorrelation(taper[None]) / np.sum(taper**2))
    first, last = int(SAMPLE_RATE / HIGHEST), int(SAMPLE_RATE / LOWEST)
    lags = correlation[:, first : last + 1]
    best = lags.max(axis=1, initial=0.0)
    # The shortest period that repeats nearly as well as the best one: a multiple of the period repeats as well.
    period = first + np.argmax(lags >= 0.9 * best[:, None], axis=1)
    period = np.array([_top(row, lag, last) for row, lag in zip(correlation, period, strict=True)], dtype=np.float64)
    return np.asarray(SAMPLE_RATE / period[best > _PERIODIC])


def _autocorrelation(windows: NDArray[np.float64]) -> NDArray[np.float64]:
    spectrum = np.fft.rfft(windows, 2 * _WINDOW, axis=1)
    return np.fft.irfft(np.abs(spectrum) ** 2, axis=1)[:, : int(SAMPLE_RATE / LOWEST) + 2]


def _top(correlation: NDArray[np.float64], lag: int, last: int) -> int:
    """Walk uphill from a lag to the top of its peak."""
    while lag < last and correlation[lag + 1] > correlation[lag]:
        lag += 1
    return lag
