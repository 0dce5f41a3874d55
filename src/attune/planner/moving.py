"""Driving and parking, doors and drawers, as parts of a plan that publish the state before anything moves."""

import math
from collections.abc import AsyncIterator
from collections.abc import Set as AbstractSet
from contextlib import asynccontextmanager
from typing import Literal, TypeVar

from attune.core.clock import Clock
from attune.core.scene import Scene, Surface
from attune.planner.belief import Belief
from attune.planner.combinators import monitor
from attune.planner.plan import Node, Part
from attune.planner.state import StateBoard
from attune.robots.interface import (
    Arm,
    BasePose,
    ContainerStuck,
    ObjectLost,
    OpenTarget,
    PathBlocked,
    Robot,
    RobotFailure,
    Target,
    Unreachable,
)

T = TypeVar("T")

POSES_TRIED = 3
"""Base poses from which one thing is tried before it counts as out of reach."""
SAME = 0.03
"""Base poses nearer than this, facing the same way, are the same [m]."""


class Moving:
    """Makes parts that bring the robot to where it can act."""

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

    def drive(self, goal: BasePose, place: str) -> Part[None]:
        """Park the arms and drive; what is held is watched on the way."""

        async def navigate(_: Node) -> None:
            async with self.moving(base=True):
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
            async with self.moving(arm=True):
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
            async with self.moving(arm=True):  # A warning is no part of what must not be interrupted.
                await node.do(Part(f"{verb} {container}", turn, atomic=True))

        act = Part("move the door", body)
        keep_open = container if verb == "open" else None
        return self.at_base_pose(f"{verb} the {place}", OpenTarget(container), act, place, keep_open=keep_open)

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
    async def moving(self, *, arm: bool = False, base: bool = False) -> AsyncIterator[None]:
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
