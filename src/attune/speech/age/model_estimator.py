"""An age model as the estimator that the listener asks for each utterance."""

from attune.core.messages import AgeEstimate, AgeGroup, Band
from attune.speech.age.features import SAMPLE_RATE
from attune.speech.age.groups import OLDER_FROM, probability_older
from attune.speech.age.models import AgeModel, load_age_model
from attune.speech.audio import Samples
from attune.speech.recogniser import Recognition

SHORTEST = 0.5
"""From less sound than this no age is estimated [s]."""


class ModelEstimator:
    """Implements `AgeEstimator` with a trained model.

    Args:
        model: The model.
        older_from: The first group that counts as older.
        certain: Share of the likelier band from which on it is named; under it the band is `unknown`, and the
            neutral style applies.
    """

    def __init__(self, model: AgeModel, older_from: AgeGroup = OLDER_FROM, certain: float = 0.65) -> None:
        self._model = model
        self._older_from = older_from
        self._certain = certain

    def estimate(self, samples: Samples, heard: Recognition) -> AgeEstimate:
        """From the utterance's sound (16 kHz mono); the recogniser's log-mel features serve if they fit. Blocks."""
        if len(samples) < SHORTEST * SAMPLE_RATE:
            return AgeEstimate(source="model")
        probabilities = self._model.probabilities(samples, heard.log_mel)
        older = probability_older(probabilities, self._older_from)
        likelier: Band = "older" if older >= 0.5 else "younger"
        confidence = max(older, 1 - older)
        return AgeEstimate(
            probabilities=tuple(probabilities.tolist()),
            band=likelier if confidence >= self._certain else "unknown",
            confidence=confidence,
            source="model",
        )


def load_estimator(name: str, older_from: AgeGroup = OLDER_FROM, *, threads: int = 1) -> ModelEstimator:
    """The estimator of a model by folder or hub name; see `load_age_model` for what it raises."""
    return ModelEstimator(load_age_model(name, threads=threads), older_from)
