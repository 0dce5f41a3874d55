"""Scores of an interpreter on benchmark items: counts, not averages of percentages."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from attune.evaluation.language.items import Item, Meaning, ObjectSlots

Property = Literal["type", "color", "size", "location"]
PROPERTIES: tuple[Property, ...] = ("type", "color", "size", "location")
Slot = Literal["command", "add", "remove", "destination"]


@dataclass(frozen=True, slots=True)
class Answer:
    """What an interpreter made of an item.

    Attributes:
        meaning: None when it failed to answer.
        seconds: How long it took [s].
        note: Its reason, or the error.
    """

    item: Item
    meaning: Meaning | None
    seconds: float = 0.0
    note: str = ""

    @property
    def wrong(self) -> tuple[Slot, ...]:
        """The slots that are not as expected."""
        expected, meaning = self.item.expected, self.meaning
        if meaning is None or meaning.command != expected.command:
            return ("command",)
        wrong: list[Slot] = []
        if not all(same(expected.add, meaning.add, name) for name in PROPERTIES):
            wrong.append("add")
        if not all(same(expected.remove, meaning.remove, name) for name in PROPERTIES):
            wrong.append("remove")
        if meaning.destination != expected.destination:
            wrong.append("destination")
        return tuple(wrong)


@dataclass(frozen=True, slots=True)
class Tally:
    """How many of how many."""

    right: int
    of: int

    def __str__(self) -> str:
        return f"{self.percent:.2f}" if self.of else "–"

    @property
    def percent(self) -> float:
        """Share in percent; of nothing, 100."""
        return 100.0 * self.right / self.of if self.of else 100.0


@dataclass(frozen=True, slots=True)
class Score:
    """The score on a set of items.

    Attributes:
        command: Items with the right command.
        whole: Items with the right command and every slot right.
        add: Per property, items with an object to bring whose property is right. An object that is missing
            altogether counts as wrong in each property, also in those that were not given.
        remove: The same for objects that are to be dropped.
        destination: Items with the right command whose destination is right.
        false_commands: Non-commands from which a command was made.
        missed_stops: Orders to stop that were not understood as such.
        false_stops: Anything else that was understood as an order to stop.
        failed: Items without a valid answer.
    """

    command: Tally
    whole: Tally
    add: dict[Property, Tally]
    remove: dict[Property, Tally]
    destination: Tally
    false_commands: Tally
    missed_stops: Tally
    false_stops: Tally
    failed: Tally


def same(expected: Sequence[ObjectSlots], found: Sequence[ObjectSlots], name: Property) -> bool:
    """Whether as many objects were found, with the same values of a property, in any order."""
    return Counter(getattr(slots, name) for slots in expected) == Counter(getattr(slots, name) for slots in found)


def score(answers: Iterable[Answer]) -> Score:
    """Score the answers."""
    given = tuple(answers)
    adding = [answer for answer in given if answer.item.expected.add]
    removing = [answer for answer in given if answer.item.expected.remove]
    understood = [answer for answer in given if "command" not in answer.wrong]
    others = [answer for answer in given if answer.item.expected.command == "other"]
    stops = [answer for answer in given if answer.item.expected.command == "stop"]
    not_stops = [answer for answer in given if answer.item.expected.command != "stop"]
    return Score(
        command=Tally(len(understood), len(given)),
        whole=Tally(sum(not answer.wrong for answer in given), len(given)),
        add={name: Tally(sum(_right(answer, "add", name) for answer in adding), len(adding)) for name in PROPERTIES},
        remove={
            name: Tally(sum(_right(answer, "remove", name) for answer in removing), len(removing))
            for name in PROPERTIES
        },
        destination=Tally(sum("destination" not in answer.wrong for answer in understood), len(understood)),
        false_commands=Tally(sum(_said(answer) not in ("other", "") for answer in others), len(others)),
        missed_stops=Tally(sum(_said(answer) != "stop" for answer in stops), len(stops)),
        false_stops=Tally(sum(_said(answer) == "stop" for answer in not_stops), len(not_stops)),
        failed=Tally(sum(answer.meaning is None for answer in given), len(given)),
    )


def _said(answer: Answer) -> str:
    return answer.meaning.command if answer.meaning else ""


def _right(answer: Answer, role: Literal["add", "remove"], name: Property) -> bool:
    return answer.meaning is not None and same(getattr(answer.item.expected, role), getattr(answer.meaning, role), name)
