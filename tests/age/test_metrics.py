"""The numbers of the reports, on cases that can be counted by hand."""

import numpy as np
import pytest

from attune.training.metrics import (
    Predictions,
    calibration_error,
    confusion,
    fit_temperature,
    measure,
    measure_parts,
    softmax,
)


def predictions(said: list[int], true: list[int], confidence: float = 1.0) -> Predictions:
    probabilities = np.full((len(said), 9), (1 - confidence) / 8)
    probabilities[np.arange(len(said)), said] = confidence
    genders = tuple("female" if index % 2 else "male" for index in range(len(said)))
    return Predictions(probabilities, np.array(true), genders, np.linspace(1, 7, len(said)))


def test_measures_of_a_small_set_are_those_counted_by_hand() -> None:
    found = measure(predictions(said=[1, 2, 5, 8, 1, 1], true=[1, 1, 6, 6, 1, 5]))
    assert found.group_accuracy == pytest.approx(2 / 6)
    assert found.off_by_one == pytest.approx(4 / 6)
    assert found.binary_accuracy == pytest.approx(5 / 6)
    assert found.binary_balanced == pytest.approx((3 / 3 + 2 / 3) / 2)
    assert found.binary_baseline == pytest.approx(3 / 6)
    assert found.group_baseline == pytest.approx(3 / 6)
    assert found.balanced_accuracy == pytest.approx((2 / 3 + 0 + 0) / 3)


def test_the_threshold_decides_what_is_older() -> None:
    fifties_called_forties = predictions(said=[3], true=[4])
    assert measure(fifties_called_forties, "sixties").binary_accuracy == 1
    assert measure(fifties_called_forties, "fifties").binary_accuracy == 0


def test_calibration_error_is_the_gap_between_confidence_and_accuracy() -> None:
    right = np.array([True, True, True, False])
    assert calibration_error(np.full(4, 0.75), right) == pytest.approx(0)
    assert calibration_error(np.full(4, 0.95), right) == pytest.approx(0.2)


def test_temperature_makes_an_overconfident_model_honest() -> None:
    rng = np.random.default_rng(0)
    logits = rng.normal(size=(4000, 9)) * 1.5
    truth = np.array([rng.choice(9, p=row) for row in softmax(logits)])
    assert fit_temperature(logits * 3, truth) == pytest.approx(3, rel=0.1)


def test_parts_cover_all_clips_once() -> None:
    every = predictions(said=[1, 2, 3, 4, 5, 6, 7], true=[1] * 7)
    for rows in measure_parts(every).values():
        assert sum(each.count for each in rows.values()) == 7
    assert set(measure_parts(every)["gender"]) == {"female", "male"}


def test_confusion_counts_true_groups_in_rows() -> None:
    table = confusion(predictions(said=[1, 1, 2], true=[1, 5, 5]))
    assert (table[1, 1], table[5, 1], table[5, 2], table.sum()) == (1, 1, 1, 3)
