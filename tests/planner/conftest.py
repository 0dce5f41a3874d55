"""A kitchen with a planner on the symbolic robot, played in virtual time."""

import math
from collections.abc import Awaitable, Callable
from typing import Any

import anyio
import pytest

from attune.core.bus import COMMAND, OUTCOME, PLAN, ROBOT_STATE, ROBOT_STOP, WORLD, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import PlannerConfig
from attune.core.messages import Command, CommandOutcome, PlanTree, RobotState, StopSignal, WorldState
from attune.core.scene import Scene, load_scene
from attune.planner.planner import Planner
from attune.robots.interface import BasePose
from attune.robots.symbolic import SymbolicRobot

SCENE = load_scene()


class WatchedRobot(SymbolicRobot):
    """Checks on the way what must hold on each drive, and remembers when somebody else moved something."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.moved_at: dict[str, float] = {}

    def move_object(self, name: str, surface: str) -> None:
        self.moved_at[name] = self._clock.now()
        super().move_object(name, surface)

    async def navigate(self, goal: BasePose) -> None:
        assert self.arms_parked, "the arms are parked before driving"
        await super().navigate(goal)


class Kitchen:
    """One run of the planner: what is published is recorded, the truth can be asked for."""

    def __init__(
        self,
        tick: float = 0.1,
        config: PlannerConfig | None = None,
        scene: Scene = SCENE,
        miss_rate: float = 0.0,
    ) -> None:
        self.clock = VirtualClock()
        self.scene = scene
        self.bus = Bus()
        self.robot = WatchedRobot(scene, self.clock, tick=tick, miss_rate=miss_rate)
        self.planner = Planner(self.bus, self.clock, scene, self.robot, config or PlannerConfig())
        self.states: list[RobotState] = []
        self.outcomes: list[CommandOutcome] = []
        self.plans: list[PlanTree] = []
        self.worlds: list[WorldState] = []
        self.bus.on(ROBOT_STATE, self.states.append)
        self.bus.on(OUTCOME, self.outcomes.append)
        self.bus.on(PLAN, self.plans.append)
        self.bus.on(WORLD, self.worlds.append)

    def play(self, script: Callable[[], Awaitable[Any]]) -> "Kitchen":
        """Run the planner while the script lasts."""

        async def main() -> None:
            async with anyio.create_task_group() as group:
                group.start_soon(self.robot.run)
                group.start_soon(self.planner.run)
                await self.clock.sleep(1.0)
                await script()
                group.cancel_scope.cancel()

        run(main, self.clock)
        return self

    def say(self, *commands: Command) -> None:
        for command in commands:
            self.bus.publish(COMMAND, command)

    def signal(self, state: Any) -> None:
        self.bus.publish(ROBOT_STOP, StopSignal(time=self.clock.now(), state=state))

    async def settle(self, limit: float = 3000.0) -> None:
        """Until the robot has had nothing to do for two seconds."""
        with anyio.fail_after(limit):
            quiet = 0.0
            while quiet < 2.0:
                await self.clock.sleep(0.5)
                resting = self.states[-1].step in {"idle", "already_done", "stopped"}
                quiet = quiet + 0.5 if resting else 0.0

    async def until(self, condition: Callable[[RobotState], bool], limit: float = 3000.0) -> RobotState:
        """Until a state fits that is published from now on, or the present one."""
        with self.bus.subscribe(ROBOT_STATE) as states, anyio.fail_after(limit):
            async for state in states:
                if condition(state):
                    return state
        raise AssertionError("unreachable")

    async def after_changes(self, count: int) -> None:
        """Until `count` further states were published, or the robot rests for good."""
        target = len(self.states) + count
        with self.bus.subscribe(ROBOT_STATE) as states:
            while len(self.states) < target:
                with anyio.move_on_after(60.0) as waiting:
                    await states.receive()
                if waiting.cancelled_caught:
                    return

    def where(self, name: str) -> str:
        """Surface that an object really is on, "hand" or "floor"."""
        thing = self.robot.true_objects()[name]
        return "hand" if thing.held_by else thing.place or "floor"

    def moved(self) -> dict[str, str]:
        """Objects that are not on the surface where they began, and where they are."""
        return {
            item.name: self.where(item.name)
            for item in self.scene.objects
            if item.name in self.robot.true_objects() and self.where(item.name) != item.at
        }

    def at(self, surface: str) -> set[str]:
        """Types of the objects that were brought to a surface."""
        return {self.scene.object(name).type for name, now in self.moved().items() if now == surface}

    def check_nothing_lost(self) -> None:
        """Every object stands on a surface, none in another, and the robot believes what is true."""
        truth = self.robot.true_objects()
        for name, thing in truth.items():
            assert thing.place, f"{name} is {self.where(name)}"
        places = [(name, thing.position) for name, thing in truth.items()]
        for index, (name, position) in enumerate(places):
            for other, other_position in places[:index]:
                assert math.dist(position, other_position) > 0.05, f"{name} stands in {other}"
        for believed in self.worlds[-1].objects:
            looked_since = (believed.seen or 0.0) >= self.robot.moved_at.get(believed.spec.name, 0.0)
            if believed.confidence > 0.5 and looked_since:
                thing = truth[believed.spec.name]
                assert believed.place == thing.place, believed
                assert believed.position is not None
                assert math.dist(believed.position, thing.position) < 0.03
        assert not self.robot.status().opened

    def of(self, command: Command) -> list[tuple[str, str]]:
        """Status and reason of all that was told about a command."""
        return [(outcome.status, outcome.reason) for outcome in self.outcomes if outcome.command == command.id]


@pytest.fixture
def make_kitchen() -> type[Kitchen]:
    return Kitchen
