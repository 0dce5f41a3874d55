import math

import anyio

from attune.core.clock import VirtualClock, run
from attune.core.config import RobotConfig
from attune.core.scene import load_scene
from attune.robots.interface import BasePose
from attune.robots.mujoco.robot import MujocoRobot

GOAL = BasePose(1.0, 2.9, math.pi / 2)
PASSAGE = (3.2, 2.2)
"""Between island and table: the shortest way to the goal leads through it [m]."""


def test_what_somebody_puts_in_the_way_is_seen_and_driven_around() -> None:
    clock = VirtualClock()
    passed: list[float] = []

    async def main() -> None:
        robot = MujocoRobot(load_scene(), clock, RobotConfig())

        async def somebody() -> None:
            await clock.sleep(0.6)
            robot.world.move_object("green_cereal", (*PASSAGE, 0.001))
            while True:
                base = robot.status().base
                passed.append(math.dist((base.x, base.y), PASSAGE))
                await clock.sleep(0.1)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(robot.run)
            tasks.start_soon(somebody)
            await robot.navigate(GOAL)
            tasks.cancel_scope.cancel()
        base = robot.status().base
        assert math.dist((base.x, base.y), (GOAL.x, GOAL.y)) < 0.01
        assert math.dist(robot.world.object_pose("green_cereal").position[:2], PASSAGE) < 0.01

    run(main, clock)
    assert min(passed) > 0.35
