"""The embedded age estimate: how high and how fast a person speaks, against published norms.

It knows little and says so: between people of one age these measures differ more than between the ages, so that it
mostly answers `unknown`. A trained model (see `docs/age.md`) or what the person states is always better.

- Fundamental frequency of men: from 120 Hz in the twenties down to 107 Hz in the forties, up to 146 Hz in the eighties
  (T. Shipp, H. Hollien: Speech frequency and duration measures as a function of chronologic age. J. Acoust. Soc. Am.
  51, 111, 1972; 175 men).
- Of women: about 224 Hz in the twenties, 200 Hz from the fifties on (M. L. Stoicheff: Speaking fundamental frequency
  characteristics of nonsmoking female adults. J. Speech Hear. Res. 24, 437-441, 1981). Other studies find smaller
  changes (M. Nishio, S. Niimi, Folia Phoniatr. Logop. 60, 120-127, 2008), hence the wide spread used here.
- Speech of older adults lasts 20 to 25 % longer (B. L. Smith et al.: Temporal characteristics of the speech of normal
  elderly adults. J. Speech Hear. Res. 30, 522-529, 1987).

Jitter, shimmer and the harmonics-to-noise ratio are not used: their norms are of sustained vowels, and microphone and
room change them in running speech by more than age does.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from attune.core.messages import AgeEstimate, Band
from attune.speech.age.groups import probability_older
from attune.speech.age.pitch import fundamental_frequencies
from attune.speech.audio import Samples
from attune.speech.recogniser import RecognisedWord

_MEN = np.array([122.0, 120.0, 112.0, 107.0, 118.0, 120.0, 132.0, 146.0, 146.0])
_WOMEN = np.array([224.0, 224.0, 213.0, 213.0, 200.0, 200.0, 200.0, 200.0, 200.0])
"""Mean fundamental frequency by age group [Hz]; the ends are continued."""
_SPREAD = 0.22
"""Standard deviation between people of one group, as a share of the mean; wider than any one study, because the studies
disagree."""
_LETTERS_PER_SECOND = np.array([13.0, 13.0, 13.0, 13.0, 12.5, 12.0, 11.0, 10.4, 10.4])
_RATE_SPREAD = 2.5
"""Command speech differs from reading, and from person to person."""
_FEWEST_WINDOWS, _FEWEST_LETTERS = 15, 8
_CERTAIN = 0.75
"""Probability from which a band is named."""


class NormsEstimator:
    """Estimates age from pitch and speed. Takes a few milliseconds."""

    def estimate(self, samples: Samples, words: Sequence[RecognisedWord]) -> AgeEstimate:
        """From one utterance; an empty estimate when it is too short or unvoiced."""
        pitch = fundamental_frequencies(samples)
        if len(pitch) < _FEWEST_WINDOWS:
            return AgeEstimate()
        likelihood = _pitch_likelihood(float(np.median(pitch))) * _rate_likelihood(words)
        probabilities = likelihood / likelihood.sum()
        older = probability_older(probabilities)
        band: Band = "older" if older >= _CERTAIN else "younger" if older <= 1 - _CERTAIN else "unknown"
        return AgeEstimate(
            probabilities=tuple(probabilities.tolist()), band=band, confidence=max(older, 1 - older), source="norms"
        )


def _pitch_likelihood(pitch: float) -> NDArray[np.float64]:
    """Of each group, when men and women are equally likely."""
    return np.asarray(sum(_normal(pitch, means, _SPREAD * means) for means in (_MEN, _WOMEN)))


def _rate_likelihood(words: Sequence[RecognisedWord]) -> NDArray[np.float64]:
    letters = sum(len(word.text) for word in words)
    duration = sum(word.end - word.start for word in words)
    if letters < _FEWEST_LETTERS or duration <= 0:
        return np.ones(len(_MEN))
    return _normal(letters / duration, _LETTERS_PER_SECOND, np.full(len(_MEN), _RATE_SPREAD))


def _normal(value: float, means: NDArray[np.float64], deviations: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.exp(-0.5 * ((value - means) / deviations) ** 2) / deviations)
