"""The embedded age estimate: pitch, voice quality and speed against published norms of ageing voices.

It knows little and says so: between people of one age these measures differ more than between the ages, so that it
mostly answers `unknown`. A trained model (see `docs/age.md`) or what the person states is always better.

- Fundamental frequency of men: from 120 Hz in the twenties down to 107 Hz in the forties, up to 146 Hz in the eighties
  (T. Shipp, H. Hollien: Speech frequency and duration measures as a function of chronologic age. J. Acoust. Soc. Am.
  51, 111, 1972; 175 men). Goy et al. (below) find no difference between young and old men, hence the wide spread.
- Of women: about 224 Hz in the twenties, 200 Hz from the fifties on (M. L. Stoicheff: Speaking fundamental frequency
  characteristics of nonsmoking female adults. J. Speech Hear. Res. 24, 437-441, 1981). Other studies find smaller
  changes (M. Nishio, S. Niimi, Folia Phoniatr. Logop. 60, 120-127, 2008).
- Speech of older adults lasts 20 to 25 % longer (B. L. Smith et al.: Temporal characteristics of the speech of normal
  elderly adults. J. Speech Hear. Res. 30, 522-529, 1987).
- Shimmer rises in older men, not in women; jitter changes in neither (H. Goy et al.: Normative voice data for younger
  and older adults. J. Voice 27, 545-555, 2013; 159 people of 19 years, 133 of 72). 526 Brazilians give the same picture
  (Acoustic measurements through the life span. J. Voice, 2024, doi 10.1016/j.jvoice.2024.11.025). But S. A. Xue,
  D. Deliyski (Educ. Gerontol. 27, 159-168, 2001; 44 people of 70 to 80) and C. Mezzedimi et al. (Objective evaluation
  of presbyphonia, 2016; 142 old and 40 young people) find jitter, shimmer and noise all raised.
- The harmonics-to-noise ratio falls in old women (C. T. Ferrand: Harmonics-to-noise ratio: an index of vocal aging.
  J. Voice 16, 480-487, 2002). In men it rises in one study (E. T. Stathopoulos et al., J. Speech Lang. Hear. Res. 54,
  1011-1021, 2011), and falls in others: taken as unchanged.

How sure this is: of the figures above those of pitch and speed, and the volumes and pages, are from memory; the
directions of jitter, shimmer and noise were read in the abstracts or in summaries, and their sizes are our own cautious
reading. All three were measured on held vowels. In running speech neither their level nor their spread has a norm that
would fit `voice_quality`, so the levels here are those of four of Flite's voices, the spreads wide, and because all
three tell of one irregularity they count together as one measure: they move the odds by a factor of two at most.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from attune.core.messages import AgeEstimate, AgeGroup, Band
from attune.speech.age.groups import OLDER_FROM, probability_older
from attune.speech.age.pitch import pitch_track
from attune.speech.age.voice_quality import VoiceQuality, voice_quality
from attune.speech.audio import Samples
from attune.speech.recogniser import RecognisedWord, Recognition

Norm = NDArray[np.float64]
"""One value for each age group; the ends are continued. Where there are two rows, they are of men and of women."""

PITCH: Norm = np.array(
    [
        [122.0, 120.0, 112.0, 107.0, 118.0, 120.0, 132.0, 146.0, 146.0],
        [224.0, 224.0, 213.0, 213.0, 200.0, 200.0, 200.0, 200.0, 200.0],
    ]
)
"""Mean fundamental frequency [Hz]."""
PITCH_SPREAD = 0.22
"""Standard deviation between people of one group, as a share of the mean; wider than any one study, because the studies
disagree."""
_OLD = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0])
"""How much of the change that studies find between young adults and people over 70 has happened."""
JITTER: Norm = np.log(0.005) + np.array([[0.1], [0.1]]) * _OLD
SHIMMER: Norm = np.log(0.03) + np.array([[0.25], [0.0]]) * _OLD
HARMONICS_TO_NOISE: Norm = np.array([[10.0], [14.0]]) + np.array([[0.0], [-2.0]]) * _OLD
"""Jitter and shimmer as logarithms of shares, harmonics to noise in dB."""
JITTER_SPREAD, SHIMMER_SPREAD, HARMONICS_TO_NOISE_SPREAD = 0.7, 0.6, 4.5
RATE: Norm = np.array([13.0, 13.0, 13.0, 13.0, 12.5, 12.0, 11.0, 10.4, 10.4])
"""Letters a second while words are spoken."""
RATE_SPREAD = 3.5
"""Commands differ from reading, and people from each other; the words' times are the recogniser's."""
_OUTLYING = 2.0
"""Further than so many standard deviations from all norms a value tells no more than there: it is mismeasured."""
_SHORTEST_VOICE = 0.4
"""Seconds of voiced speech under which nothing is estimated."""
_FEWEST_LETTERS = 8
_CERTAIN = 0.75
"""Probability from which a band is named."""


class NormsEstimator:
    """Estimates age from pitch, voice quality and speed. Takes about 15 ms for each second of speech.

    Args:
        older_from: The first group that counts as older.
    """

    def __init__(self, older_from: AgeGroup = OLDER_FROM) -> None:
        self._older_from = older_from

    def estimate(self, samples: Samples, heard: Recognition) -> AgeEstimate:
        """From one utterance; an empty estimate when it is too short or unvoiced."""
        track = pitch_track(samples)
        if track.seconds < _SHORTEST_VOICE:
            return AgeEstimate()
        probabilities = age_probabilities(
            float(np.median(track.frequencies)), voice_quality(samples, track), letters_per_second(heard.words)
        )
        older = probability_older(probabilities, self._older_from)
        band: Band = "older" if older >= _CERTAIN else "younger" if older <= 1 - _CERTAIN else "unknown"
        return AgeEstimate(
            probabilities=tuple(probabilities.tolist()), band=band, confidence=max(older, 1 - older), source="norms"
        )


def age_probabilities(pitch: float, quality: VoiceQuality | None, rate: float | None) -> NDArray[np.float64]:
    """Of each group, shape (9,), when all groups, men and women are equally likely beforehand.

    Args:
        pitch: Fundamental frequency [Hz].
        quality: None if it could not be measured.
        rate: Letters a second; None if too little was said.
    """
    logarithm = _log_normal(pitch, PITCH, PITCH_SPREAD * PITCH)
    if quality is not None:
        logarithm = (
            logarithm
            + (
                _log_normal(np.log(max(quality.jitter, 1e-6)), JITTER, JITTER_SPREAD)
                + _log_normal(np.log(max(quality.shimmer, 1e-6)), SHIMMER, SHIMMER_SPREAD)
                + _log_normal(quality.harmonics_to_noise, HARMONICS_TO_NOISE, HARMONICS_TO_NOISE_SPREAD)
            )
            / 3
        )
    if rate is not None:
        logarithm = logarithm + _log_normal(rate, RATE, RATE_SPREAD)
    likelihood = np.exp(logarithm).sum(axis=0)
    return np.asarray(likelihood / likelihood.sum())


def letters_per_second(words: Sequence[RecognisedWord]) -> float | None:
    """Speed without the pauses between words, or None if too little was said."""
    letters = sum(len(word.text) for word in words)
    duration = sum(word.end - word.start for word in words)
    return letters / duration if letters >= _FEWEST_LETTERS and duration > 0 else None


def _log_normal(value: float, means: Norm, deviations: Norm | float) -> NDArray[np.float64]:
    """Logarithm of the normal distribution, up to a constant; see `_OUTLYING`."""
    lowest, highest = np.min(means - _OUTLYING * deviations), np.max(means + _OUTLYING * deviations)
    return np.asarray(-0.5 * ((np.clip(value, lowest, highest) - means) / deviations) ** 2 - np.log(deviations))
