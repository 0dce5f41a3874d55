"""From years, labels and probabilities to the nine age groups and the two bands of the paper."""

import math
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS, AgeGroup

OLDER_FROM: AgeGroup = "sixties"
"""The first group that counts as older. The paper puts the threshold "at the age group fifties", and leaves open on
which side the fifties lie; `docs/age.md` discusses both readings."""

FIRST_DECADE = 10
"""Years at which the group `teens` begins; whoever is younger counts as `teens`."""

PAPER_BINARY_ACCURACY = 0.978
PAPER_GROUP_ACCURACY = 0.595
"""What the paper reports on its own split of Common Voice 11.0 (section 4.1)."""

_WORDS: dict[str, tuple[int, int]] = {
    "child": (0, 12),
    "children": (0, 12),
    "kid": (0, 12),
    "teen": (13, 19),
    "teens": (13, 19),
    "teenager": (13, 19),
    "young": (18, 35),
    "youth": (13, 29),
    "twenties": (20, 29),
    "thirties": (30, 39),
    "fourties": (40, 49),
    "forties": (40, 49),
    "fifties": (50, 59),
    "sixties": (60, 69),
    "seventies": (70, 79),
    "eighties": (80, 89),
    "nineties": (90, 99),
    "adult": (20, 59),
    "adults": (20, 59),
    "middle": (40, 59),
    "senior": (60, 99),
    "seniors": (60, 99),
    "elderly": (60, 99),
    "old": (60, 99),
}
"""Words in the labels of published classifiers, with the years that they cover, both ends included."""

_RANGE = re.compile(r"(?<!\d)(\d{1,3})\s*(?:-|–|_|to)\s*(\d{1,3})(?!\d)")
_OPEN = re.compile(r"(?<!\d)(\d{2})\s*(?:\+|plus|and over|or older)")
_DECADE = re.compile(r"(?<!\d)(\d0)s\b")
_OLDEST = 99


class LabelMappingError(AttuneError):
    """The labels of a classifier cannot be mapped to the nine groups."""

    def __init__(self, labels: Sequence[str]) -> None:
        shown = ", ".join(repr(label) for label in labels[:6])
        super().__init__(
            f"no age can be read from the model's labels {shown}",
            "Take a model whose labels name ages, such as 'twenties', '20-29' or '60+'",
        )


def group_of_years(years: float) -> AgeGroup:
    """The group of somebody of that age; under 10 counts as `teens`, from 100 on as `nineties`."""
    return AGE_GROUPS[min(max(int(years) // 10 - FIRST_DECADE // 10, 0), len(AGE_GROUPS) - 1)]


def groups_from_years(years: float, spread: float = 10.0) -> NDArray[np.float64]:
    """The distribution that a regression's answer stands for: a normal one around it.

    Args:
        years: The estimated age.
        spread: Its standard deviation [years]. Published regressions miss by 7 to 11 years on average, which is a
            standard deviation of about 9 to 14.

    Returns:
        Shape (9,), sums to 1.
    """
    edges = [FIRST_DECADE + 10 * index for index in range(1, len(AGE_GROUPS))]
    below = [0.0, *(0.5 * (1 + math.erf((edge - years) / (spread * math.sqrt(2)))) for edge in edges), 1.0]
    return np.diff(np.array(below))


def groups_from_labels(labels: Sequence[str]) -> NDArray[np.float64]:
    """How a classifier's labels spread over the nine groups.

    A label may carry more than the age (`female_20-29`). The years that a label covers are taken as equally likely.
    Nine labels without meaning (`LABEL_0` ..., or numbers) are taken as the nine groups in their order, as in the
    checkpoint of the paper's authors.

    Returns:
        Shape (number of labels, 9), each row sums to 1: `probabilities_of_labels @ matrix` is over the groups.

    Raises:
        LabelMappingError: A label names no age.
    """
    if len(labels) == len(AGE_GROUPS) and all(re.fullmatch(r"(LABEL_)?\d", label) for label in labels):
        return np.eye(len(AGE_GROUPS))
    counts = np.zeros((len(labels), len(AGE_GROUPS)))
    for row, label in zip(counts, labels, strict=True):
        years = _years_of(label)
        if years is None:
            raise LabelMappingError(labels)
        for year in range(years[0], years[1] + 1):
            row[AGE_GROUPS.index(group_of_years(year))] += 1
    return np.asarray(counts / counts.sum(axis=1, keepdims=True))


def probability_older(probabilities: Sequence[float] | NDArray[np.float64], older_from: AgeGroup = OLDER_FROM) -> float:
    """The share of the groups from `older_from` on."""
    return float(np.sum(np.asarray(probabilities)[AGE_GROUPS.index(older_from) :]))


def _years_of(label: str) -> tuple[int, int] | None:
    text = label.lower()
    if found := _RANGE.search(text):
        first, last = int(found[1]), int(found[2])
        return (first, last) if first <= last else None
    if found := _OPEN.search(text):
        return int(found[1]), _OLDEST
    if found := _DECADE.search(text):
        return int(found[1]), int(found[1]) + 9
    spans = [_WORDS[word] for word in re.split(r"[^a-z]+", text) if word in _WORDS]
    return spans[0] if spans else None
