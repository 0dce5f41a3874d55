"""The symbolic robot keeps the contract of the Robot interface."""

import math

import anyio
import pytest

from attune.core.clock import VirtualClock, run
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.robots.interface import (
    BasePose,
    GraspMissed,
    GripperFull,
    LookTarget,
    ObjectNotThere,
    OpenTarget,
    PathBlocked,
    PickTarget,
    PlacementFailed,
    PlaceTarget,
    Unreachable,
)
from attune.robots.symbolic import SymbolicRobot

SCENE = load_scene()


def play(script):
    clock = VirtualClock()
    robot = SymbolicRobot(SCENE, clock)

    async def main():
        await script(robot, clock)

    run(main, clock)


async def see(robot, name):
    """Go where an object is, open what it is in, and see it."""
    thing = robot.true_objects()[name]
    surface = SCENE.surface(thing.place)
    if surface.container and surface.container not in robot.status().opened:
        await robot.navigate((await robot.base_poses(OpenTarget(surface.container)))[0])
        await robot.open(surface.container)
    await robot.navigate((await robot.base_poses(LookTarget(thing.position)))[0])
    await robot.look_at(thing.position)
    (percept,) = await robot.perceive(ObjectSpec(name=name))
    return percept


async def take(robot, name):
    percept = await see(robot, name)
    await robot.navigate((await robot.base_poses(PickTarget(percept)))[0])
    return await robot.pick(percept), percept


@pytest.mark.parametrize("name", [item.name for item in SCENE.objects])
def test_every_object_can_be_seen_taken_and_put_on_the_table(name):
    async def script(robot, clock):
        arm, _ = await take(robot, name)
        assert robot.status().holding == {arm: name}
        await robot.park_arms()
        spot = SCENE.surface("table").to_map(0.0, 0.25)
        await robot.navigate((await robot.base_poses(PlaceTarget(arm, spot)))[0])
        await robot.place(arm, spot)
        assert robot.status().holding == {}
        assert robot.true_objects()[name].place == "table"
        assert not robot.status().moving

    play(script)


def test_driving_takes_the_time_of_the_way():
    async def script(robot, clock):
        before = clock.now()
        await robot.navigate(BasePose(robot.status().base.x, robot.status().base.y + 1.0, math.pi / 2))
        assert 2.0 < clock.now() - before < 5.0

    play(script)


def test_what_is_in_a_closed_container_is_not_seen_and_not_reached():
    async def script(robot, clock):
        thing = robot.true_objects()["blue_spoon"]
        percept = await see(robot, "blue_spoon")
        await robot.navigate((await robot.base_poses(OpenTarget("drawer")))[0])
        await robot.close("drawer")
        await robot.navigate((await robot.base_poses(LookTarget(thing.position)))[0])
        await robot.look_at(thing.position)
        assert await robot.perceive(ObjectSpec(name="blue_spoon")) == ()
        await robot.navigate((await robot.base_poses(PickTarget(percept)))[0])
        with pytest.raises(Unreachable):
            await robot.pick(percept)

    play(script)


def test_what_is_behind_or_far_is_not_seen():
    async def script(robot, clock):
        percept = await see(robot, "red_cup")
        base, (x, y, z) = robot.status().base, percept.pose.position
        await robot.look_at((2 * base.x - x, 2 * base.y - y, z))
        assert await robot.perceive(ObjectSpec(name="red_cup")) == ()
        await robot.navigate(BasePose(2.9, 0.9, 0.0))
        await robot.look_at(percept.pose.position)
        assert await robot.perceive(ObjectSpec(name="red_cup")) == ()

    play(script)


def test_a_halt_during_the_closing_of_the_fingers_can_be_cancelled():
    async def script(robot, clock):
        percept = await see(robot, "red_cup")
        await robot.navigate((await robot.base_poses(PickTarget(percept)))[0])
        with anyio.move_on_after(60.0):
            async with anyio.create_task_group() as group:
                group.start_soon(robot.pick, percept)
                await clock.sleep(2.1)
                robot.halt()
                await clock.sleep(1.0)
                group.cancel_scope.cancel()
        assert robot.status().holding == {}
        assert clock.now() < 60.0

    play(script)


@pytest.mark.parametrize("failure", [GraspMissed("red_cup", "right"), ObjectNotThere("red_cup")], ids=repr)
def test_a_declared_failure_happens_once(failure):
    async def script(robot, clock):
        percept = await see(robot, "red_cup")
        await robot.navigate((await robot.base_poses(PickTarget(percept)))[0])
        robot.fail_next("pick", failure)
        with pytest.raises(type(failure)):
            await robot.pick(percept)
        assert robot.status().holding == {}
        await robot.pick(percept)

    play(script)


def test_a_blocked_path_ends_the_drive_half_way():
    async def script(robot, clock):
        goal = BasePose(2.9, 2.9, 0.0)
        robot.fail_next("navigate", PathBlocked(goal))
        with pytest.raises(PathBlocked):
            await robot.navigate(goal)
        assert 1.0 < robot.status().base.y < 2.8

    play(script)


def test_a_failed_placement_leaves_the_object_beside_the_spot():
    async def script(robot, clock):
        arm, percept = await take(robot, "red_cup")
        robot.fail_next("place", PlacementFailed("red_cup", "slid"))
        with pytest.raises(PlacementFailed):
            await robot.place(arm, percept.pose.position)
        assert robot.true_objects()["red_cup"].place == "counter"
        assert robot.status().holding == {}

    play(script)


def test_putting_something_where_something_stands_fails():
    async def script(robot, clock):
        arm, percept = await take(robot, "red_cup")
        robot.move_object("blue_milk", "counter")
        milk = await see(robot, "blue_milk")
        await robot.navigate((await robot.base_poses(PlaceTarget(arm, milk.pose.position)))[0])
        with pytest.raises(PlacementFailed):
            await robot.place(arm, milk.pose.position)

    play(script)


def test_two_hands_hold_two_things_and_no_third():
    async def script(robot, clock):
        await take(robot, "red_cup")
        await take(robot, "blue_milk")
        with pytest.raises(GripperFull):
            await take(robot, "green_cereal")
        assert set(robot.status().holding.values()) == {"red_cup", "blue_milk"}

    play(script)


def test_a_camera_that_misses_is_the_same_for_the_same_seed():
    def looks(seed):
        clock = VirtualClock()
        robot = SymbolicRobot(SCENE, clock, seed, miss_rate=0.5)
        seen = []

        async def main():
            await robot.navigate((await robot.base_poses(LookTarget(SCENE.surface("counter").center)))[0])
            await robot.look_at(SCENE.surface("counter").center)
            for _ in range(5):
                seen.append({percept.name for percept in await robot.perceive()})

        run(main, clock)
        return seen

    assert looks(1) == looks(1)
    assert len({frozenset(names) for names in looks(1)}) > 1
