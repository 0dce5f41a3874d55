"""What the commands of a run want: a small model of their meaning that knows nothing of the planner.

A wish is an object type at a kind of place. Commands make, redirect and end wishes; the final world must be what the
wishes that are left say. What a command is about depends on how far the robot was when it came, which is read from the
true world of that moment. An object that stands where it is wanted but was not reported yet may count as delivered or
as still to come: then there are several right worlds.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

from attune.core.messages import CommandOutcome
from attune.core.scene import Scene
from attune.evaluation.kitchen import moved
from attune.evaluation.planner_sayings import Saying
from attune.robots.simulated import TrueObject

World = Mapping[str, TrueObject]
Phase = Literal["pending", "delivered"]


@dataclass(frozen=True, slots=True)
class Wish:
    """An object of a type, wanted at a kind of place by the command of this number, from a `source` if one is named."""

    type: str
    place: str
    command: int
    source: str = ""


Wishes = tuple[Wish, ...]


@dataclass(frozen=True, slots=True)
class Moment:
    """When a command came: the true world, and all that had been told about any command."""

    world: World
    told: tuple[CommandOutcome, ...] = ()


@dataclass(frozen=True, slots=True)
class Effect:
    """What a command may do: whether there is anything to do for it, and the wishes then."""

    possible: bool
    wishes: Wishes


class Oracle:
    """Says what a command means.

    Args:
        scene: Tells which surfaces are which kind of place.
        before: The world at the beginning.
        destination: Where things are brought when no place is named.
        breakfast: Types of the breakfast.
    """

    def __init__(self, scene: Scene, before: World, destination: str, breakfast: tuple[str, ...]) -> None:
        self._kinds = {surface.name: surface.place for surface in scene.surfaces}
        self._before = before
        self._destination = destination
        self._breakfast = breakfast
        self._stock = Counter(thing.spec.type for thing in before.values())

    def effects(
        self, number: int, saying: Saying, wishes: Wishes, moment: Moment, there: Counter[str], *, stopped: bool
    ) -> set[Effect]:
        """All that a command may rightly do.

        Args:
            number: Of the command.
            saying: The command.
            wishes: What was wanted before.
            moment: When it came.
            there: What the robot says that stands at the destination anyway, and that does.
            stopped: The robot was stopped before and starts afresh.
        """
        if saying.kind in {"stop", "carry_on"}:
            return {Effect(possible=True, wishes=wishes)}
        if stopped:  # What stands somewhere stays there, all else is forgotten.
            wishes = tuple(Wish(type_, place, -1) for type_, place in self._brought(moment))
        found: set[Effect] = set()
        for phases in product(*(self._phases(wish, moment) for wish in wishes)):
            delivered = {wish for wish, phase in zip(wishes, phases, strict=True) if phase == "delivered"}
            after = self._edit(number, saying, wishes, delivered, moment, there)
            found.add(Effect(after is not None, wishes if after is None else after))
        return found

    def _edit(
        self, number: int, saying: Saying, wishes: Wishes, delivered: set[Wish], moment: Moment, there: Counter[str]
    ) -> Wishes | None:
        """The wishes after a command; None when there is nothing to do for it."""
        after: Wishes | None = None
        match saying.kind:
            case "bring_me":
                after = self._bring(number, saying, wishes, there)
            case "setting_breakfast":
                standing = {wish.type for wish in wishes if wish.place == self._destination}
                new = tuple(
                    Wish(type_, self._destination, number) for type_ in self._breakfast if type_ not in standing
                )
                after = (*wishes, *new) if new else None
            case "replace_object":
                after = self._replace(number, saying, wishes, there)
            case "change_location":
                after = self._change_location(number, saying, wishes, delivered, moment)
            case "cancel_object":
                meant = next((wish for wish in wishes if wish.type == saying.type and wish not in delivered), None)
                after = self._cancel(wishes, meant, moment) if meant else None
            case "put_back":
                after = self._put_back(wishes, moment)
        return after

    def _bring(self, number: int, saying: Saying, wishes: Wishes, there: Counter[str]) -> Wishes | None:
        place = saying.place or self._destination
        left = self._left(wishes) + there
        new = [type_ for type_ in saying.types if left[type_] > 0]
        if not new:
            return None
        sources = {saying.type: saying.source}
        return (
            *wishes,
            *(Wish(type_, place, number, sources.get(type_, "")) for type_ in new if not there[type_]),
        )

    def _replace(self, number: int, saying: Saying, wishes: Wishes, there: Counter[str]) -> Wishes | None:
        old = next((wish for wish in wishes if wish.type == saying.instead_of), None)
        if there[saying.type]:
            return _without(wishes, old)
        if self._left(wishes)[saying.type] <= 0:
            return None
        return (*_without(wishes, old), Wish(saying.type, old.place if old else self._destination, number))

    def _change_location(
        self, number: int, saying: Saying, wishes: Wishes, delivered: set[Wish], moment: Moment
    ) -> Wishes | None:
        held = self._held(moment)
        if saying.type:
            meant = [wish for wish in wishes if wish.type == saying.type][:1]
            new = not meant and (saying.type in held or self._left(wishes)[saying.type] > 0)
            found = [saying.type] if new else []
        else:
            meant = [wish for wish in wishes if wish not in delivered]
            found = [] if meant else held
            if not meant and not held and delivered:
                last = self._last(delivered, moment)
                meant = [wish for wish in wishes if wish in delivered and wish.command == last.command]
        redirected = [wish for wish in meant if wish.place != saying.place]
        if not redirected and not found:
            return None
        return (
            *(replace(wish, place=saying.place) if wish in redirected else wish for wish in wishes),
            *(Wish(type_, saying.place, number) for type_ in found),
        )

    def _cancel(self, wishes: Wishes, meant: Wish, moment: Moment) -> Wishes:
        """What was delivered, and should have been brought elsewhere, stays where it is."""
        stays = [Wish(type_, place, -1) for type_, place in self._brought(moment) if type_ == meant.type]
        stays = [wish for wish in stays if wish.place != meant.place][:1]
        return (*_without(wishes, meant), *stays)

    def _put_back(self, wishes: Wishes, moment: Moment) -> Wishes | None:
        held = self._held(moment)
        if held:
            return _without(wishes, next((wish for wish in wishes if wish.type in held), None))
        brought = {type_ for type_, _ in self._brought(moment)}
        standing = {wish for wish in wishes if self._stands(wish, moment)}
        standing = standing or {wish for wish in wishes if wish.type in brought}
        return _without(wishes, self._last(standing, moment)) if standing else None

    # --- what the world of that moment says ----------------------------------------------------------------------

    def _brought(self, moment: Moment) -> list[tuple[str, str]]:
        """Type and kind of place of the objects that stand elsewhere than at the beginning."""
        where = moved(self._before, moment.world)
        return [
            (moment.world[name].spec.type, self._kinds[surface])
            for name, surface in where.items()
            if surface in self._kinds
        ]

    def _phases(self, wish: Wish, moment: Moment) -> tuple[Phase, ...]:
        if not self._stands(wish, moment):
            return ("pending",)
        return ("delivered",) if self._reported(wish, moment) >= 0 else ("pending", "delivered")

    def _stands(self, wish: Wish, moment: Moment) -> bool:
        """Whether an object of that type was brought to that place."""
        return (wish.type, wish.place) in self._brought(moment)

    def _reported(self, wish: Wish, moment: Moment) -> int:
        """Which of the outcomes reported its delivery last; -1 for none."""
        reports = (
            index
            for index, outcome in enumerate(moment.told)
            if outcome.status == "done" and outcome.object.type == wish.type and outcome.place == wish.place
        )
        return max(reports, default=-1)

    def _last(self, delivered: set[Wish], moment: Moment) -> Wish:
        """The one that was delivered last; what was not reported yet has just been put down."""

        def when(wish: Wish) -> int:
            index = self._reported(wish, moment)
            return index if index >= 0 else len(moment.told)

        return max(delivered, key=when)

    def _held(self, moment: Moment) -> list[str]:
        return [thing.spec.type for thing in moment.world.values() if thing.held_by]

    def _left(self, wishes: Wishes) -> Counter[str]:
        """Objects that nobody asked for yet, by type."""
        return self._stock - Counter(wish.type for wish in wishes)

    # --- the final world ----------------------------------------------------------------------------------------

    def misplaced(self, after: World, wishes: Wishes, earlier: Wishes, *, may_be_partial: bool) -> str:
        """How the places of the objects differ from the wishes; "" when they are right.

        Args:
            after: The final world.
            wishes: What is wanted in the end.
            earlier: All that was ever wanted.
            may_be_partial: The robot was stopped: it may hold something, not have brought all, or not have moved on
                what it had brought before.
        """
        where = {name: self._kinds.get(now, now) for name, now in moved(self._before, after).items()}
        wanted = Counter((wish.type, wish.place) for wish in wishes)
        if may_be_partial:
            where = {name: now for name, now in where.items() if now != "hand"}
            wanted |= Counter(set((wish.type, wish.place) for wish in earlier))
        brought = Counter((after[name].spec.type, now) for name, now in where.items())
        if not (brought <= wanted if may_be_partial else brought == wanted):
            return f"brought {_words(brought)} instead of {_words(wanted)}"
        return "" if may_be_partial else "".join(self._wrong_sources(wishes, where))

    def _wrong_sources(self, wishes: Wishes, where: Mapping[str, str]) -> Iterator[str]:
        for wish in wishes:
            from_there = (
                name
                for name, now in where.items()
                if now == wish.place
                and self._before[name].spec.type == wish.type
                and wish.source in {"", self._before[name].spec.location}
            )
            if not any(from_there):
                yield f"the {wish.type} is not the one from the {wish.source}"


def _without(wishes: Wishes, one: Wish | None) -> Wishes:
    return tuple(wish for wish in wishes if wish != one)


def _words(counts: Counter[tuple[str, str]]) -> str:
    return ", ".join(f"{type_} to the {place}" for type_, place in sorted(counts.elements())) or "nothing"
