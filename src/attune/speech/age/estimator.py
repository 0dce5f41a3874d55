"""What every age estimator offers."""

from collections.abc import Sequence
from typing import Protocol

from attune.core.messages import AgeEstimate
from attune.speech.audio import Samples
from attune.speech.recogniser import RecognisedWord


class AgeEstimator(Protocol):
    """Estimates the age of who spoke one utterance. Called in a worker thread; may take some 100 ms."""

    def estimate(self, samples: Samples, words: Sequence[RecognisedWord]) -> AgeEstimate:
        """From the utterance's sound (16 kHz mono) and its words; an empty estimate when it cannot tell."""
        ...
