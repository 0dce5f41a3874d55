"""What is in the way is moved aside, told before, and nothing of it is lost when that is interrupted; real physics."""

import pytest

from attune.core.bus import COMMAND, ROBOT_STOP
from attune.core.config import RobotConfig
from attune.core.messages import BringMe, CancelObject, CarryOn, ObjectSpec, StopSignal
from attune.core.scene import Scene
from attune.evaluation.kitchen import Kitchen
from attune.evaluation.robot import Trial, Trier
from attune.evaluation.robot_draw import THING, draw
from attune.robots.mujoco.robot import MujocoRobot

MILK = "cabinet_clutter_1"
"""Stands before a cup in the corner of the cabinet."""


@pytest.fixture
def corner() -> Kitchen:
    scene = draw(201, 63).scene
    assert isinstance(scene, Scene)
    return Kitchen(scene, lambda scene, clock: MujocoRobot(scene, clock, RobotConfig(seed=63)))


async def ask_and_wait_until_the_milk_is_carried(kitchen: Kitchen) -> BringMe:
    wish = BringMe(time=0.0, objects=(ObjectSpec(name=THING),), destination="countertop")
    kitchen.say(wish)
    await kitchen.until(lambda state: state.step == "clearing" and bool(state.holding) and state.move_base)
    await kitchen.clock.sleep(1.0)
    return wish


def test_a_neighbour_is_shifted_where_a_plate_has_no_room() -> None:
    result = Trier(411)(70)
    assert isinstance(result, Trial)
    assert (result.problem, result.contacts) == ("", ())
    assert len(result.cleared) == 1


@pytest.mark.slow
def test_a_stop_while_a_milk_is_moved_aside_keeps_it_and_carry_on_brings_the_cup_and_the_milk_back(corner) -> None:
    told: list[tuple[str, str]] = []

    async def script() -> None:
        wish = await ask_and_wait_until_the_milk_is_carried(corner)
        corner.bus.publish(ROBOT_STOP, StopSignal(time=corner.clock.now()))
        await corner.clock.sleep(0.3)
        assert not corner.robot.status().moving
        await corner.clock.sleep(2.0)
        assert corner.moved() == {MILK: "hand"}
        assert [spec.name for spec in corner.states[-1].holding] == [MILK]
        corner.bus.publish(COMMAND, CarryOn(time=0.0))
        await corner.settle()
        told.extend((outcome.status, outcome.reason) for outcome in corner.outcomes if outcome.command == wish.id)

    corner.play(script)
    assert told[-1] == ("done", "")
    assert corner.moved() == {THING: "counter"}
    assert all(thing.upright for thing in corner.after().values())


@pytest.mark.slow
def test_what_is_moved_aside_goes_home_when_the_cup_is_not_wanted_any_more(corner) -> None:
    async def script() -> None:
        await ask_and_wait_until_the_milk_is_carried(corner)
        corner.bus.publish(COMMAND, CancelObject(time=0.0, object=ObjectSpec(name=THING)))
        await corner.settle()

    corner.play(script)
    assert corner.moved() == {}
    assert not corner.robot.status().opened
