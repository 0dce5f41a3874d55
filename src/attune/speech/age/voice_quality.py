"""How regular a voice is in running speech: jitter, shimmer and the harmonics-to-noise ratio.

Clinics measure these on one vowel held for seconds. Running speech has melody and stress, so only stretches whose pitch
is steady count, a cycle is compared with the mean of itself and its neighbours (which takes out a linear rise or fall,
as "relative average perturbation" and "three-point amplitude perturbation" do), and medians stand for means. The values
are higher than those of held vowels and cannot be compared with clinical norms directly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.speech.age.pitch import HOP, WINDOW, PitchTrack, parabola
from attune.speech.audio import SAMPLE_RATE, Samples

_STEADY = 0.08
"""Greatest change of pitch between two windows of one stretch."""
_SHORTEST_STRETCH = 3
"""Windows, that is 96 ms."""
_FEWEST_CYCLES = 40
_SEARCH = 0.15
"""How far from the expected period a cycle may end, as a share of it."""
_ALIKE = 0.7
"""Correlation under which two cycles are not of one voice."""
_CLEAN = 20.0
"""The voice must be so much louder than the quietest tenth of the sound [dB]; else it is the noise that is measured."""


@dataclass(frozen=True, slots=True)
class VoiceQuality:
    """How regular a voice is.

    Attributes:
        jitter: Typical change of the period from cycle to cycle, as a share of it.
        shimmer: The same of the amplitude.
        harmonics_to_noise: [dB].
    """

    jitter: float
    shimmer: float
    harmonics_to_noise: float


def voice_quality(samples: Samples, track: PitchTrack) -> VoiceQuality | None:
    """The quality of a voice, or None when too little of it is steady or the recording is noisy.

    Args:
        samples: 16 kHz mono.
        track: Of the same samples.
    """
    if not _is_clean(samples, track):
        return None
    stretches = _steady_stretches(track)
    cycles = [_cycles(samples, track, stretch) for stretch in stretches]
    if sum(map(len, cycles)) < _FEWEST_CYCLES:
        return None
    jitter, shimmer = (
        float(np.median(np.concatenate([_perturbations(each[:, column]) for each in cycles]))) for column in (0, 1)
    )
    repeated = np.clip(track.periodicity[np.concatenate(stretches)], 0.01, 0.9999)
    return VoiceQuality(jitter, shimmer, float(np.median(10 * np.log10(repeated / (1 - repeated)))))


def _is_clean(samples: Samples, track: PitchTrack) -> bool:
    if len(track.starts) == 0:
        return False
    frames = samples[: len(samples) // HOP * HOP].astype(np.float64).reshape(-1, HOP)
    power = np.mean(frames**2, axis=1)
    voice = float(np.median(power[track.starts // HOP]))
    return bool(voice > 10 ** (_CLEAN / 10) * float(np.quantile(power, 0.1)))


def _steady_stretches(track: PitchTrack) -> list[NDArray[np.int64]]:
    """Indices of neighbouring voiced windows without a jump of pitch."""
    change = np.abs(np.diff(np.log(track.frequencies)))
    breaks = np.nonzero((np.diff(track.starts) > HOP) | (change > _STEADY))[0] + 1
    return [part for part in np.split(np.arange(len(track.starts)), breaks) if len(part) >= _SHORTEST_STRETCH]


def _cycles(samples: Samples, track: PitchTrack, stretch: NDArray[np.int64]) -> NDArray[np.float64]:
    """Period [samples] and amplitude of each cycle of a stretch, shape (cycles, 2)."""
    centres = track.starts[stretch] + WINDOW / 2
    periods = SAMPLE_RATE / track.frequencies[stretch]
    at, end = float(track.starts[stretch[0]]), int(track.starts[stretch[-1]]) + WINDOW
    found: list[tuple[float, float]] = []
    while True:
        expected = float(np.interp(at, centres, periods))
        start, length, reach = round(at), round(expected), max(2, round(_SEARCH * expected))
        if start + 2 * length + reach >= min(end, len(samples)):
            break
        cycle = samples[start : start + length].astype(np.float64)
        cycle -= cycle.mean()
        later = samples[start + length - reach : start + 2 * length + reach + 1].astype(np.float64)
        shifted = np.lib.stride_tricks.sliding_window_view(later, length)
        shifted = shifted - shifted.mean(axis=1, keepdims=True)
        alike = shifted @ cycle / np.maximum(np.linalg.norm(shifted, axis=1) * np.linalg.norm(cycle), 1e-12)
        best = int(np.clip(np.argmax(alike), 1, len(alike) - 2))
        if alike[best] < _ALIKE:
            at += expected
            continue
        period = length - reach + best + parabola(*alike[best - 1 : best + 2])[0]
        found.append((period, float(np.sqrt(np.mean(cycle**2)))))
        at += period
    return np.array(found).reshape(-1, 2)


def _perturbations(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far each value is from the mean of itself and its neighbours, as a share of that mean."""
    if len(values) < 3:
        return np.zeros(0)
    means = np.convolve(values, np.ones(3) / 3, mode="valid")
    return np.asarray(np.abs(values[1:-1] - means) / means)
