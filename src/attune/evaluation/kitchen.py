"""A kitchen with a planner and a simulated robot, played in virtual time: what the robot's evaluations run in."""

import math
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from typing import Any

import anyio

from attune.core.bus import COMMAND, OUTCOME, ROBOT_STATE, ROBOT_STOP, WORLD, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import PlannerConfig
from attune.core.messages import Command, CommandOutcome, RobotState, Step, StopSignal, WorldState
from attune.core.scene import Scene
from attune.planner.planner import Planner
from attune.robots.interface import Robot
from attune.robots.simulated import Simulated, TrueObject

RESTING: frozenset[Step] = frozenset({"idle", "already_done", "stopped"})
"""Steps in which the planner has nothing to do."""
TIME_LIMIT = 3000.0
"""Longest that a robot may work on what it was told [s]."""
QUIET = 2.0
"""A robot that has rested for so long rests for good [s]."""


class Kitchen:
    """One run of the planner. What is published is kept; the truth can be asked for.

    Args:
        scene: The kitchen.
        make_robot: Makes the robot, which must be a simulated one.
        config: Of the planner.
    """

    def __init__(
        self, scene: Scene, make_robot: Callable[[Scene, VirtualClock], Robot], config: PlannerConfig | None = None
    ) -> None:
        self.scene = scene
        self.clock = VirtualClock()
        self.bus = Bus()
        self.robot = make_robot(scene, self.clock)
        if not isinstance(self.robot, Simulated):
            raise TypeError("an evaluation needs a simulated robot: only there the truth is known")
        self._truth = self.robot
        self._planner = Planner(self.bus, self.clock, scene, self.robot, config or PlannerConfig())
        self.before: Mapping[str, TrueObject] = dict(self._truth.true_objects())
        self.states: list[RobotState] = []
        self.outcomes: list[CommandOutcome] = []
        self.bus.on(ROBOT_STATE, self.states.append)
        self.bus.on(OUTCOME, self.outcomes.append)

    def play(
        self, script: Callable[[], Awaitable[None]], meanwhile: Callable[[], Coroutine[Any, Any, None]] | None = None
    ) -> None:
        """Run robot, planner and what else should go on `meanwhile`, as long as the script lasts."""

        async def main() -> None:
            async with anyio.create_task_group() as group:
                group.start_soon(self.robot.run)
                group.start_soon(self._planner.run)
                if meanwhile:
                    group.start_soon(meanwhile)
                await self.clock.sleep(0.5)
                await script()
                group.cancel_scope.cancel()

        run(main, self.clock)

    def say(self, command: Command) -> None:
        """Give a command; a stop takes its own path as well, as in a session."""
        if command.kind == "stop":
            self.robot.halt()
            self.bus.publish(ROBOT_STOP, StopSignal(time=self.clock.now(), source="program"))
        self.bus.publish(COMMAND, command)

    async def settle(self) -> bool:
        """Until the robot has nothing to do any more. Returns whether it came to rest within the time limit."""
        with self.bus.subscribe(ROBOT_STATE) as states, anyio.move_on_after(TIME_LIMIT) as limit:
            state = await states.receive()
            while True:
                with anyio.move_on_after(QUIET if state.step in RESTING else math.inf) as waiting:
                    state = await states.receive()
                if waiting.cancelled_caught:
                    break
        return not limit.cancelled_caught

    async def until(self, condition: Callable[[RobotState], bool]) -> None:
        """Until a state fits, from the present one on, or none will any more."""
        with self.bus.subscribe(ROBOT_STATE) as states:
            state = await states.receive()
            while not condition(state):
                with anyio.move_on_after(QUIET if state.step in RESTING else TIME_LIMIT) as waiting:
                    state = await states.receive()
                if waiting.cancelled_caught:
                    return

    async def after_changes(self, count: int) -> None:
        """Until so many further states were published, or none will any more."""
        target = len(self.states) + count
        await self.until(lambda state: len(self.states) >= target)

    def after(self) -> Mapping[str, TrueObject]:
        """The objects as they really are now."""
        return self._truth.true_objects()

    def speed(self) -> float:
        """The fastest motion of the robot now [m/s or rad/s]."""
        return self._truth.speed()

    def moved(self) -> dict[str, str]:
        """Objects that are not where they stood, and the surface they are on, `hand` or `floor`."""
        return moved(self.before, self.after())

    def believed(self) -> WorldState | None:
        """What the robot believes now."""
        return self.bus.latest(WORLD)


def moved(before: Mapping[str, TrueObject], after: Mapping[str, TrueObject]) -> dict[str, str]:
    """Objects that are on another surface than before, and which: also `hand` and `floor`."""
    return {
        name: "hand" if now.held_by else now.place or "floor"
        for name, now in after.items()
        if now.place != before[name].place
    }
