"""What the robot can do, as parts of a plan that publish the state before anything moves."""

import math
from collections.abc import AsyncIterator, Callable
from collections.abc import Set as AbstractSet
from contextlib import asynccontextmanager
from typing import Literal, TypeVar

from attune.core.clock import Clock
from attune.core.scene import Scene, Surface
from attune.planner.belief import Belief, Individual
from attune.planner.combinators import atomic_while, monitor
from attune.planner.designators import Spot, is_clear, is_crowded, look_points, middle
from attune.planner.plan import Node, Part
from attune.planner.state import StateBoard
from attune.robots.interface import (
    Arm,
    BasePose,
    ContainerStuck,
    LookTarget,
    ObjectLost,
    ObjectNotThere,
    OpenTarget,
    PathBlocked,
    Percept,
    PickTarget,
    PlaceTarget,
    Point,
    Robot,
    RobotFailure,
    Target,
    Unreachable,
)

T = TypeVar("T")

POSES_TRIED = 3
"""Base poses from which one thing is tried before it counts as out of reach."""
VIEWS = 3
"""Sides from which a surface is looked over before a thing counts as missing there."""
SAME = 0.03
"""Base poses nearer than this, facing the same way, are the same [m]."""


class Skills:
    """Makes parts that move the robot and keep belief and state up to date."""

    def __init__(self, robot: Robot, scene: Scene, clock: Clock, belief: Belief, board: StateBoard) -> None:
        self.robot = robot
        self.scene = scene
        self.clock = clock
        self.belief = belief
        self.board = board
        self.parked = False
        """Whether the arms are known to be out of the way."""
        self.destined = ""
        """The container into which the present delivery goes: opened with free hands, it stays open till the end."""
        self._left_open: set[str] = set()
        self.placing: Spot | None = None
        """Where something is being put down at this moment."""

    def reconcile(self) -> None:
        """After an interruption: believe of the grippers what the robot says."""
        where = self.placing
        self.belief.reconcile(
            self.robot.status().holding, where.surface.name if where else "", where.position if where else None
        )

    # --- moving ------------------------------------------------------------------------------------------------

    def drive(self, goal: BasePose, place: str) -> Part[None]:
        """Park the arms and drive; what is held is watched on the way."""

        async def navigate(_: Node) -> None:
            async with self._moving(base=True):
                await self.robot.navigate(goal)
            self.board.note(current_location=place)

        async def body(node: Node) -> None:
            base = self.robot.status().base
            turn = abs(math.remainder(base.yaw - goal.yaw, math.tau))
            if math.dist((base.x, base.y), (goal.x, goal.y)) < 0.01 and turn < 0.02:
                return
            if not self.parked:
                await node.do(self.park())
            await node.do(Part("navigate", navigate))

        return self._watching_hands(f"drive to the {place}" if place else "drive", Part("move", body))

    def at_base_pose(
        self,
        name: str,
        target: Target,
        act: Part[T],
        place: str,
        *,
        what: str = "",
        keep_open: str | None = "",
        skip: int = 0,
    ) -> Part[T]:
        """Drive to where the target can be reached and act; from the next best pose when that does not work.

        Args:
            name: Of the part.
            target: What is to be reached.
            act: What to do there.
            place: The kind of place it is at.
            what: Is to be reached, for the failure; the part's name when not given.
            keep_open: The container that must stay open. Others are closed before if the hands are free, for that is
                hard with full ones; else only if they are in the way. None leaves all as they are.
            skip: So many of the best poses come last.
        """

        def attempt(pose: BasePose) -> Part[T]:
            async def body(node: Node) -> T:
                await node.do(self.drive(pose, place))
                return await node.do(act)

            return Part("from this pose", body)

        async def body(node: Node) -> T:
            if keep_open is not None and not self.belief.held() and self._to_close({keep_open, self.destined}):
                await node.do(self._close_all({keep_open, self.destined}))
            self.board.update()
            poses = await self.robot.base_poses(target)
            if not poses and keep_open is not None and self._to_close({keep_open}):
                await node.do(self._close_all({keep_open}))
                poses = await self.robot.base_poses(target)
            failure: RobotFailure = Unreachable(what or name, "there is nowhere to stand for it")
            tried: list[BasePose] = []
            while True:
                pose = next((pose for pose in (*poses[skip:], *poses[:skip]) if _is_new(pose, tried)), None)
                if pose is None:
                    raise failure
                tried.append(pose)
                try:
                    return await node.do(attempt(pose))
                except (PathBlocked, Unreachable, ContainerStuck) as error:
                    failure = error
                if len(tried) == POSES_TRIED:
                    raise failure
                # From there more was seen than was known when the poses were computed.
                poses = await self.robot.base_poses(target)

        return Part(name, body)

    def tidy_up(self) -> Part[None]:
        """Close what was opened and park the arms."""

        async def body(node: Node) -> None:
            self._left_open.clear()
            self.destined = ""
            await node.do(self._close_all())
            await node.do(self.park())

        return Part("tidy up", body)

    def park(self) -> Part[None]:
        """Bring the arms to where they are out of the way."""

        async def body(_: Node) -> None:
            async with self._moving(arm=True):
                await self.robot.park_arms()
            self.parked = True

        return Part("park the arms", body)

    # --- containers --------------------------------------------------------------------------------------------

    def open_for(self, surface: Surface) -> Part[None]:
        """See that what a surface is in is open."""

        async def body(node: Node) -> None:
            if surface.container not in self.robot.status().opened:
                await node.do(self._move_door("open", surface.container))

        return Part(f"see that the {surface.place} is open", body)

    def _to_close(self, keep_open: AbstractSet[str] = frozenset()) -> list[str]:
        return sorted(self.robot.status().opened - keep_open - self._left_open)

    def _close_all(self, keep_open: AbstractSet[str] = frozenset()) -> Part[None]:
        async def body(node: Node) -> None:
            for last in (False, True):  # One open door may be in the way of closing another.
                for container in self._to_close(keep_open):
                    try:
                        await node.do(self._move_door("close", container))
                    except RobotFailure:
                        if last:
                            self._left_open.add(container)  # An open door is no reason not to deliver.

        return Part("close what is open", body)

    def _move_door(self, verb: Literal["open", "close"], container: str) -> Part[None]:
        place = next((surface.place for surface in self.scene.surfaces if surface.container == container), "")

        async def turn(_: Node) -> None:
            await (self.robot.open if verb == "open" else self.robot.close)(container)

        async def body(node: Node) -> None:
            async with self._moving(arm=True):  # A warning is no part of what must not be interrupted.
                await node.do(Part(f"{verb} {container}", turn, atomic=True))

        act = Part("move the door", body)
        keep_open = container if verb == "open" else None
        return self.at_base_pose(f"{verb} the {place}", OpenTarget(container), act, place, keep_open=keep_open)

    # --- seeing ------------------------------------------------------------------------------------------------

    def look_over(self, surface: Surface, found: Callable[[Individual], bool]) -> Part[Individual | None]:
        """Look over a whole surface until something fits `found`; what is missing there is noted.

        The value is what was found, or None.
        """
        seen: dict[str, Individual] = {}

        def all_seen() -> bool:
            return all(item.name in seen for item in self.belief.on(surface.name))

        async def look(_: Node) -> Individual | None:
            self.board.update()
            for point in look_points(surface):
                for _attempt in range(2):  # A camera may miss what is there.
                    await self.robot.look_at(point)
                    now = self.belief.observe(await self.robot.perceive())
                    seen.update((item.name, item) for item in now)
                    fitting = [item for item in now if found(item)]
                    if fitting:
                        return fitting[0]
                    if all_seen():
                        break
            return None

        async def body(node: Node) -> Individual | None:
            if surface.container:
                await node.do(self.open_for(surface))
            target, container = LookTarget(middle(surface)), surface.container
            for view in range(VIEWS):  # From another side, what was hidden may be seen.
                there = Part("look", look)
                part = self.at_base_pose(
                    "look there",
                    target,
                    there,
                    surface.place,
                    what=surface.name,
                    keep_open=container,
                    skip=min(view, 1),
                )
                fitting = await node.do(part)
                if fitting or all_seen():
                    return fitting
            self.belief.missing(surface.name, seen.values())
            return None

        return Part(f"look over {surface.name}", body)

    def glance(self, surface: Surface) -> Part[None]:
        """Look over a surface from where the robot stands."""

        async def body(_: Node) -> None:
            for point in look_points(surface):
                await self.robot.look_at(point)
                self.belief.observe(await self.robot.perceive())

        return Part(f"glance at {surface.name}", body)

    def _look_at(self, item: Individual, percept: Percept) -> Part[Percept]:
        """See an object again from where the robot stands now."""

        async def body(_: Node) -> Percept:
            self.board.update()
            for _attempt in range(2):
                await self.robot.look_at(percept.pose.position)
                seen = await self.robot.perceive()
                self.belief.observe(seen)
                for again in seen:
                    if again.name == item.name:
                        return again
            raise ObjectNotThere(item.name)

        return Part("look again", body)

    # --- handling ----------------------------------------------------------------------------------------------

    def pick(self, item: Individual, arm: Arm | None, goal: Point | None) -> Part[None]:
        """Open what it is in, drive there, look again, and take it so that it can be put at `goal`.

        Args:
            item: What.
            arm: With which arm if possible; None for any.
            goal: Where it will be put, map frame [m].
        """
        percept = item.percept
        if percept is None:
            raise ObjectNotThere(item.name)
        surface = self.scene.surface(item.surface) if item.surface else None
        place = surface.place if surface else ""
        container = surface.container if surface else ""

        def take(wanted: Arm | None) -> Part[None]:
            async def grasp(node: Node) -> None:
                now = await node.do(self._look_at(item, percept))
                async with self._moving(arm=True):
                    used = await self.robot.pick(now, wanted, goal)
                self.belief.taken(item.name, used)

            target, act = PickTarget(percept, goal, wanted), self._with_fingers(Part("grasp", grasp))
            name = f"take it with the {wanted} hand" if wanted else "take it"
            return self.at_base_pose(name, target, act, place, what=item.name, keep_open=container)

        async def body(node: Node) -> None:
            if surface and surface.container:
                await node.do(self.open_for(surface))
            try:
                await node.do(take(arm))
            except Unreachable:
                if arm is None:
                    raise
                await node.do(take(None))

        return Part(f"pick up {item.name}", body)

    def place(self, item: Individual, arm: Arm, spot: Spot) -> Part[None]:
        """Open what it goes into, drive there, look whether the spot is free, and put it down."""
        surface = spot.surface

        async def put(_: Node) -> None:
            self.board.update()
            await self.robot.look_at(spot.position)
            self.belief.observe(await self.robot.perceive())
            at_home = spot.position == item.home.position
            if not is_clear(self.belief, spot, item) or (not at_home and is_crowded(self.belief, spot, item)):
                raise Unreachable("the spot", "something stands there")
            self.placing = spot
            try:
                async with self._moving(arm=True):
                    await self.robot.place(arm, spot.position)
            except Unreachable:
                await self._look_around(spot)  # What is in the way must be known when the next spot is chosen.
                raise
            self.belief.put(item.name, surface.name, spot.position)

        async def body(node: Node) -> None:
            if surface.container:
                await node.do(self.open_for(surface))
            self.placing = None
            target = PlaceTarget(arm, spot.position)
            act, container = self._with_fingers(Part("put down", put)), surface.container
            what = f"a spot for {item.name} on {surface.name}"
            await node.do(self.at_base_pose("put it down", target, act, surface.place, what=what, keep_open=container))

        return Part(f"put {item.name} on {surface.name}", body)

    async def _look_around(self, spot: Spot) -> None:
        for point in (spot.position, *look_points(spot.surface)):
            await self.robot.look_at(point)
            self.belief.observe(await self.robot.perceive())

    def _with_fingers(self, part: Part[T]) -> Part[T]:
        """While the fingers close or open, a minor interruption waits for the end of that."""
        return atomic_while(part, lambda: self.robot.status().atomic, self.clock)

    def _watching_hands(self, name: str, part: Part[T]) -> Part[T]:
        """Fail with `ObjectLost` as soon as something held is not in the gripper any more."""
        held = {arm: item.name for arm, item in self.belief.held().items()}
        if not held:
            return part

        def gone() -> tuple[Arm, str] | None:
            holding = self.robot.status().holding
            return next(((arm, thing) for arm, thing in held.items() if holding.get(arm) != thing), None)

        def lost() -> ObjectLost:
            arm, thing = gone() or next(iter(held.items()))
            return ObjectLost(thing, arm)

        return monitor(name, part, lambda: gone() is None, lost, self.clock)

    @asynccontextmanager
    async def _moving(self, *, arm: bool = False, base: bool = False) -> AsyncIterator[None]:
        """Tell of a movement before it begins, and when it has ended."""
        try:
            await self.board.before_moving(move_arm=arm, move_base=base)
            self.parked = self.parked and not arm
            yield
        finally:
            self.board.note(move_arm=False, move_base=False)


def _is_new(pose: BasePose, tried: list[BasePose]) -> bool:
    """Whether a base pose differs from those that were tried."""
    return all(math.dist((pose.x, pose.y), (other.x, other.y)) > SAME or pose.yaw != other.yaw for other in tried)
