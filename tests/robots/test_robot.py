import math
from collections.abc import Awaitable, Callable

import anyio
import numpy as np
import pytest

from attune.core.clock import VirtualClock, run
from attune.core.config import RobotConfig
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.robots.interface import (
    BasePose,
    Collision,
    LookTarget,
    OpenTarget,
    PathBlocked,
    Percept,
    PickTarget,
    PlaceTarget,
    Target,
)
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.robot import MujocoRobot

CUP = "red_cup"
STILL = 0.02

Scenario = Callable[[MujocoRobot, VirtualClock], Awaitable[None]]


def play(scenario: Scenario, *, friction_only: bool = False) -> None:
    """Run a scenario with a ticking robot in the default kitchen, in virtual time."""
    clock = VirtualClock()

    async def main() -> None:
        robot = MujocoRobot(load_scene(), clock, RobotConfig(friction_only=friction_only))
        failure: list[Exception] = []
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(robot.run)
            try:
                await scenario(robot, clock)
            except Exception as error:  # noqa: BLE001 - handed on below, out of the group
                failure.append(error)
            tasks.cancel_scope.cancel()
        if failure:
            raise failure[0]

    run(main, clock)


async def go_to(robot: MujocoRobot, target: Target) -> None:
    poses = await robot.base_poses(target)
    assert poses, target
    await robot.navigate(poses[0])


async def find(robot: MujocoRobot, name: str) -> Percept:
    position = robot.world.object_pose(name).position
    await go_to(robot, LookTarget(position))
    await robot.look_at(position)
    (percept,) = await robot.perceive(ObjectSpec(name=name))
    return percept


async def stand_before(robot: MujocoRobot, name: str) -> Percept:
    await robot.park_arms()
    percept = await find(robot, name)
    await go_to(robot, PickTarget(percept))
    return percept


def test_navigate_parks_on_the_pose() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        goal = BasePose(2.3, 3.2, math.pi / 2)
        await robot.navigate(goal)
        base = robot.status().base
        assert math.hypot(base.x - goal.x, base.y - goal.y) < 0.01
        assert abs(base.yaw - goal.yaw) < math.radians(1)

    play(scenario)


def test_a_goal_inside_furniture_is_blocked() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        with pytest.raises(PathBlocked):
            await robot.navigate(BasePose(1.75, 1.95, 0.0))

    play(scenario)


def test_it_brings_a_cup_from_the_counter_to_the_island() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        percept = await stand_before(robot, CUP)
        arm = await robot.pick(percept)
        assert robot.status().holding == {arm: CUP}
        goal = robot.world.scene.surface("island").to_map(0.35, -0.2)
        await go_to(robot, PlaceTarget(arm, goal))
        assert robot.world.is_upright(CUP)
        await robot.place(arm, goal)
        assert robot.status().holding == {}
        assert math.dist(robot.world.object_pose(CUP).position, goal) < 0.02
        assert robot.world.place_of(CUP) == "island"
        assert robot.world.is_upright(CUP)

    play(scenario)


def test_a_cup_is_carried_and_put_down_by_friction_alone() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        arm = await robot.pick(await stand_before(robot, CUP))
        goal = robot.world.scene.surface("island").to_map(0.35, -0.2)
        await go_to(robot, PlaceTarget(arm, goal))
        assert robot.status().holding == {arm: CUP}
        await robot.place(arm, goal)
        assert math.dist(robot.world.object_pose(CUP).position, goal) < 0.04
        assert robot.world.is_upright(CUP)

    play(scenario, friction_only=True)


def test_pressed_against_the_table_it_gets_away_and_goes_on() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        await robot.park_arms()
        await robot.navigate(BasePose(3.1, 1.7, 0.0))
        # Somebody pushes it.
        while not robot.world.forbidden_contacts():
            robot.world.command("base_x", robot.world.base().x + 0.01)
            await clock.sleep(STILL)
        with pytest.raises(Collision):
            await robot.navigate(BasePose(2.9, 0.9, 0.0))
        await robot.park_arms()
        assert robot.world.forbidden_contacts() == ()
        await robot.navigate(BasePose(2.9, 0.9, 0.0))

    play(scenario)


def test_milk_that_has_turned_in_the_hand_is_put_down_upright() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        arm = await robot.pick(await stand_before(robot, "blue_milk"))
        goal = robot.world.scene.surface("island").to_map(0.35, -0.2)
        await go_to(robot, PlaceTarget(arm, goal))
        robot.world.turn_in_hand(arm, rotation(1, math.radians(25)) @ rotation(0, math.radians(-15)))
        assert not robot.world.is_upright("blue_milk")
        await robot.place(arm, goal)
        assert math.dist(robot.world.object_pose("blue_milk").position, goal) < 0.02
        assert robot.world.data.body("blue_milk").xmat[8] > math.cos(math.radians(1))

    play(scenario)


def test_it_takes_the_spoon_out_of_the_drawer() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        await robot.park_arms()
        await go_to(robot, OpenTarget("drawer"))
        await robot.open("drawer")
        assert robot.status().opened == {"drawer"}
        percept = await find(robot, "blue_spoon")
        await go_to(robot, PickTarget(percept))
        assert await robot.pick(percept) in robot.status().holding

    play(scenario)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("container", "thing"),
    [("drawer", "blue_spoon"), ("cabinet", "white_cup"), ("fridge", "red_milk"), ("dishwasher", "blue_glass")],
)
def test_things_go_out_of_every_container_and_back(container: str, thing: str) -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        await robot.park_arms()
        await go_to(robot, OpenTarget(container))
        await robot.open(container)
        percept = await find(robot, thing)
        await go_to(robot, PickTarget(percept))
        arm = await robot.pick(percept)
        await robot.navigate(BasePose(*robot.world.scene.robot_start))
        await go_to(robot, PlaceTarget(arm, percept.pose.position))
        await robot.place(arm, percept.pose.position)
        assert robot.world.place_of(thing) == container
        assert robot.world.is_upright(thing)

    play(scenario)


def test_carried_objects_stay_upright_on_the_way() -> None:
    async def scenario(robot: MujocoRobot, clock: VirtualClock) -> None:
        percept = await stand_before(robot, "white_bowl")
        tilts: list[float] = []

        async def watch() -> None:
            while True:
                up = robot.world.data.body("white_bowl").xmat[8]
                tilts.append(math.degrees(math.acos(min(1.0, float(up)))))
                await clock.sleep(0.1)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(watch)
            await robot.pick(percept)
            await robot.park_arms()
            await robot.navigate(BasePose(2.9, 0.9, 0.0))
            tasks.cancel_scope.cancel()
        assert np.max(tilts) < 20

    play(scenario)
