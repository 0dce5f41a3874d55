"""What one utterance asks for, as far as it has been read."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from attune.core.messages import ObjectSpec
from attune.dialogue.grammar.references import fits


@dataclass(slots=True)
class Wanted:
    """What one utterance asks for, while it is read."""

    add: list[ObjectSpec] = field(default_factory=list)
    definite: list[bool] = field(default_factory=list)
    remove: list[ObjectSpec] = field(default_factory=list)
    destination: str = ""
    moves: bool = False
    put_back: bool = False
    contrast: bool = False
    unresolved: bool = False
    indirect: bool = False
    pronoun: bool = False
    asked: bool = False
    framed: bool = False
    unknown: str = ""
    topics: list[ObjectSpec] = field(default_factory=list)

    def locate(self, first: int, end: int, place: str, before: str) -> None:
        """Give a place to the thing before it, and to those it is listed with without a pause.

        Args:
            first: The first of the things in `add` that it may belong to.
            end: The one after the last of them.
            place: Where they are.
            before: The skeleton up to the place.
        """
        separate = re.search(r"(?:, and|\bP\d+ (?:and|,)|,) T\d+(?: \w+)?$", before.rstrip()) is not None
        for index in range(max(end - 1 if separate else first, 0), min(end, len(self.add))):
            self.add[index] = replace(self.add[index], location=self.add[index].location or place)


def same_request(spec: ObjectSpec, objects: Sequence[ObjectSpec]) -> bool:
    """Whether the robot is already about this object."""
    return any(has.type == spec.type and fits(spec, has) for has in objects)
