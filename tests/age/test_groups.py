"""Years, labels and bands."""

import numpy as np
import pytest

from attune.core.messages import AGE_GROUPS
from attune.speech.age.groups import (
    LabelMappingError,
    group_of_years,
    groups_from_labels,
    groups_from_years,
    probability_older,
)


def test_every_year_has_the_group_of_its_decade() -> None:
    assert [group_of_years(years) for years in (3, 19.9, 20, 45, 60, 99, 104)] == [
        "teens",
        "teens",
        "twenties",
        "fourties",
        "sixties",
        "nineties",
        "nineties",
    ]


def test_a_regression_becomes_a_distribution_around_its_answer() -> None:
    shares = groups_from_years(65.0)
    assert shares.sum() == pytest.approx(1)
    assert shares.argmax() == AGE_GROUPS.index("sixties")
    assert shares[5] > shares[4] > shares[3]
    assert probability_older(groups_from_years(60.0)) == pytest.approx(0.5)


def test_the_split_can_be_moved() -> None:
    fifties = np.eye(9)[AGE_GROUPS.index("fifties")]
    assert probability_older(fifties) == 0
    assert probability_older(fifties, "fifties") == 1


@pytest.mark.parametrize(
    ("label", "groups"),
    [
        ("fourties", ["fourties"]),
        ("female_forties", ["fourties"]),
        ("20-29", ["twenties"]),
        ("male 31-45", ["thirties", "fourties"]),
        ("60+", ["sixties", "seventies", "eighties", "nineties"]),
        ("30s", ["thirties"]),
        ("senior", ["sixties", "seventies", "eighties", "nineties"]),
        ("child", ["teens"]),
    ],
)
def test_labels_of_published_models_cover_the_groups_they_name(label: str, groups: list[str]) -> None:
    row = groups_from_labels([label])[0]
    assert row.sum() == pytest.approx(1)
    assert [group for group, share in zip(AGE_GROUPS, row, strict=True) if share] == groups


def test_nine_labels_without_meaning_are_the_nine_groups_in_order() -> None:
    np.testing.assert_array_equal(groups_from_labels([f"LABEL_{index}" for index in range(9)]), np.eye(9))


@pytest.mark.parametrize("labels", [["male", "female"], ["LABEL_0", "LABEL_1"], ["angry", "20-29"], ["29-20"]])
def test_labels_without_an_age_are_refused(labels: list[str]) -> None:
    with pytest.raises(LabelMappingError, match="no age"):
        groups_from_labels(labels)
