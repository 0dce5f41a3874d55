"""The planner on the PR2 with real physics."""

import numpy as np
import pytest

from attune.core.bus import COMMAND, ROBOT_STOP
from attune.core.config import RobotConfig
from attune.core.messages import (
    BringMe,
    CarryOn,
    ChangeLocation,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    StopSignal,
)
from attune.core.scene import Scene, load_scene
from attune.evaluation.kitchen import Kitchen
from attune.robots.interface import ARMS
from attune.robots.mujoco import pr2
from attune.robots.mujoco.robot import MujocoRobot

SCENE = load_scene()
ISLAND = SCENE.surface("island")


@pytest.fixture
def kitchen() -> Kitchen:
    return Kitchen(SCENE, lambda scene, clock: MujocoRobot(scene, clock, RobotConfig()))


def bring(name: str, **fields: str) -> BringMe:
    return BringMe(time=0.0, objects=(ObjectSpec(name=name, **fields),))  # type: ignore[arg-type]


def carrying(state) -> bool:
    return bool(state.holding) and state.move_base


def told(kitchen: Kitchen, command) -> list[tuple[str, str]]:
    return [(outcome.status, outcome.reason) for outcome in kitchen.outcomes if outcome.command == command.id]


def test_it_brings_a_cup_to_the_table(kitchen):
    command = bring("red_cup")

    async def script():
        kitchen.bus.publish(COMMAND, command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    assert told(kitchen, command) == [("accepted", ""), ("done", "")]


def test_a_carried_cup_goes_back_when_a_bowl_is_wanted_instead(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.until(carrying)
        await kitchen.clock.sleep(1.0)
        swap = ReplaceObject(time=0.0, remove=ObjectSpec(type="cup"), add=ObjectSpec(name="white_bowl"))
        kitchen.bus.publish(COMMAND, swap)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_bowl": "table"}


@pytest.mark.slow
def test_breakfast_is_set(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, SettingBreakfast(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    brought = {SCENE.object(name).type for name, now in kitchen.moved().items() if now == "table"}
    assert brought == {"bowl", "cereal", "milk", "spoon"}


def test_a_stop_while_carrying_stands_still_and_carry_on_delivers(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("blue_milk"))
        await kitchen.until(carrying)
        await kitchen.clock.sleep(1.0)
        kitchen.bus.publish(ROBOT_STOP, StopSignal(time=kitchen.clock.now()))
        await kitchen.clock.sleep(0.3)
        for _ in range(20):
            assert not kitchen.robot.status().moving
            await kitchen.clock.sleep(0.2)
        assert kitchen.moved() == {"blue_milk": "hand"}
        kitchen.bus.publish(COMMAND, CarryOn(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_milk": "table"}


@pytest.mark.slow
def test_after_a_stop_a_new_command_uses_what_is_in_the_gripper(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("blue_milk"))
        await kitchen.until(carrying)
        kitchen.bus.publish(ROBOT_STOP, StopSignal(time=kitchen.clock.now()))
        await kitchen.clock.sleep(2.0)
        wish = BringMe(time=0.0, objects=(ObjectSpec(type="milk"),), destination="countertop")
        kitchen.bus.publish(COMMAND, wish)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_milk": "island"}


def test_an_interruption_while_the_fingers_close_is_told_to_wait_and_the_object_goes_back(kitchen):
    command = PutBack(time=0.0, object=ObjectSpec(name="red_cup"))

    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.until(lambda state: not state.interruptible)
        kitchen.bus.publish(COMMAND, command)
        await kitchen.until(lambda state: bool(state.holding))
        await kitchen.settle()

    kitchen.play(script)
    assert told(kitchen, command) == [("deferred", "atomic_step"), ("done", "")]
    assert kitchen.moved() == {}


def test_what_is_taken_out_of_the_gripper_is_noticed_found_and_brought(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.until(carrying)
        await kitchen.clock.sleep(1.0)
        kitchen.robot.world.move_object("red_cup", ISLAND.to_map(-0.1, 0.2))
        await kitchen.clock.sleep(1.0)
        assert not kitchen.states[-1].holding
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}


@pytest.mark.slow
def test_an_object_moved_at_the_last_moment_is_taken_where_it_is(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.until(lambda state: state.step == "transporting_fetch" and state.move_arm)
        kitchen.robot.world.move_object("red_cup", ISLAND.to_map(-0.1, 0.2))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}


@pytest.mark.slow
def test_an_object_that_was_taken_away_is_told_with_the_nearest_alternative(kitchen):
    command = BringMe(time=0.0, objects=(ObjectSpec(type="bowl", color="white", location="countertop"),))

    async def script():
        kitchen.bus.publish(COMMAND, command)
        await kitchen.until(lambda state: state.move_base)
        kitchen.robot.world.remove_object("white_bowl")
        await kitchen.settle()

    kitchen.play(script)
    assert told(kitchen, command) == [("accepted", ""), ("failed", "not_found")]
    assert kitchen.outcomes[-1].alternative.name == "green_bowl"


@pytest.mark.slow
def test_an_object_that_nobody_told_the_robot_of_can_be_asked_for_once_it_was_seen():
    unaware = SCENE.model_copy(update={"objects": tuple(o for o in SCENE.objects if o.name != "green_cereal")})

    def robot(_: Scene, clock):
        return MujocoRobot(SCENE, clock, RobotConfig())

    kitchen = Kitchen(unaware, robot)

    async def script():
        kitchen.bus.publish(COMMAND, bring("white_bowl"))
        await kitchen.settle()
        kitchen.bus.publish(COMMAND, BringMe(time=0.0, objects=(ObjectSpec(type="cereal"),)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_bowl": "table", "green_cereal": "table"}


@pytest.mark.slow
def test_what_was_delivered_is_moved_on_and_put_back(kitchen):
    async def script():
        kitchen.bus.publish(COMMAND, bring("red_cup"))
        await kitchen.settle()
        kitchen.bus.publish(COMMAND, ChangeLocation(time=0.0, destination="countertop"))
        await kitchen.settle()
        assert kitchen.moved() == {"red_cup": "island"}
        kitchen.bus.publish(COMMAND, PutBack(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {}


def test_a_door_goes_back_when_the_arm_meets_something_and_is_opened_again(kitchen):
    white_cup = bring("white_cup")

    async def script():
        kitchen.bus.publish(COMMAND, white_cup)
        world = kitchen.robot.world
        while world.container_position("cabinet") < 0.5:
            await kitchen.clock.sleep(0.1)
        (arm,) = (arm for arm in ARMS if world.gripped_handle(arm))
        was = elbow(world, arm)
        await kitchen.clock.sleep(0.1)
        now = elbow(world, arm)
        ahead = now + 0.12 * (now - was) / np.linalg.norm(now - was)
        world.move_object("blue_milk", tuple(float(value) for value in ahead - (0.0, 0.0, 0.1)))
        await kitchen.settle()

    def elbow(world, arm):
        return world.data.body(f"{pr2.SIDE[arm]}_forearm_link").xpos.copy()

    kitchen.play(script)
    assert kitchen.moved()["white_cup"] == "table"
    assert not kitchen.robot.status().opened
    assert told(kitchen, white_cup)[-1] == ("done", "")
