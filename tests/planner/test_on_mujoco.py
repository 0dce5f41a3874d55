"""The planner on the PR2 with real physics."""

import anyio
import pytest

from attune.core.bus import COMMAND, OUTCOME, ROBOT_STATE, ROBOT_STOP, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import PlannerConfig, RobotConfig
from attune.core.messages import BringMe, CarryOn, ObjectSpec, ReplaceObject, SettingBreakfast, StopSignal
from attune.core.scene import load_scene
from attune.planner.planner import Planner
from attune.robots.mujoco.robot import MujocoRobot

SCENE = load_scene()


class Kitchen:
    """One run of the planner on the simulated PR2, in virtual time."""

    def __init__(self, config: PlannerConfig | None = None) -> None:
        self.clock = VirtualClock()
        self.bus = Bus()
        self.robot = MujocoRobot(SCENE, self.clock, RobotConfig())
        self.planner = Planner(self.bus, self.clock, SCENE, self.robot, config or PlannerConfig())
        self.states = []
        self.outcomes = []
        self.bus.on(ROBOT_STATE, self.states.append)
        self.bus.on(OUTCOME, self.outcomes.append)

    def play(self, script) -> None:
        async def main() -> None:
            async with anyio.create_task_group() as group:
                group.start_soon(self.robot.run)
                group.start_soon(self.planner.run)
                await self.clock.sleep(0.5)
                await script()
                group.cancel_scope.cancel()

        run(main, self.clock)

    async def until(self, condition) -> None:
        with self.bus.subscribe(ROBOT_STATE) as states, anyio.fail_after(900.0):
            async for state in states:
                if condition(state):
                    return

    async def settle(self) -> None:
        with anyio.fail_after(1500.0):
            quiet = 0.0
            while quiet < 2.0:
                await self.clock.sleep(0.5)
                quiet = quiet + 0.5 if self.states[-1].step in {"idle", "stopped"} else 0.0

    def moved(self) -> dict[str, str]:
        truth = self.robot.world.true_objects()
        where = {name: "hand" if thing.held_by else thing.place for name, thing in truth.items()}
        return {item.name: where[item.name] for item in SCENE.objects if where[item.name] != item.at}


def bring(name: str) -> BringMe:
    return BringMe(time=0.0, objects=(ObjectSpec(name=name),))


def test_it_brings_a_cup_to_the_table():
    kitchen = Kitchen()

    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    assert [outcome.status for outcome in kitchen.outcomes] == ["accepted", "done"]


def test_a_carried_cup_goes_back_when_a_bowl_is_wanted_instead():
    kitchen = Kitchen()

    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding) and state.move_base)
        await kitchen.clock.sleep(1.0)
        swap = ReplaceObject(time=0.0, remove=ObjectSpec(type="cup"), add=ObjectSpec(name="white_bowl"))
        kitchen.bus.publish(COMMAND, swap)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_bowl": "table"}


@pytest.mark.slow
def test_breakfast_is_set():
    kitchen = Kitchen()

    async def script():
        kitchen.bus.publish(COMMAND, SettingBreakfast(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    brought = {SCENE.object(name).type for name, now in kitchen.moved().items() if now == "table"}
    assert brought == {"bowl", "cereal", "milk", "spoon"}


def test_a_stop_while_carrying_stands_still_and_carry_on_delivers():
    kitchen = Kitchen()

    async def script():
        kitchen.bus.publish(COMMAND, bring("blue_milk"))
        await kitchen.until(lambda state: bool(state.holding) and state.move_base)
        await kitchen.clock.sleep(1.0)
        kitchen.bus.publish(ROBOT_STOP, StopSignal(time=kitchen.clock.now()))
        await kitchen.clock.sleep(0.5)
        for _ in range(20):
            assert not kitchen.robot.status().moving
            await kitchen.clock.sleep(0.2)
        assert kitchen.moved() == {"blue_milk": "hand"}
        kitchen.bus.publish(COMMAND, CarryOn(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_milk": "table"}
