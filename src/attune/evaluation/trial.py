"""One trial: a synthetic person plays a scenario with the robot, and the world is judged at the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import anyio

from attune.core.bus import COMMAND, ROBOT_STATE
from attune.core.clock import Clock
from attune.core.config import Config
from attune.core.messages import Command, RobotState
from attune.evaluation.scenarios import Check, Ending, Line, Scenario
from attune.robots.simulated import Simulated
from attune.session.session import RESTING, Session

if TYPE_CHECKING:
    from attune.evaluation.speakers import UserAudio

PATIENCE = 6.0
"""Seconds after which a person who was not understood says it again."""
TRIES = 3
TIME_LIMIT = 900.0
"""Seconds of robot time after which a trial has failed."""
RESTED = 3.0
"""Seconds after which a robot that rests has nothing more to do."""
OBSERVATION = 3.0
"""Seconds at the end in which the robot's speed is watched."""


@dataclass(frozen=True, slots=True)
class TrialResult:
    """How a trial went.

    Attributes:
        checks: The verdict, claim by claim.
        repetitions: How often the person had to say something again.
        robot_time: Duration [s of the session's clock].
    """

    checks: tuple[Check, ...]
    repetitions: int
    robot_time: float

    @property
    def passed(self) -> bool:
        """Whether each check holds."""
        return all(check.holds for check in self.checks)


async def run_trial(
    scenario: Scenario,
    config: Config,
    clock: Clock,
    user: UserAudio | None,
    watch: Callable[[Session], None] = lambda session: None,
) -> TrialResult:
    """Play a scenario in a new session.

    Args:
        scenario: What is said, and when.
        config: The configuration; its robot must be a simulated one.
        clock: Virtual or real.
        user: The person's voice; None types the lines.
        watch: Called with the session before it runs, to attach a view.
    """
    session = Session(config, clock, audio=user)
    robot = session.robot
    if not isinstance(robot, Simulated):
        raise TypeError("a trial needs a simulated robot: only there the truth is known")
    watch(session)
    async with session.running():
        before = dict(robot.true_objects())
        repetitions = 0
        with anyio.move_on_after(TIME_LIMIT) as limit:
            for line in scenario.lines:
                await _moment(session, line)
                repetitions += await _say_until_understood(session, user, line)
            state = await session.settled(quiet=2.0)
        if limit.cancelled_caught:
            state = session.bus.latest(ROBOT_STATE) or RobotState(time=clock.now())
        top_speed = await _observe(robot, clock)
        checks = scenario.judge(Ending(before, dict(robot.true_objects()), top_speed, state))
        if limit.cancelled_caught:
            checks += (Check(f"the scenario ends within {TIME_LIMIT:.0f} s", holds=False, detail=state.step),)
        return TrialResult(checks, repetitions, clock.now())


async def _moment(session: Session, line: Line) -> None:
    """Wait until the moment of a line has come, or the robot rests and it never will."""
    with session.bus.subscribe(ROBOT_STATE) as states:
        state = await states.receive()
        while not line.when(state):
            with anyio.move_on_after(RESTED if state.step in RESTING else math.inf) as waiting:
                state = await states.receive()
            if waiting.cancelled_caught:
                return
    await session.clock.sleep(line.delay)


async def _say_until_understood(session: Session, user: UserAudio | None, line: Line) -> int:
    """Say a line, again if no command comes of it. Returns how often it was said again."""
    with session.bus.subscribe(COMMAND) as commands:
        for attempt in range(TRIES):
            if user is None:
                session.say(line.text)
                ends = session.clock.now()
            else:
                ends = user.say(line.text)
            with anyio.move_on_after(ends - session.clock.now() + PATIENCE):
                command: Command = await commands.receive()
                while command.kind != line.command:
                    command = await commands.receive()
                return attempt
    return TRIES


async def _observe(robot: Simulated, clock: Clock) -> float:
    """The top speed of the robot over the observation time, after a second for a stop to take effect."""
    await clock.sleep(1.0)
    top_speed = 0.0
    ends = clock.now() + OBSERVATION
    while clock.now() < ends:
        top_speed = max(top_speed, robot.speed())
        await clock.sleep(0.02)
    return top_speed
