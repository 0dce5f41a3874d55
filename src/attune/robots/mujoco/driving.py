"""Driving the base: a route, its timing, and a watch for what comes into the way."""

import math
from collections.abc import Callable

import anyio
import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.robots.interface import BasePose, PathBlocked
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.costmap import Costmap, Footprint, footprint
from attune.robots.mujoco.motions import Motions
from attune.robots.mujoco.route import find_route

Array = NDArray[np.float64]

_THERE = (0.004, 0.005)
"""How near to the goal the robot must stand [m, rad]."""
_ATTEMPTS = 3
"""Routes that are planned before a way counts as blocked."""
_WATCH = 0.5
"""Time between two looks at the way ahead [s]."""
_BLOCKED = -0.02
"""Clearance on the way ahead below which it counts as blocked [m]."""


class Driving:
    """Drives the base.

    Args:
        motions: Moves it.
        beliefs: Gives the imagined world to plan in.
        clock: For planning off the event loop and for the watch.
    """

    def __init__(self, motions: Motions, beliefs: Beliefs, clock: Clock) -> None:
        self._motions = motions
        self._beliefs = beliefs
        self._clock = clock
        self._costmap: Costmap | None = None
        self._surroundings = b""

    async def floor(self) -> tuple[Costmap, Footprint]:
        """The costmap and the robot's footprint as things are now."""
        world = self._beliefs.imagine()
        surroundings = world.surroundings()
        if surroundings != self._surroundings:
            self._costmap = await self._clock.run_in_thread(lambda: Costmap(world.obstacle_solids()))
            self._surroundings = surroundings
        assert self._costmap is not None
        return self._costmap, footprint(world.body_solids())

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
            route = await self._clock.run_in_thread(lambda: find_route(costmap, body, start, goal))  # noqa: B023
            if route is None:
                raise PathBlocked(goal, _why(costmap, body, goal))
            await self._follow(route, body)
        if not self._there(goal):
            raise PathBlocked(goal, "something is in the way again and again")

    def _there(self, goal: BasePose) -> bool:
        now = self._motions.base
        turn = math.remainder(goal.yaw - now.yaw, math.tau)
        return math.hypot(goal.x - now.x, goal.y - now.y) < _THERE[0] and abs(turn) < _THERE[1]

    async def _follow(self, route: Array, body: Footprint) -> None:
        """Drive along a route until its end, or until it turns out to be blocked."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._watch, route, body, tasks.cancel_scope.cancel)
            await self._motions.drive(route)
            tasks.cancel_scope.cancel()

    async def _watch(self, route: Array, body: Footprint, stop: Callable[[], object]) -> None:
        line = np.concatenate(
            [
                np.linspace(a, b, max(2, int(np.linalg.norm(b - a) / 0.05)))[1:]
                for a, b in zip(route, route[1:], strict=False)
            ]
        )
        while True:
            await self._clock.sleep(_WATCH)
            costmap, _ = await self.floor()
            now = self._motions.base
            passed = int(np.argmin(np.linalg.norm(line - (now.x, now.y, _near(now.yaw, line)), axis=1)))
            if costmap.clearance(line[passed:], body).min() < _BLOCKED:
                stop()
                return


def _near(yaw: float, line: Array) -> float:
    return yaw + math.tau * round((float(line[:, 2].mean()) - yaw) / math.tau)


def _why(costmap: Costmap, body: Footprint, goal: BasePose) -> str:
    clearance = costmap.clearance(np.array([[goal.x, goal.y, goal.yaw]]), body)[0]
    return "something stands there" if clearance <= 0 else "every way there is too narrow"
