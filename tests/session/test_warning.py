"""Older people are told of a movement before it begins; nobody else waits for words, and a stop never does."""

from collections.abc import Callable
from typing import Any

import anyio
import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, MANNER, OUTCOME, REPLY, ROBOT_STATE, ROBOT_STOP, VOICE_STATUS
from attune.core.clock import VirtualClock, run
from attune.core.config import Config
from attune.planner.planner import Planner
from attune.robots.symbolic import SymbolicRobot
from attune.session.session import Session

OLDER = m.AgeEstimate(band="older", confidence=1.0, source="stated")
YOUNGER = m.AgeEstimate(band="younger", confidence=1.0, source="stated")


class Watch:
    """What the robot says and how it moves."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.announced: list[m.Reply] = []
        self.over: dict[str, float] = {}
        self.moving: list[tuple[float, bool]] = []
        self.said: set[str] = set()
        session.bus.on(VOICE_STATUS, lambda status: self.said.add(status.reply) if status.state == "finished" else None)
        session.bus.on(REPLY, lambda reply: self.announced.append(reply) if reply.urgency == "background" else None)
        session.bus.on(
            VOICE_STATUS, lambda status: self.over.setdefault(status.reply, status.time) if status.over else None
        )

    async def sample(self) -> None:
        """Note every 20 ms whether the robot moves."""
        while True:
            self.moving.append((self.session.clock.now(), self.session.robot.status().moving))
            await self.session.clock.sleep(0.02)

    def finished(self, reply: m.Reply) -> bool:
        return reply.id in self.said

    def moved_between(self, start: float, end: float) -> bool:
        return any(moving for time, moving in self.moving if start + 0.03 <= time <= end - 0.03)


def play(config: Config, script: Callable[[Session, Watch], Any]) -> Watch:
    clock = VirtualClock()

    async def main() -> Watch:
        session = Session(config, clock)
        watch = Watch(session)
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(watch.sample)
            with anyio.fail_after(600):
                await script(session, watch)
            group.cancel_scope.cancel()
        return watch

    return run(main, clock)


async def until(session: Session, condition: Callable[[m.RobotState], bool]) -> m.RobotState:
    with session.bus.subscribe(ROBOT_STATE) as states:
        while True:
            state = await states.receive()
            if condition(state):
                return state


def test_no_arm_and_no_base_moves_until_its_announcement_has_been_said(config: Config) -> None:
    async def script(session: Session, watch: Watch) -> None:
        session.say("bring me a spoon", OLDER)
        await session.settled()

    watch = play(config, script)
    # The camera may turn before it; what is announced is a movement of the arm or the base.
    assert len(watch.announced) >= 6
    for reply in watch.announced[:-1]:
        assert not watch.moved_between(reply.time, watch.over[reply.id]), reply.text


@pytest.mark.parametrize(("age", "waits"), [(OLDER, True), (YOUNGER, False), (m.AgeEstimate(), False)])
def test_the_robot_waits_for_words_only_with_older_people(config: Config, age: m.AgeEstimate, waits: bool) -> None:
    begun: list[float] = []

    async def script(session: Session, watch: Watch) -> None:
        session.say("bring me a spoon", age)
        await until(session, lambda state: state.move_base)
        while not session.robot.status().moving:
            await session.clock.sleep(0.02)
        begun.append(session.clock.now())

    play(config, script)
    assert (begun[0] > 3.0) == waits


def test_a_further_wish_does_not_let_a_movement_begin_without_its_warning(config: Config) -> None:
    async def script(session: Session, watch: Watch) -> None:
        session.say("bring me a cup", OLDER)
        await until(session, lambda state: state.move_arm)
        await session.clock.sleep(1.0)
        session.say("bring me a spoon and a fork, too", OLDER)
        await session.clock.sleep(30)

    watch = play(config, script)
    first = watch.announced[0]
    assert watch.finished(first)
    assert not watch.moved_between(first.time, watch.over[first.id])


def test_a_stop_while_the_robot_waits_for_its_own_words_takes_effect_at_once(config: Config) -> None:
    stopped: list[tuple[float, float]] = []

    async def script(session: Session, watch: Watch) -> None:
        session.say("bring me a spoon", OLDER)
        await until(session, lambda state: state.move_base)
        await session.clock.sleep(1.0)
        assert not session.robot.status().moving
        said = session.clock.now()
        session.bus.on(ROBOT_STOP, lambda signal: stopped.append((said, signal.time)))
        session.say("stop", OLDER)
        await until(session, lambda state: state.step == "stopped")
        await session.clock.sleep(20)
        assert not session.robot.status().moving
        session.say("carry on", OLDER)
        await until(session, lambda state: state.step == "task_done")

    watch = play(config, script)
    said, at = stopped[0]
    assert at == said
    assert not watch.moved_between(said, said + 20)


def test_a_change_of_mind_while_it_waits_is_obeyed_without_the_announced_movement(config: Config) -> None:
    said: list[float] = []

    async def script(session: Session, watch: Watch) -> None:
        session.say("bring me a spoon", OLDER)
        await until(session, lambda state: state.step == "transporting_search" and state.move_base)
        said.append(session.clock.now())
        session.say("I would like a cup instead", OLDER)
        await session.settled()

    watch = play(config, script)
    after = [reply.text for reply in watch.announced if reply.time > said[0]]
    assert not any("spoon" in text for text in after)
    assert any("cup" in text for text in after)


def test_who_does_not_want_to_be_told_is_not_waited_for(config: Config) -> None:
    manners: list[float] = []

    async def script(session: Session, watch: Watch) -> None:
        session.bus.on(MANNER, lambda manner: manners.append(manner.warn_before_movement))
        session.say("bring me a spoon", OLDER)
        await until(session, lambda state: state.step == "transporting_search" and state.move_base)
        session.say("you don't have to tell me everything", OLDER)
        await session.clock.sleep(5)
        assert session.robot.status().moving

    play(config, script)
    assert manners[0] > 0
    assert manners[-1] == 0


def test_without_a_voice_nothing_hangs(config: Config) -> None:
    """A planner whose person asks for warnings that nobody speaks: it neither waits nor stands still."""
    clock = VirtualClock()
    outcomes: list[m.CommandOutcome] = []

    async def main() -> float:
        session = Session(config, clock)
        bus, scene = session.bus, session.scene
        robot = SymbolicRobot(scene, clock)
        bus.on(OUTCOME, outcomes.append)
        bus.publish(MANNER, m.Manner(time=0.0, warn_before_movement=8.0))
        async with anyio.create_task_group() as group:
            group.start_soon(robot.run)
            group.start_soon(Planner(bus, clock, scene, robot, config.planner).run)
            await clock.sleep(0.1)
            bus.on(
                ROBOT_STATE, lambda s: bus.publish(REPLY, m.Reply(time=s.time, text="I move.", urgency="background"))
            )
            session.bus.publish(COMMAND, m.BringMe(time=0.1, objects=(m.ObjectSpec(type="spoon"),)))
            await clock.sleep(100)
            group.cancel_scope.cancel()
        return clock.now()

    run(main, clock)
    assert outcomes[-1].status == "done"
