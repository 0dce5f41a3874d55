"""Transporting: search, fetch, deliver; always from the world as it is, so that it can begin or resume anywhere."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace

from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec
from attune.planner.agenda import Goal
from attune.planner.belief import EXPECTED, Individual
from attune.planner.clearing import Clearing
from attune.planner.combinators import retry
from attune.planner.designators import Spot, free_spots, home_spots, is_delivered, search_order, stands
from attune.planner.desk import Desk
from attune.planner.plan import FAILURES, Node, Part
from attune.planner.recovery import NoSpace, NotFound, recoveries
from attune.planner.skills import Skills
from attune.robots.interface import Collision, ObjectNotThere, PathBlocked, PlacementFailed, Unreachable

FAILED_TRIED = 2
"""Places that could not be looked into at first and are tried once more at the end."""
HIDDEN_TRIED = 3
"""Places that are looked at once more if something may stand there behind something else."""
SPOTS_TRIED = 5
"""Free spots tried before a place counts as out of reach."""
SPOT_SPACING = 0.12
"""From each spot that was tried to the next, times the number tried [m]: the longer, the farther."""
LEAST_SPACING = 0.05
"""Where there is none so far away, the farthest is tried, if it is farther than this [m]."""


def transport(desk: Desk, skills: Skills, goal: Goal) -> Part[None]:
    """Bring the object of a goal to where it is wanted, with recovery; closes its delivery when it is there."""
    delivery = desk.agenda.get(goal.delivery)
    verb = f"bring to the {goal.destination}" if goal.destination else "put back"
    work = Transport(desk, skills, goal)
    return retry(f"{verb}: {delivery.spec}", work.attempt, work.recoveries)


class Transport:
    """One goal being worked on."""

    def __init__(self, desk: Desk, skills: Skills, goal: Goal) -> None:
        self._desk = desk
        self._skills = skills
        self._belief = desk.belief
        self._scene = desk.scene
        self._goal = goal
        self._clearing = Clearing(desk, skills, goal)
        self.recoveries = recoveries(skills, self._clearing.clear_way, self._clearing.make_room)
        """What is done after an attempt has failed."""
        self._must_lift = False
        self._must_regrasp = False

    def attempt(self, number: int) -> Part[None]:
        """One attempt from the world as it is."""

        async def body(node: Node) -> None:
            board = self._desk.board
            self._skills.reconcile()  # A grasp that failed late may hold the object all the same.
            delivery = self._desk.agenda.get(self._goal.delivery)
            board.update(
                step="set_parameters",
                object=self._described(),
                command=delivery.command,
                destination_location=self._destination(self._item()),
            )
            if not self._skills.parked:  # An interruption or a failure may have left the arms anywhere.
                await node.do(self._skills.park())
            if self._clearing.is_unfinished:
                await node.do(self._clearing.finish())
            item = self._item()
            if item and item.held_by and self._must_regrasp:
                with suppress(Unreachable, PathBlocked, NoSpace):  # Else it is tried once more as it is held.
                    await node.do(self._clearing.set_down(item))
                item = self._item()
                self._must_regrasp = bool(item and not item.held_by)
            if item is None or not item.held_by:
                item = await node.do(self._search())
                # What was not seen at first, or stands a little aside, may stand well all the same.
                self._must_lift = self._must_lift and not stands(item)
                if self._is_there(item) and not (self._must_lift or self._must_regrasp):
                    board.update(step="already_done")
                    self._desk.close(self._goal, item, "" if item.displaced else "already_there")
                    return
                await node.do(self._prepare(item))
                item = await node.do(self._fetch(item, number))
            await node.do(self._deliver(item))

        return Part(f"attempt {number + 1}", body)

    # --- search ------------------------------------------------------------------------------------------------

    def _search(self) -> Part[Individual]:
        async def body(node: Node) -> Individual:
            board = self._desk.board
            item = self._item()
            if item and item.percept and item.surface and item.confidence > EXPECTED:
                return item
            delivery = self._desk.agenda.get(self._goal.delivery)
            spec = delivery.spec
            returning = not self._goal.destination
            if returning or self._must_lift:
                spec = ObjectSpec(name=delivery.individual)
            taken = self._desk.agenda.reserved - {delivery.individual}

            # What the robot itself has taken from where the person said may be anywhere now.
            own = delivery.individual if item and item.displaced else ""
            places = replace(spec, location="") if own else spec

            def fits(seen: Individual) -> bool:
                wanted = seen.is_a(spec) and spec.location in {"", self._belief.place_of(seen)}
                return seen.name not in taken and (wanted or seen.name == own)

            order = [surface.name for surface in search_order(self._scene, self._belief, places, taken)]
            if item and item.surface:
                order = list(dict.fromkeys((item.surface, *order)))
            because: AttuneError | None = None
            failed: list[str] = []

            async def look(
                name: str, fitting: Callable[[Individual], bool], *, again: bool = False
            ) -> Individual | None:
                nonlocal because
                surface = self._scene.surface(name)
                board.update(step="transporting_search", object=self._described(), destination_location=surface.place)
                try:
                    found = await node.do(self._skills.look_over(surface, fitting, again=again))
                except Collision:
                    raise  # What was touched stays in the way until it has been seen.
                except FAILURES as failure:
                    because = because or failure
                    failed.append(name)
                    return None  # A place that cannot be looked into does not end the search.
                if found:
                    self._desk.reserve(self._goal, found.name)
                return found

            rounds = [(name, fits) for name in order]
            if own and item and item.surface:  # Its like may stand beside it.
                rounds.insert(0, (item.surface, lambda seen: seen.name == own))
            for name, fitting in rounds:
                if found := await look(name, fitting):
                    return found
            for name in failed[:FAILED_TRIED]:
                if found := await look(name, fits):
                    return found
            for name in [name for name in order if name in self._skills.hiders()][:HIDDEN_TRIED]:
                if found := await look(name, fits, again=True):
                    return found
            hiders = self._skills.hiders()
            hider = next((hiders[name] for name in order if name in hiders), None)
            raise NotFound(delivery.spec, because, self._belief.describe(hider) if hider else None)

        return Part("search", body)

    # --- prepare, fetch and deliver ----------------------------------------------------------------------------

    def _prepare(self, item: Individual) -> Part[None]:
        """Open what the object is to be put into while both hands are free; if that fails, it is tried again later."""

        async def body(node: Node) -> None:
            spot = self._next_spot(item, [])
            self._skills.destined = spot.surface.container if spot else ""
            if spot and self._skills.destined:
                self._desk.board.update(destination_location=spot.surface.place)
                try:
                    await node.do(self._skills.open_for(spot.surface))
                    await node.do(self._skills.glance(spot.surface))  # With full hands less of it is seen.
                except FAILURES:
                    return

        return Part("prepare the destination", body)

    def _fetch(self, item: Individual, attempt: int) -> Part[Individual]:
        arms = self._skills.robot.arms
        arm = None if attempt == 0 else arms[attempt % len(arms)]

        async def body(node: Node) -> Individual:
            self._desk.board.update(
                step="transporting_fetch",
                object=self._belief.describe(item),
                destination_location=self._belief.place_of(item),
            )
            spot = self._next_spot(item, [])
            goal = spot.position if spot else None
            if spot and self._must_regrasp and math.isfinite(spot.surface.clearance):
                goal = None  # Held as is usual under a board it could not be put there: this time in any way.
            await node.do(self._skills.pick(item, arm, goal))
            self._must_lift = self._must_regrasp = False
            held = self._belief.get(item.name)
            if held is None:
                raise ObjectNotThere(item.name)
            return held

        return Part("fetch", body)

    def _deliver(self, item: Individual) -> Part[None]:
        async def body(node: Node) -> None:
            self._desk.board.update(
                step="transporting_deliver",
                object=self._belief.describe(item),
                destination_location=self._destination(item),
            )
            tried: list[Spot] = []
            failure: Unreachable | PathBlocked | None = None
            while len(tried) < SPOTS_TRIED and (spot := self._next_spot(item, tried)):
                tried.append(spot)
                try:
                    await node.do(self._put(item, spot))
                except (Unreachable, PathBlocked) as error:
                    failure = error
                    continue
                self._desk.close(self._goal, item)
                return
            if next(self._spots(item), None) is None:  # Where there seemed to be room something stands.
                raise NoSpace(self._destination(item))
            # Perhaps it can be put there if it is held in another way.
            self._must_regrasp = bool(tried) and isinstance(failure, Unreachable)
            raise failure or NoSpace(self._destination(item))

        return Part("deliver", body)

    def _put(self, item: Individual, spot: Spot) -> Part[None]:
        async def body(node: Node) -> None:
            if not item.held_by:
                raise ObjectNotThere(item.name)
            try:
                await node.do(self._skills.place(item, item.held_by, spot))
            except PlacementFailed:
                self._must_lift = True
                raise

        return Part("put it down", body)

    def _spots(self, item: Individual) -> Iterator[Spot]:
        if self._goal.destination:
            return free_spots(self._scene, self._belief, self._goal.destination, item)
        return home_spots(self._scene, self._belief, item)

    def _next_spot(self, item: Individual, tried: list[Spot]) -> Spot | None:
        if not tried:
            return next(self._spots(item), None)

        def away(spot: Spot) -> float:
            return min(math.dist(spot.position, other.position) for other in tried)

        new = [spot for spot in self._spots(item) if away(spot) >= LEAST_SPACING]
        far = next((spot for spot in new if away(spot) >= SPOT_SPACING * len(tried)), None)
        # In a narrow compartment a spot a little aside may be reached all the same.
        return far or max(new, key=away, default=None)

    # --- what it is about --------------------------------------------------------------------------------------

    def _item(self) -> Individual | None:
        return self._belief.get(self._desk.agenda.get(self._goal.delivery).individual)

    def _described(self) -> ObjectSpec:
        item = self._item()
        return self._belief.describe(item) if item else self._desk.agenda.get(self._goal.delivery).spec

    def _destination(self, item: Individual | None) -> str:
        if self._goal.destination or item is None or not item.home.surface:
            return self._goal.destination
        return self._scene.surface(item.home.surface).place

    def _is_there(self, item: Individual) -> bool:
        if self._goal.destination:
            return is_delivered(self._scene, item, self._goal.destination)
        return bool(item.surface) and not item.displaced
