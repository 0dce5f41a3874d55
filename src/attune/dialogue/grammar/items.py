"""What an utterance consists of once its noun phrases and places are recognised."""

from dataclasses import dataclass
from typing import Literal

from attune.core.messages import ObjectSpec, Size

Head = Literal["noun", "one", "bare"]
Role = Literal["from", "to", "at", ""]


@dataclass(frozen=True, slots=True)
class Word:
    """A word that is part of no object and no place."""

    text: str
    capital: bool = False


@dataclass(frozen=True, slots=True)
class Break:
    """Punctuation: "," weak, "." or "?" strong."""

    mark: str


@dataclass(frozen=True, slots=True)
class Thing:
    """A noun phrase.

    Attributes:
        head: A `noun` spoken in full, a pointing `one`, or `bare` properties ("the red").
        definite: "the", "my", "that" or similar.
        article: Any determiner was said.
        count: How many are wanted.
        compared: The size is a comparative ("bigger").
        other: "other" or "different" was said.
        different: "different" was said.
        another: "another" or "one more" was said.
        ordinal: 1 for "the first one", 2 for the second, -1 for the last; 0 for none.
        unknown: It names something the robot does not know ("milk chocolate").
    """

    spec: ObjectSpec
    head: Head = "noun"
    definite: bool = False
    article: bool = False
    count: int = 1
    compared: bool = False
    other: bool = False
    different: bool = False
    another: bool = False
    ordinal: int = 0
    unknown: bool = False


@dataclass(frozen=True, slots=True)
class Spot:
    """A place and the preposition's role: `from` it, `to` it, `at` it, or bare."""

    place: str
    role: Role = ""
    definite: bool = True


Item = Word | Break | Thing | Spot


def described(type_: str, color: str = "", size: Size = "", location: str = "") -> ObjectSpec:
    """A description from its properties in their usual order."""
    return ObjectSpec(type=type_, color=color, size=size, location=location)
