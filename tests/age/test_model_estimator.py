"""The estimator names a band only when it is sure enough."""

import numpy as np
import pytest

from attune.core.messages import AgeEstimate, Band
from attune.speech.age.choice import make_age_estimator
from attune.speech.age.estimator import AgeEstimator
from attune.speech.age.hub import ModelNotFoundError
from attune.speech.age.model_estimator import ModelEstimator
from attune.speech.age.models import load_age_model
from attune.speech.age.norms import NormsEstimator
from attune.speech.age.tracker import AgeTracker
from attune.speech.recogniser import Recognition


class Fixed:
    """A model that always answers the same."""

    def __init__(self, older: float) -> None:
        self._probabilities = np.array([1 - older, 0, 0, 0, 0, older, 0, 0, 0])

    def probabilities(self, samples: np.ndarray, features: np.ndarray | None = None) -> np.ndarray:
        return self._probabilities


SECOND = np.zeros(16_000, np.float32)


@pytest.mark.parametrize(
    ("older", "band", "confidence"),
    [(0.9, "older", 0.9), (0.1, "younger", 0.9), (0.55, "unknown", 0.55), (0.45, "unknown", 0.55)],
)
def test_the_band_is_unknown_under_the_threshold(older: float, band: Band, confidence: float) -> None:
    found = ModelEstimator(Fixed(older)).estimate(SECOND, Recognition())
    assert (found.band, found.source) == (band, "model")
    assert found.confidence == pytest.approx(confidence)
    assert sum(found.probabilities) == pytest.approx(1)


def test_very_short_sound_gives_no_estimate() -> None:
    found = ModelEstimator(Fixed(0.9)).estimate(SECOND[:4000], Recognition())
    assert found.probabilities == ()
    assert found.band == "unknown"


def test_where_older_begins_can_be_chosen() -> None:
    assert ModelEstimator(Fixed(0.9), older_from="seventies").estimate(SECOND, Recognition()).band == "younger"


def test_a_trained_model_serves_as_the_listener_s_estimator(trained, speech: np.ndarray) -> None:  # type: ignore[no-untyped-def]
    estimator: AgeEstimator = ModelEstimator(load_age_model(str(trained.model)))
    found = estimator.estimate(speech, Recognition())
    assert len(found.probabilities) == 9
    assert found.band in {"younger", "older", "unknown"}


def test_the_configuration_chooses_the_estimator(trained) -> None:  # type: ignore[no-untyped-def]
    assert make_age_estimator("off") is None
    assert isinstance(make_age_estimator("norms"), NormsEstimator)
    assert isinstance(make_age_estimator(str(trained.model)), ModelEstimator)
    with pytest.raises(ModelNotFoundError, match="no such folder"):
        make_age_estimator("./nowhere")


def test_the_tracker_takes_the_same_first_older_group() -> None:
    fifties = AgeEstimate(probabilities=tuple(np.eye(9)[4].tolist()), source="model")
    assert AgeTracker("fifties").update(fifties).band == "older"
    assert AgeTracker().update(fifties).band == "younger"
