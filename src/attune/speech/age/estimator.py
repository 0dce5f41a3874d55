"""What every age estimator offers."""

from typing import Protocol

from attune.core.messages import AgeEstimate
from attune.speech.audio import Samples
from attune.speech.recogniser import Recognition


class AgeEstimator(Protocol):
    """Estimates the age of who spoke one utterance. Called in a worker thread; may take some 100 ms."""

    def estimate(self, samples: Samples, heard: Recognition) -> AgeEstimate:
        """From an utterance's sound (16 kHz mono) and what was recognised; an empty estimate when it cannot tell."""
        ...
