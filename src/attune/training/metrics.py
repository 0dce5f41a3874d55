"""How good age estimates are: numbers that evaluation and training share."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from attune.core.messages import AGE_GROUPS, AgeGroup
from attune.speech.age.groups import OLDER_FROM

DURATIONS = (0.0, 2.0, 4.0, 6.0, float("inf"))
"""Edges of the classes of length [s]."""
_BINS = 15


@dataclass(frozen=True, slots=True)
class Predictions:
    """What a model said about clips, and what is true.

    Attributes:
        probabilities: Shape (n, 9).
        groups: True index of each clip, shape (n,).
        genders: One per clip, "" when not given.
        durations: [s], shape (n,).
    """

    probabilities: NDArray[np.float64]
    groups: NDArray[np.int64]
    genders: tuple[str, ...]
    durations: NDArray[np.float64]

    def where(self, chosen: Sequence[bool] | NDArray[np.bool_]) -> "Predictions":
        """Only some of the clips."""
        index = np.flatnonzero(chosen)
        return Predictions(
            self.probabilities[index],
            self.groups[index],
            tuple(self.genders[each] for each in index),
            self.durations[index],
        )


@dataclass(frozen=True, slots=True)
class Measures:
    """The numbers of one set of clips; shares from 0 to 1.

    Attributes:
        count: Clips.
        binary_accuracy: Younger or older, right.
        binary_balanced: Mean of the accuracies on the younger and on the older.
        binary_baseline: What always giving the commoner band would reach.
        group_accuracy: The right one of nine groups.
        group_baseline: What always giving the commonest group would reach.
        off_by_one: The right group or one beside it.
        balanced_accuracy: Mean over the groups that occur of their accuracies.
        calibration_error: Expected calibration error of the most likely group, 15 bins.
        binary_calibration_error: The same of the more likely band.
        log_loss: Mean negative log probability of the true group [nats].
    """

    count: int
    binary_accuracy: float
    binary_balanced: float
    binary_baseline: float
    group_accuracy: float
    group_baseline: float
    off_by_one: float
    balanced_accuracy: float
    calibration_error: float
    binary_calibration_error: float
    log_loss: float

    def to_data(self) -> dict[str, float]:
        """As plain data, for JSON."""
        return asdict(self)


def measure(predictions: Predictions, older_from: AgeGroup = OLDER_FROM) -> Measures:
    """All numbers of a non-empty set of predictions."""
    probabilities, truth = predictions.probabilities, predictions.groups
    guess = probabilities.argmax(axis=1)
    first_older = AGE_GROUPS.index(older_from)
    older = probabilities[:, first_older:].sum(axis=1)
    older_guess, older_truth = older >= 0.5, truth >= first_older
    true_share = np.clip(probabilities[np.arange(len(truth)), truth], 1e-12, 1)
    return Measures(
        count=len(truth),
        binary_accuracy=_share(older_guess == older_truth),
        binary_balanced=_balanced(older_guess.astype(int), older_truth.astype(int)),
        binary_baseline=max(_share(older_truth), 1 - _share(older_truth)),
        group_accuracy=_share(guess == truth),
        group_baseline=float(np.bincount(truth).max() / len(truth)),
        off_by_one=_share(abs(guess - truth) <= 1),
        balanced_accuracy=_balanced(guess, truth),
        calibration_error=calibration_error(probabilities.max(axis=1), guess == truth),
        binary_calibration_error=calibration_error(np.maximum(older, 1 - older), older_guess == older_truth),
        log_loss=float(-np.log(true_share).mean()),
    )


def measure_parts(predictions: Predictions, older_from: AgeGroup = OLDER_FROM) -> dict[str, dict[str, Measures]]:
    """The numbers by gender and by duration, of the parts that have clips."""
    genders = np.array([gender or "not given" for gender in predictions.genders])
    parts: dict[str, dict[str, NDArray[np.bool_]]] = {
        "gender": {str(gender): genders == gender for gender in sorted(set(genders.tolist()))},
        "duration": {},
    }
    for low, high in zip(DURATIONS, DURATIONS[1:], strict=False):
        name = f"{low:g} to {high:g} s" if np.isfinite(high) else f"from {low:g} s"
        parts["duration"][name] = (predictions.durations >= low) & (predictions.durations < high)
    return {
        kind: {name: measure(predictions.where(chosen), older_from) for name, chosen in each.items() if chosen.any()}
        for kind, each in parts.items()
    }


def confusion(predictions: Predictions) -> NDArray[np.int64]:
    """Clips by true group (rows) and most likely group (columns), shape (9, 9)."""
    table = np.zeros((len(AGE_GROUPS), len(AGE_GROUPS)), np.int64)
    np.add.at(table, (predictions.groups, predictions.probabilities.argmax(axis=1)), 1)
    return table


def calibration_error(confidence: NDArray[np.float64], right: NDArray[np.bool_]) -> float:
    """Expected calibration error: how far confidence and accuracy lie apart, over 15 bins, weighted by clips."""
    bins = np.minimum((confidence * _BINS).astype(int), _BINS - 1)
    error = 0.0
    for index in range(_BINS):
        inside = bins == index
        if inside.any():
            error += inside.mean() * abs(confidence[inside].mean() - right[inside].mean())
    return float(error)


def softmax(logits: NDArray[np.float64], temperature: float = 1.0) -> NDArray[np.float64]:
    """Probabilities, shape (n, 9)."""
    scaled = logits / temperature
    exponentials = np.exp(scaled - scaled.max(axis=1, keepdims=True))
    return np.asarray(exponentials / exponentials.sum(axis=1, keepdims=True), np.float64)


def fit_temperature(logits: NDArray[np.float64], groups: NDArray[np.int64]) -> float:
    """The temperature with the least log loss, between 0.2 and 10 (Guo et al. 2017, "On calibration")."""
    from scipy.optimize import minimize_scalar

    def loss(log_temperature: float) -> float:
        shares = softmax(logits, float(np.exp(log_temperature)))[np.arange(len(groups)), groups]
        return float(-np.log(np.clip(shares, 1e-12, 1)).mean())

    objective: Callable[[float], float] = loss
    found = minimize_scalar(objective, bounds=(np.log(0.2), np.log(10.0)), method="bounded")
    return float(np.exp(found.x))


def _share(right: NDArray[np.bool_]) -> float:
    return float(right.mean())


def _balanced(guess: NDArray[np.int64], truth: NDArray[np.int64]) -> float:
    return float(np.mean([(guess[truth == each] == each).mean() for each in np.unique(truth)]))
