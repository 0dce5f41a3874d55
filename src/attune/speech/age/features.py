"""Whisper's log-mel features in numpy, so that neither torch nor transformers is needed where a model only runs.

The recipe is that of the published Whisper models (Radford et al. 2022, section 2.2): 16 kHz, windows of 25 ms every
10 ms, 80 (or 128) mel bands, logarithm, the loudest 80 dB, scaled to about -1 to 1.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

SAMPLE_RATE = 16_000
WINDOW = 400
HOP = 160
LONGEST = 30.0
"""What Whisper's encoder can hear at once [s]."""
SHORTEST = 0.1
"""Shorter sound is padded to this length [s]."""


def log_mel(samples: NDArray[np.float32], *, bands: int = 80, padded: bool = False) -> NDArray[np.float32]:
    """Features of one utterance.

    Args:
        samples: Shape (n,), 16 kHz, mono, -1 to 1. What goes beyond 30 s is left out.
        bands: Mel bands; 80, and 128 for whisper-large-v3.
        padded: Fill up with silence to 30 s, as Whisper was trained, instead of keeping the true length.

    Returns:
        Shape (bands, frames), an even number of frames of 10 ms each.
    """
    longest = int(LONGEST * SAMPLE_RATE)
    sound = np.asarray(samples, np.float32).reshape(-1)[:longest]
    # The encoder halves the number of frames.
    true_length = -(-max(len(sound), int(SHORTEST * SAMPLE_RATE)) // (2 * HOP)) * 2 * HOP
    length = longest if padded else true_length
    sound = np.pad(sound, (0, length - len(sound)))
    extended = np.pad(sound, WINDOW // 2, mode="reflect")
    frames = np.lib.stride_tricks.sliding_window_view(extended, WINDOW)[::HOP][: length // HOP]
    spectrum = np.fft.rfft(frames * _window(), axis=1)
    power = (spectrum.real**2 + spectrum.imag**2).astype(np.float32)
    mel = np.log10(np.maximum(_filters(bands) @ power.T, 1e-10))
    return np.asarray((np.maximum(mel, mel.max() - 8.0) + 4.0) / 4.0, np.float32)


def features_for(
    samples: NDArray[np.float32], given: NDArray[np.float32] | None, *, bands: int, padded: bool
) -> NDArray[np.float32]:
    """The features that a recogniser computed already, if they are what the model takes; else its own.

    Args:
        samples: See `log_mel`.
        given: The recogniser's `log_mel` of the same samples, of their true length, or None.
        bands: See `log_mel`.
        padded: See `log_mel`.
    """
    if given is not None and not padded and given.shape[0] == bands:
        return given
    return log_mel(samples, bands=bands, padded=padded)


@cache
def _window() -> NDArray[np.float32]:
    return (0.5 - 0.5 * np.cos(2 * np.pi * np.arange(WINDOW) / WINDOW)).astype(np.float32)


@cache
def _filters(bands: int) -> NDArray[np.float32]:
    """Triangles of equal area on Slaney's mel scale, shape (bands, WINDOW // 2 + 1)."""
    centres = _to_hertz(np.linspace(0, _to_mel(SAMPLE_RATE / 2), bands + 2))
    bins = np.linspace(0, SAMPLE_RATE / 2, WINDOW // 2 + 1)
    rising = (bins - centres[:-2, None]) / np.diff(centres)[:-1, None]
    falling = (centres[2:, None] - bins) / np.diff(centres)[1:, None]
    triangles = np.maximum(0, np.minimum(rising, falling))
    area = 2 / (centres[2:] - centres[:-2])
    return (triangles * area[:, None]).astype(np.float32)


# Slaney's scale is linear up to 1 kHz (200/3 Hz a mel) and logarithmic above (27 mels for a factor of 6.4).
_LINEAR = 200 / 3
_KNEE = 1000.0
_LOG_STEP = np.log(6.4) / 27


def _to_mel(hertz: float) -> float:
    return float(_KNEE / _LINEAR + np.log(hertz / _KNEE) / _LOG_STEP) if hertz >= _KNEE else hertz / _LINEAR


def _to_hertz(mels: NDArray[np.float64]) -> NDArray[np.float64]:
    knee = _KNEE / _LINEAR
    return np.where(mels >= knee, _KNEE * np.exp(_LOG_STEP * (mels - knee)), _LINEAR * mels)
