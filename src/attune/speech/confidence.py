"""How far a reading can be trusted: whether it is of the domain at all, and whether it was heard right.

Both are logistic regressions on readings of ten synthetic voices (espeak-ng, flite, Piper), clean and with noise at 20
to 5 dB. PocketSphinx's: about 400 readings, whole sentences and short phrases, half of them about other things; the
weight of noise was set by hand, higher than it came out, because what lowers the noise hides some of it. Whisper's: 430
readings of sentences that are not in the grammar of phrasings, 170 of them about other things, and, for whether it was
heard right, 510 requests, half of them from that grammar.
"""

import math
from dataclasses import dataclass

import numpy as np

from attune.speech.audio import SAMPLE_RATE, Samples

_OVER_EVERYDAY, _DOMAIN_FIT, _DOMAIN = 0.171, 2.24, 3.84
_LARGEST_LEAD = 15.0
"""The rival is searched for with few hypotheses and sometimes lost: more than this says nothing more."""
_ACTED_ON = 0.4
"""Evidence for the domain from which a reading is acted on; one sentence in a hundred about other things has more."""
_IN_DOMAIN = -0.6
"""Evidence from which a reading may be of the domain; less than the one above is asked back."""
_FIT, _WEAKEST_WORD, _SNR, _RIGHT = 1.23, 3.7, 0.12, -0.96
_SURE = 0.2
"""Evidence for a right reading from which it is acted on."""
_ASK = math.log(0.3 / 0.7)
"""Logit of the confidence under which the dialogue asks back (`dialogue.confidence_ask`)."""
_BEST_SNR, _SUPPRESSION = 25.0, 14.0
"""Better than this makes no difference [dB]. What is measured has gained so much by the suppression of noise, which
takes as much from the doubtful sounds of speech as from the noise."""
_BLOCK = SAMPLE_RATE // 50


_WRITTEN_FIT, _TELLING_WORDS, _AGREED_DOMAIN, _WRITTEN_DOMAIN = 2.03, 2.05, 1.12, 2.62
_WRITTEN_ACTED_ON, _WRITTEN_IN_DOMAIN = 0.7, -0.4
_RIGHT_FIT, _RIGHT_TOKENS, _AGREED_RIGHT, _WRITTEN_RIGHT = 0.78, 0.324, 1.49, -1.06
_RIGHT_LEAD, _LARGEST_WRITTEN_LEAD, _UNKNOWN_WORD, _MOST_UNKNOWN = 0.17, 12.0, -0.67, 2
_WRITTEN_SNR, _WRITTEN_BEST_SNR = 0.075, 45.0
"""The weight of noise came out as 0.052, and is higher for the same reason."""
_WRITTEN_SURE = 1.2


@dataclass(frozen=True, slots=True)
class Reading:
    """What PocketSphinx knows about a reading.

    Attributes:
        over_everyday: Score over that of everyday English, for each frame of speech (logarithm to the base 1.0001).
        fit: Of the text; see `DomainFit.fit`.
        weakest_word: Smallest posterior probability of a word.
        snr: Signal-to-noise ratio after suppression [dB].
    """

    over_everyday: float
    fit: float
    weakest_word: float
    snr: float

    @property
    def domain_evidence(self) -> float:
        """For the domain against all other talk."""
        return _OVER_EVERYDAY * min(self.over_everyday, _LARGEST_LEAD) + _DOMAIN_FIT * self.fit + _DOMAIN

    @property
    def in_domain(self) -> bool:
        """Whether it may be of the domain."""
        return self.domain_evidence >= _IN_DOMAIN

    @property
    def confidence(self) -> float:
        """0 to 1: the smaller of that it is of the domain and that it was heard right.

        The scale is the dialogue's: 0.3 and more is acted on, less than 0.15 ignored, in between it asks back.
        """
        snr = min(self.snr - _SUPPRESSION, _BEST_SNR)
        right = _FIT * self.fit + _WEAKEST_WORD * self.weakest_word + _SNR * snr + _RIGHT
        return _confidence(self.domain_evidence - _ACTED_ON, right - _SURE)


@dataclass(frozen=True, slots=True)
class WrittenReading:
    """What is known about a reading that Whisper has scored, which knows all of English.

    Attributes:
        fit: Of the text; see `DomainFit.fit`.
        telling_words: Their weight; see `DomainFit.telling_words`.
        tokens: Mean logarithm of a token's probability.
        agreed: 1 if both recognisers have found the same telling words, 0 if not, 0.5 if only one listens.
        lead: How much likelier it is than the nearest reading with telling words that it has not (natural logarithm);
            infinite without such a reading.
        unknown: Number of its words that the domain does not have.
        snr: Signal-to-noise ratio after suppression [dB].
    """

    fit: float
    telling_words: float
    tokens: float
    agreed: float
    lead: float
    unknown: int
    snr: float

    @property
    def domain_evidence(self) -> float:
        """For the domain against all other talk."""
        text = _WRITTEN_FIT * self.fit + _TELLING_WORDS * self.telling_words + _WRITTEN_DOMAIN
        return text + _AGREED_DOMAIN * self.agreed

    @property
    def in_domain(self) -> bool:
        """Whether it may be of the domain."""
        return self.domain_evidence >= _WRITTEN_IN_DOMAIN

    @property
    def confidence(self) -> float:
        """As that of a `Reading`."""
        right = _RIGHT_FIT * self.fit + _RIGHT_TOKENS * self.tokens + _AGREED_RIGHT * self.agreed + _WRITTEN_RIGHT
        right += _RIGHT_LEAD * min(self.lead, _LARGEST_WRITTEN_LEAD)
        right += _UNKNOWN_WORD * min(self.unknown, _MOST_UNKNOWN)
        right += _WRITTEN_SNR * min(self.snr, _WRITTEN_BEST_SNR)
        return _confidence(self.domain_evidence - _WRITTEN_ACTED_ON, right - _WRITTEN_SURE, slope=0.35)


def _confidence(domain: float, right: float, slope: float = 0.5) -> float:
    # Less than the slope of the domain, so that what was heard badly is asked back rather than ignored.
    logit = min(domain, slope * right) + _ASK
    return 1 / (1 + math.exp(-max(-50.0, min(50.0, logit))))


def signal_to_noise(samples: Samples) -> float:
    """Of an utterance with pauses before and after [dB]: its loud parts over its quiet parts."""
    blocks = samples[: len(samples) // _BLOCK * _BLOCK].reshape(-1, _BLOCK)
    if len(blocks) == 0:
        return 0.0
    quiet, loud = np.percentile(np.mean(blocks**2, axis=1), (10, 90)) + 1e-10
    return float(10 * np.log10(max(loud / quiet - 1, 1e-3)))
