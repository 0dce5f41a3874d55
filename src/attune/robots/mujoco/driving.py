"""Driving the base: a route, its timing, and a watch for what comes into the way."""

import math
from collections.abc import Awaitable, Callable, Hashable
from contextlib import suppress
from dataclasses import dataclass
from itertools import product

import anyio
import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.robots.interface import BasePose, Collision, PathBlocked, Point, RobotFailure
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.costmap import Costmap, Footprint, footprint
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.motions import BASE_LIMITS, Motions
from attune.robots.mujoco.route import MARGINS, find_route
from attune.robots.mujoco.trajectory import Trajectory, plan_trajectory

Array = NDArray[np.float64]

_THERE = (0.004, 0.005)
"""How near to the goal the robot must stand [m, rad]."""
_ATTEMPTS = 3
"""Routes that are planned before a way counts as blocked."""
_WATCH = 0.5
"""Time between two looks at the way ahead [s]."""
_AHEAD = 1.3
"""How far ahead on the way the robot looks at the floor [m]."""
_BLENDS = (0.5, 0.2, 0.05)
"""Time over which corners are rounded, the first for which there is room [s]."""
_KEPT = 0.02
"""Clearance that rounding a corner leaves [m]."""
_BACK = (0.6, 0.35)
"""How far the robot draws back from what it ran into [m]."""
_BACKWARDS = (math.pi, 0.75 * math.pi, 1.25 * math.pi, 0.5 * math.pi, 1.5 * math.pi)
"""Directions in which it may, counted from that in which it went [rad]."""
_SURE = 0.05
"""Clearance with which nothing is touched, however coarse the costmap's cells are [m]."""
_BLOCKED = 0.03
"""A way ahead that has become narrower by this is blocked [m]."""


@dataclass(frozen=True, slots=True)
class Way:
    """A timed route, and how near it comes to obstacles [m]."""

    trajectory: Trajectory
    room: float


