"""The contract of the Robot interface, for every implementation: symbolic, the example with one arm, PR2 with physics.

A new robot is added to `IMPLEMENTATIONS`: how it is made, and how somebody else moves an object in its world.
"""

import importlib.util
import math
import threading
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
import pytest

from attune.core.clock import RealClock, VirtualClock, run
from attune.core.config import RobotConfig
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.robots.interface import (
    BasePose,
    GripperFull,
    LookTarget,
    ObjectLost,
    ObjectNotThere,
    OpenTarget,
    Percept,
    PickTarget,
    PlaceTarget,
    Robot,
    RobotFailure,
    UnknownTarget,
    Unreachable,
)
from attune.robots.mujoco.robot import MujocoRobot
from attune.robots.simulated import Simulated
from attune.robots.symbolic import SymbolicRobot

SCENE = load_scene()
CUP = "red_cup"
STOPPING = 0.3
"""Within which a halted or cancelled robot stands still [s]."""


def _example() -> Any:
    path = Path(__file__).parents[2] / "examples" / "one_arm_robot.py"
    spec = importlib.util.spec_from_file_location("one_arm_robot", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


OneArmRobot = _example().OneArmRobot


@dataclass(frozen=True)
class Implementation:
    """A robot to be tested.

    Attributes:
        make: From a clock.
        move: Somebody else puts an object on a surface.
        moments: After which its actions are interrupted, each a test [s].
        shielded: Longest that a cancelled action goes on [s].
    """

    name: str
    make: Callable[[Any], Any]
    move: Callable[[Any, str, str], None]
    moments: tuple[float, ...]
    shielded: float

    def __str__(self) -> str:
        return self.name


def _every(step: float, end: float) -> tuple[float, ...]:
    return tuple(round(step * (index + 0.5), 3) for index in range(int(end / step)))


IMPLEMENTATIONS = (
    Implementation(
        "symbolic",
        lambda clock: SymbolicRobot(SCENE, clock),
        lambda robot, name, surface: robot.move_object(name, surface),
        _every(0.1, 3.6),
        0.5,
    ),
    Implementation(
        "one-arm",
        lambda clock: OneArmRobot(SCENE, clock),
        lambda robot, name, surface: robot.take_away(name, surface),
        _every(0.1, 3.6),
        0.5,
    ),
    Implementation(
        "mujoco",
        lambda clock: MujocoRobot(SCENE, clock, RobotConfig()),
        lambda robot, name, surface: robot.world.move_object(name, SCENE.surface(surface).to_map(0.0, 0.0)),
        (2.0, 5.0),
        3.2,
    ),
)
EACH = pytest.mark.parametrize("implementation", IMPLEMENTATIONS, ids=str)
AT_EACH_MOMENT = pytest.mark.parametrize(
    ("implementation", "moment"),
    [(implementation, moment) for implementation in IMPLEMENTATIONS for moment in implementation.moments],
    ids=str,
)
FAST = pytest.mark.parametrize("implementation", IMPLEMENTATIONS[:2], ids=str)
"""For what would cost seconds with physics, where it is tested with whole plans."""

Script = Callable[[Any, VirtualClock], Awaitable[None]]


def play(implementation: Implementation, script: Script) -> None:
    clock = VirtualClock()

    async def main() -> None:
        robot = implementation.make(clock)
        problem: list[Exception] = []
        async with anyio.create_task_group() as group:
            group.start_soon(robot.run)
            try:
                await script(robot, clock)
            except Exception as error:  # noqa: BLE001 - handed on below, out of the group
                problem.append(error)
            group.cancel_scope.cancel()
        if problem:
            raise problem[0]

    run(main, clock)


async def go_to(robot: Robot, target: Any) -> None:
    await robot.park_arms()
    poses = await robot.base_poses(target)
    assert poses, target
    await robot.navigate(poses[0])


async def see(robot: Any, name: str) -> Percept:
    position = robot.true_objects()[name].position
    await go_to(robot, LookTarget(position))
    await robot.look_at(position)
    (percept,) = await robot.perceive(ObjectSpec(name=name))
    return percept


async def before(robot: Any, name: str) -> Percept:
    """See an object and stand where it can be taken."""
    percept = await see(robot, name)
    await go_to(robot, PickTarget(percept))
    return percept


async def stands_still(robot: Any, clock: VirtualClock) -> None:
    await clock.sleep(STOPPING)
    where = robot.status().base
    assert not robot.status().moving
    await clock.sleep(2.0)
    assert not robot.status().moving
    assert math.dist((where.x, where.y), (robot.status().base.x, robot.status().base.y)) < 1e-3


@EACH
def test_it_is_a_robot_whose_truth_can_be_asked_for(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        assert isinstance(robot, Robot)
        assert isinstance(robot, Simulated)
        assert robot.arms
        assert not robot.status().holding
        assert not robot.status().halted

    play(implementation, script)


@EACH
def test_it_sees_takes_carries_and_puts_down(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        assert (percept.type, percept.color, percept.place) == ("cup", "red", "counter")
        assert math.dist(percept.pose.position, robot.true_objects()[CUP].position) < 0.02
        arm = await robot.pick(percept)
        assert arm in robot.arms
        assert robot.status().holding == {arm: CUP}
        with pytest.raises(GripperFull):
            await robot.pick(percept, arm)
        spot = SCENE.surface("island").to_map(0.5, -0.2)
        await go_to(robot, PlaceTarget(arm, spot))
        await robot.place(arm, spot)
        assert robot.status().holding == {}
        thing = robot.true_objects()[CUP]
        assert thing.place == "island"
        assert math.dist(thing.position, spot) < 0.03
        await stands_still(robot, clock)

    play(implementation, script)


@EACH
@pytest.mark.parametrize(
    ("container", "thing"),
    [("drawer", "blue_spoon"), ("cabinet", "white_cup"), ("fridge", "red_milk"), ("dishwasher", "blue_glass")],
)
def test_a_container_opens_shows_what_is_in_it_and_closes(
    implementation: Implementation, container: str, thing: str
) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        await go_to(robot, OpenTarget(container))
        await robot.open(container)
        assert robot.status().opened == {container}
        await robot.open(container)
        percept = await see(robot, thing)
        assert percept.place == container
        await go_to(robot, OpenTarget(container))
        await robot.close(container)
        assert robot.status().opened == frozenset()

    play(implementation, script)


@AT_EACH_MOMENT
def test_a_pick_that_is_cancelled_at_any_moment_is_at_rest_and_tells_what_it_holds(
    implementation: Implementation, moment: float
) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        began = clock.now()
        with anyio.move_on_after(moment):
            await robot.pick(percept)
        assert clock.now() - began <= moment + implementation.shielded
        await stands_still(robot, clock)
        thing = robot.true_objects()[CUP]
        assert robot.status().holding == ({thing.held_by: CUP} if thing.held_by else {})
        assert thing.upright
        assert thing.held_by or thing.place == "counter"

    play(implementation, script)


@AT_EACH_MOMENT
def test_a_place_that_is_cancelled_at_any_moment_holds_the_object_or_has_put_it_down(
    implementation: Implementation, moment: float
) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        arm = await robot.pick(percept)
        spot = percept.pose.position
        await go_to(robot, PlaceTarget(arm, spot))
        began = clock.now()
        with anyio.move_on_after(moment):
            await robot.place(arm, spot)
        assert clock.now() - began <= moment + implementation.shielded
        await stands_still(robot, clock)
        thing = robot.true_objects()[CUP]
        assert robot.status().holding == ({thing.held_by: CUP} if thing.held_by else {})
        assert thing.held_by or (thing.place == "counter" and thing.upright)

    play(implementation, script)


@EACH
def test_a_cancelled_drive_ends_where_it_is(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        goal = BasePose(2.3, 3.2, math.pi / 2)
        with anyio.move_on_after(2.0):
            await robot.navigate(goal)
        await stands_still(robot, clock)
        base = robot.status().base
        assert math.dist((base.x, base.y), (goal.x, goal.y)) > 0.3

    play(implementation, script)


@EACH
def test_a_halt_holds_a_drive_and_resume_lets_it_go_on(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        goal = BasePose(2.3, 3.2, math.pi / 2)
        async with anyio.create_task_group() as group:
            group.start_soon(robot.navigate, goal)
            await clock.sleep(1.5)
            robot.halt()
            robot.halt()
            await stands_still(robot, clock)
            assert robot.status().halted
            robot.resume()
            robot.resume()
            assert not robot.status().halted
        base = robot.status().base
        assert math.dist((base.x, base.y), (goal.x, goal.y)) < 0.02

    play(implementation, script)


@AT_EACH_MOMENT
def test_a_pick_that_is_halted_at_any_moment_goes_on_after_resume(
    implementation: Implementation, moment: float
) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        async with anyio.create_task_group() as group:
            group.start_soon(robot.pick, percept)
            await clock.sleep(moment)
            robot.halt()
            await stands_still(robot, clock)
            robot.resume()
        assert CUP in robot.status().holding.values()

    play(implementation, script)


@EACH
def test_a_halted_pick_can_be_cancelled(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        began = clock.now()
        with anyio.move_on_after(60.0):
            async with anyio.create_task_group() as group:
                group.start_soon(robot.pick, percept)
                await clock.sleep(implementation.moments[len(implementation.moments) // 2])
                robot.halt()
                await clock.sleep(1.0)
                group.cancel_scope.cancel()
        assert clock.now() - began < 12.0
        assert robot.status().halted
        await stands_still(robot, clock)
        held = robot.true_objects()[CUP].held_by
        assert robot.status().holding == ({held: CUP} if held else {})

    play(implementation, script)


@FAST
def test_halt_may_come_from_another_thread(implementation: Implementation) -> None:
    clock = RealClock()

    async def main() -> None:
        robot = implementation.make(clock)
        async with anyio.create_task_group() as group:
            group.start_soon(robot.navigate, BasePose(2.9, 2.9, 0.0))
            await clock.sleep(0.15)
            thread = threading.Thread(target=robot.halt)
            thread.start()
            thread.join()
            assert not robot.status().moving
            group.cancel_scope.cancel()

    run(main, clock)


@EACH
def test_an_object_that_somebody_moved_is_not_there(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        implementation.move(robot, CUP, "table")
        with pytest.raises(ObjectNotThere):
            await robot.pick(percept)
        assert robot.status().holding == {}
        await stands_still(robot, clock)

    play(implementation, script)


@EACH
def test_what_was_taken_out_of_the_gripper_is_lost(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        percept = await before(robot, CUP)
        arm = await robot.pick(percept)
        implementation.move(robot, CUP, "table")
        await clock.sleep(0.1)
        assert robot.status().holding == {}
        with pytest.raises(ObjectLost):
            await robot.place(arm, percept.pose.position)

    play(implementation, script)


@EACH
def test_what_it_has_no_name_for_is_refused_with_the_names_it_has(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        with pytest.raises(UnknownTarget, match="drawer"):
            await robot.open("safe")

    play(implementation, script)


@FAST
def test_what_is_far_or_behind_a_door_is_out_of_reach(implementation: Implementation) -> None:
    async def script(robot: Any, clock: VirtualClock) -> None:
        with pytest.raises(Unreachable):
            await robot.open("fridge")
        assert issubclass(Unreachable, RobotFailure)
        inside = robot.true_objects()["yellow_juice"].position
        await go_to(robot, LookTarget(inside))
        await robot.look_at(inside)
        assert await robot.perceive(ObjectSpec(name="yellow_juice")) == ()

    play(implementation, script)
