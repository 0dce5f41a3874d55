"""The planner: takes the next goal, runs its plan, and rests when there is none."""

import anyio

from attune.core.bus import Bus
from attune.core.clock import Clock
from attune.core.config import PlannerConfig
from attune.core.messages import ObjectSpec
from attune.core.scene import Scene
from attune.planner.commands import Rules
from attune.planner.desk import Desk
from attune.planner.interrupt import InterruptClient
from attune.planner.skills import Skills
from attune.planner.transport import transport
from attune.robots.interface import Robot


class Planner:
    """Carries out commands with a robot; each can be interrupted by each other at any moment.

    Args:
        bus: Commands and stops come from it; state, plan, belief and outcomes go to it.
        clock: Time.
        scene: The map and the inventory the robot is given.
        robot: Whose `run` somebody else keeps alive.
        config: Section `[planner]`.
    """

    def __init__(self, bus: Bus, clock: Clock, scene: Scene, robot: Robot, config: PlannerConfig) -> None:
        self._robot = robot
        self._desk = Desk(bus, clock, scene)
        self._skills = Skills(robot, scene, clock, self._desk.belief, self._desk.board)
        self._client = InterruptClient(bus, self._desk, self._skills, Rules(scene, self._desk.belief, config))

    async def run(self) -> None:
        """Work until cancelled. Commands count from the first published state on."""
        async with anyio.create_task_group() as group:
            await group.start(self._client.run)
            self._desk.board.update(step="idle")
            self._desk.belief.publish()
            await self._work()

    async def _work(self) -> None:
        tidy = True
        while True:
            goal = None if self._client.stopped else self._desk.next_goal()
            if goal is None and (tidy or self._client.stopped):
                if not self._client.stopped:
                    self._desk.board.update(step="idle", object=ObjectSpec(), destination_location="", command="")
                await self._client.news()
                continue
            if goal is None:
                self._desk.board.update(step="task_done")
            plan = self._desk.begin(goal)
            part = transport(self._desk, self._skills, goal) if goal else self._skills.tidy_up()
            result = await plan.run(part)
            self._skills.reconcile()
            if result.failure and goal:
                self._desk.fail(goal, result.failure)
            self._desk.end()
            tidy = goal is None and result.status != "interrupted"