class Driving:
    """Drives the base.

    Args:
        motions: Moves it.
        beliefs: Gives the imagined world to plan in.
        clock: For planning off the event loop and for the watch.
        see: Looks at a point and takes in what is seen there.
    """

    def __init__(
        self, motions: Motions, beliefs: Beliefs, clock: Clock, see: Callable[[Point], Awaitable[None]]
    ) -> None:
        self._see = see
        self._motions = motions
        self._beliefs = beliefs
        self._clock = clock
        self._costmap: Costmap | None = None
        self._surroundings: Hashable = None

    async def floor(self) -> tuple[Costmap, Footprint]:
        """The costmap and the robot's footprint as things are now."""
        return await self._map(), footprint(self._beliefs.imagine().body_solids())

    async def _map(self) -> Costmap:
        """The costmap; made anew only when something else is in the way than before."""
        surroundings = self._beliefs.surroundings()
        if self._costmap is None or surroundings != self._surroundings:
            world = self._beliefs.imagine()
            self._costmap = await self._clock.run_in_thread(lambda: Costmap(world.obstacle_solids()))
            self._surroundings = surroundings
        return self._costmap

    async def to(self, goal: BasePose) -> None:
        """Drive to a pose.

        Raises:
            PathBlocked: There is no free way, also not after planning again.
        """
        for _ in range(_ATTEMPTS):
            if self._there(goal):
                return
            costmap, body = await self.floor()
            start = self._motions.base
            world = self._beliefs.imagine()
            way = await self._clock.run_in_thread(
                lambda: find_way(world, costmap, body, start, goal)  # noqa: B023
            )
            if way is None:
                raise PathBlocked(goal, _why(costmap, body, goal))
            await self._follow(way, body)
        if not self._there(goal):
            raise PathBlocked(goal, "something is in the way again and again")

    def _there(self, goal: BasePose) -> bool:
        now = self._motions.base
        turn = math.remainder(goal.yaw - now.yaw, math.tau)
        return math.hypot(goal.x - now.x, goal.y - now.y) < _THERE[0] and abs(turn) < _THERE[1]

    async def _follow(self, way: Way, body: Footprint) -> None:
        """Drive along a way until its end, or until it turns out to be blocked."""
        async with anyio.create_task_group() as tasks:
            failure: RobotFailure | None = None
            tasks.start_soon(self._watch, way, body, tasks.cancel_scope.cancel)
            try:
                await self._motions.drive(way.trajectory)
            except RobotFailure as met:
                failure = met
            tasks.cancel_scope.cancel()
        if isinstance(failure, Collision):
            await self._draw_back(way.trajectory.points, body)
        if failure is not None:
            raise failure

    async def _draw_back(self, line: Array, body: Footprint) -> None:
        """Leave what the robot ran into on its way, and face it: from a little farther back it can be seen."""
        now = self._motions.base
        passed = min(self._passed(line), len(line) - 2)
        forwards = math.atan2(*(line[passed + 1] - line[passed])[1::-1])
        costmap = await self._map()
        facing = now.yaw + math.remainder(forwards - now.yaw, math.tau)
        for yaw, away, turn in product((facing, now.yaw), _BACK, _BACKWARDS):
            x, y = now.x + away * math.cos(forwards + turn), now.y + away * math.sin(forwards + turn)
            back = np.linspace((now.x, now.y, now.yaw), (x, y, yaw), 20)
            if costmap.clearance(back[1:], body).min() > 0.0:
                with suppress(RobotFailure), self._motions.leaving_contacts():
                    await self._motions.drive(plan_trajectory(back, BASE_LIMITS))
                return

    def _passed(self, line: Array) -> int:
        """How much of a way the robot has passed: the index of its nearest point."""
        now = self._motions.base
        return int(np.argmin(np.linalg.norm(line - (now.x, now.y, _near(now.yaw, line)), axis=1)))

    async def _watch(self, way: Way, body: Footprint, stop: Callable[[], object]) -> None:
        line = way.trajectory.points
        while True:
            await self._clock.sleep(_WATCH)
            now, passed = self._motions.base, self._passed(line)
            away = np.linalg.norm(line[passed:, :2] - (now.x, now.y), axis=1)
            if away[-1] > _AHEAD / 2:
                x, y, _ = line[passed + int(np.argmax(away >= min(_AHEAD, away[-1])))]
                try:
                    await self._see((float(x), float(y), 0.0))
                except RobotFailure:
                    return  # It ends the drive as well.
            costmap = await self._map()
            if costmap.clearance(line[passed::5], body).min() < way.room - _BLOCKED:
                stop()
                return


def find_way(world: Imagination, costmap: Costmap, body: Footprint, start: BasePose, goal: BasePose) -> Way | None:
    """The first route with room on all of it, its corners rounded as far as there is room; None if there is none.

    Where the costmap's cells are too coarse to tell, the route is tried in the imagined world.
    """
    narrow: list[Way] = []
    for margin in MARGINS:
        route = find_route(costmap, body, start, goal, margin)
        if route is None:
            continue
        for blend in _BLENDS:
            trajectory = plan_trajectory(route, BASE_LIMITS, blend)
            room = float(costmap.clearance(trajectory.points[::3], body).min())
            if room >= _SURE or (room >= _KEPT and _drives_free(world, trajectory.points[::2])):
                return Way(trajectory, room)
            narrow.append(Way(trajectory, room))
    narrow.sort(key=lambda way: -way.room)
    return next((way for way in narrow if _drives_free(world, way.trajectory.points[::2])), None)


def _drives_free(world: Imagination, line: Array) -> bool:
    """Whether the robot touches nothing on its way but what it nearly touches at the beginning or at the end."""
    poses = [BasePose(*(float(value) for value in point)) for point in line]
    allowed = set()
    for pose in (poses[0], poses[-1]):
        world.base = pose
        allowed |= {pair[:2] for pair in world.contacts()}
    for pose in poses:
        world.base = pose
        if not world.free() and not {pair[:2] for pair in world.contacts()} <= allowed:
            return False
    return True


def _near(yaw: float, line: Array) -> float:
    return yaw + math.tau * round((float(line[:, 2].mean()) - yaw) / math.tau)


def _why(costmap: Costmap, body: Footprint, goal: BasePose) -> str:
    clearance = costmap.clearance(np.array([[goal.x, goal.y, goal.yaw]]), body)[0]
    return "something stands there" if clearance <= 0 else "every way there is too narrow"
