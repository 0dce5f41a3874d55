"""Moving aside what is in the way of taking an object, or of putting one down. Each is told before, and believed after.

What was moved out of the way of the hand is brought back when there is nothing else to do; what was moved to make room
stays where it was put. What was delivered in the present task is at most shifted on its own surface.
"""

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain

from attune.core.errors import AttuneError
from attune.core.scene import Surface
from attune.planner.agenda import Goal
from attune.planner.belief import Individual
from attune.planner.designators import Spot, delivery_surfaces, fits, free_spots, spots_on
from attune.planner.desk import Desk
from attune.planner.plan import FAILURES, Node, Part
from attune.planner.recovery import NoSpace
from attune.planner.skills import Skills
from attune.robots.interface import PathBlocked, PickTarget, Unreachable

CONSIDERED = 4
"""Neighbours of an object that may be in the way of the hand: so many of the nearest."""
AWAY = 0.35
"""From an object to what was in the way of it, at least, if that stays on the same surface [m]."""
SPOTS_TRIED = 4
"""Spots tried for what is moved aside."""
APART = 0.15
"""Between these, at least [m]."""


class Clearing:
    """Moves things aside for one goal.

    Args:
        desk: What is wanted and believed.
        skills: The robot.
        goal: What they are in the way of.
    """

    def __init__(self, desk: Desk, skills: Skills, goal: Goal) -> None:
        self._desk = desk
        self._skills = skills
        self._belief = desk.belief
        self._scene = desk.scene
        self._goal = goal
        self._stuck: set[str] = set()
        """What could not be moved."""

    def clear_way(self) -> Part[None]:
        """If the object could be taken were it not for others: move these aside."""

        async def body(node: Node) -> None:
            item = self._item()
            for blocker in await self._blockers(item) if item and not item.held_by else ():
                await node.do(self._move(blocker, self._spots_aside(blocker, item), back=True))

        return Part("clear the way", body)

    def make_room(self) -> Part[None]:
        """Move something that stands at the destination, so that the object has room there."""

        async def body(node: Node) -> None:
            item = self._item()
            if item is None or not self._goal.destination:
                return
            move = self._move_for_room(item)
            if move is None:
                raise NoSpace(self._goal.destination)
            if item.held_by:  # The other hand alone might not reach there, and some robots have none.
                with suppress(Unreachable, PathBlocked, NoSpace):
                    await node.do(self.set_down(item))
            neighbour, spot = move
            await node.do(self._move(neighbour, chain((spot,), self._spots_aside(neighbour, None)), back=False))

        return Part("make room", body)

    @property
    def is_unfinished(self) -> bool:
        """Whether something is held that was being moved aside."""
        return any(item.name in self._desk.aside for item in self._belief.held().values())

    def finish(self) -> Part[None]:
        """Put down what is still held of what was being moved aside when that was interrupted."""

        async def body(node: Node) -> None:
            for item in self._belief.held().values():
                if item.name in self._desk.aside:
                    self._desk.board.update(step="clearing", object=self._belief.describe(item))
                    await node.do(self._put_aside(item.name, self._spots_aside(item, self._item()), back=True))

        return Part("put aside what is held", body)

    # --- what is in the way ------------------------------------------------------------------------------------

    async def _blockers(self, item: Individual) -> tuple[Individual, ...]:
        """The objects without which an object could be taken: as few, and as near to it, as possible."""
        percept, position = item.percept, item.position
        if percept is None or position is None:
            return ()

        async def reachable(*without: Individual) -> bool:
            target = PickTarget(percept, without=tuple(other.name for other in without))
            return bool(await self._skills.robot.base_poses(target))

        near = sorted(self._movable(item), key=lambda other: math.dist(other.position or position, position))
        near = near[:CONSIDERED]
        if not near or await reachable() or not await reachable(*near):
            return ()
        for other in near:
            if await reachable(other):
                return (other,)
        for count in range(2, len(near)):
            if await reachable(*near[:count]):
                return tuple(near[:count])
        return tuple(near)

    def _movable(self, item: Individual) -> list[Individual]:
        """What is known to stand on the same surface as an object."""
        return [
            other
            for other in self._belief.on(item.surface)
            if other.name not in {item.name, *self._stuck} and other.position and other.percept
        ]

    def _move_for_room(self, item: Individual) -> tuple[Individual, Spot] | None:
        """What to move where, so that there is a free spot at the destination: as little as possible."""
        place = self._goal.destination
        neighbours = [
            other
            for surface in delivery_surfaces(self._scene, place, item)
            for other in self._belief.on(surface.name)
            if other.name not in {item.name, *self._stuck} and other.position and other.percept
        ]
        shifts = [
            (math.dist(other.position or spot.position, spot.position), other, spot)
            for other in neighbours
            for spot in spots_on(self._belief, self._scene.surface(other.surface), other)
        ]
        shifts.sort(key=lambda shift: shift[0])
        options = [(other, spot) for _, other, spot in shifts]
        for other in neighbours:
            spot = next(self._spots_aside(other, None), None)
            if spot and spot.surface.name != other.surface:
                options.append((other, spot))
        tight: tuple[Individual, Spot] | None = None
        for other, spot in options:
            then = self._belief.supposing(other.name, spot.surface.name, spot.position)
            free = next(free_spots(self._scene, then, place, item), None)
            if free and not free.tight:
                return other, spot
            tight = tight or ((other, spot) if free else None)
        return tight

    # --- moving it ---------------------------------------------------------------------------------------------

    def _move(self, item: Individual, spots: Iterable[Spot], *, back: bool) -> Part[None]:
        async def body(node: Node) -> None:
            spot = next(iter(spots), None)
            if spot is None:
                self._stuck.add(item.name)
                raise NoSpace(self._belief.place_of(item))
            self._desk.board.update(
                step="clearing",
                object=self._belief.describe(item),
                destination_location=self._belief.place_of(item),
            )
            self._desk.aside[item.name] = self._goal.delivery
            try:
                await node.do(self._skills.pick(item, None, spot.position))
                await node.do(self._put_aside(item.name, chain((spot,), spots), back=back))
            except FAILURES:
                self._stuck.add(item.name)
                raise

        return Part(f"move {item.name} aside", body)

    def _put_aside(self, name: str, spots: Iterable[Spot], *, back: bool) -> Part[None]:
        """Put something that is held on one of some spots; `back`: it is brought home when there is time."""

        async def body(node: Node) -> None:
            await node.do(self._put_on_one_of(name, spots))
            self._desk.moved_aside(name, back=back)

        return Part(f"put {name} aside", body)

    def set_down(self, item: Individual) -> Part[None]:
        """Put what is held on a free spot of an open surface nearby: the nearest of each surface before others."""
        spots = list(self._open_spots(item))
        nearest = {spot.surface.name: spot for spot in reversed(spots)}
        spots.sort(key=lambda spot: nearest[spot.surface.name] is not spot)
        return self._put_on_one_of(item.name, spots)

    def _put_on_one_of(self, name: str, spots: Iterable[Spot]) -> Part[None]:
        """Put something that is held on the first of some spots that can be reached, of those that are apart."""

        async def body(node: Node) -> None:
            failure: AttuneError | None = None
            tried: list[Spot] = []
            for spot in spots:
                item = self._belief.get(name)
                if item is None or not item.held_by or len(tried) == SPOTS_TRIED:
                    break
                if any(math.dist(spot.position, other.position) < APART for other in tried):
                    continue
                tried.append(spot)
                try:
                    await node.do(self._skills.place(item, item.held_by, spot))
                except (Unreachable, PathBlocked) as error:
                    failure = error
                    continue
                return
            raise failure or NoSpace("")

        return Part(f"put {name} down for a while", body)

    def _spots_aside(self, item: Individual, wanted: Individual | None) -> Iterator[Spot]:
        """Where something that is in the way of a wanted thing can be put: not before the hand, if possible."""
        surface = self._scene.surface(item.surface or item.taken_from)
        for spot in self._near(spots_on(self._belief, surface, item)):
            aside = wanted is None or wanted.position is None or math.dist(wanted.position, spot.position) > AWAY
            if aside and not surface.container:
                yield spot
        if item.name not in self._delivered():
            yield from self._open_spots(item, surface)

    def _open_spots(self, item: Individual, other_than: Surface | None = None) -> Iterator[Spot]:
        """Free spots on open surfaces, the nearest first; those at the destination last."""
        spots = [
            spot
            for surface in self._scene.surfaces
            if not surface.container and surface is not other_than and fits(self._scene, item, surface)
            for spot in spots_on(self._belief, surface, item)
        ]
        yield from sorted(self._near(spots), key=lambda spot: spot.surface.place == self._goal.destination)

    def _near(self, spots: Iterable[Spot]) -> list[Spot]:
        base = self._skills.robot.status().base
        return sorted(spots, key=lambda spot: math.dist(spot.position[:2], (base.x, base.y)))

    # --- what it is about --------------------------------------------------------------------------------------

    def _item(self) -> Individual | None:
        return self._belief.get(self._desk.agenda.get(self._goal.delivery).individual)

    def _delivered(self) -> set[str]:
        """What the person has got in the present task, and where they want it."""
        return {item.individual for item in self._desk.agenda.task if item.status == "delivered"}
