"""What a person experiences: words in, the world changed, an answer heard."""

from collections.abc import Awaitable, Callable
from typing import Any

import anyio
import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, EVENT, OUTCOME, REPLY, ROBOT_STATE, VOICE_STATUS, Topic
from attune.robots.simulated import Simulated, TrueObject
from attune.session.session import Session

Converse = Callable[[Callable[[Session], Awaitable[None]]], Session]


def record(session: Session, topic: Topic[Any]) -> list[Any]:
    heard: list[Any] = []
    session.bus.on(topic, heard.append)
    return heard


def world(session: Session) -> dict[str, TrueObject]:
    assert isinstance(session.robot, Simulated)
    return dict(session.robot.true_objects())


async def until(session: Session, condition: Callable[[m.RobotState], bool]) -> m.RobotState:
    with session.bus.subscribe(ROBOT_STATE) as states, anyio.fail_after(600):
        async for state in states:
            if condition(state):
                return state
    raise AssertionError("the robot's state stream ended")


def test_a_cup_that_is_asked_for_is_brought_and_announced(converse: Converse) -> None:
    replies: list[m.Reply] = []
    spoken: list[m.VoiceStatus] = []

    async def conversation(session: Session) -> None:
        session.bus.on(REPLY, replies.append)
        session.bus.on(VOICE_STATUS, spoken.append)
        session.say("bring me a cup")
        await session.settled()

    session = converse(conversation)
    delivered = [name for name, thing in world(session).items() if thing.spec.type == "cup" and thing.place == "table"]
    assert len(delivered) == 1
    assert any("cup" in reply.text for reply in replies)
    assert any(status.state == "finished" for status in spoken)


def test_a_replacement_on_the_way_takes_the_cup_back_and_brings_only_the_bowl(converse: Converse) -> None:
    before: dict[str, TrueObject] = {}

    async def conversation(session: Session) -> None:
        before.update(world(session))
        session.say("bring me a cup")
        await until(session, lambda state: state.step == "transporting_deliver" and bool(state.holding))
        session.say("I would like a bowl instead")
        await session.settled()

    after = world(converse(conversation))
    moved = {name for name in after if after[name].place != before[name].place}
    assert len(moved) == 1
    assert after[moved.pop()].spec.type == "bowl"
    assert not any(thing.held_by for thing in after.values())


def test_stop_holds_the_robot_and_carry_on_finishes_the_task(converse: Converse) -> None:
    positions: list[object] = []

    async def conversation(session: Session) -> None:
        session.say("bring me a cup")
        await until(session, lambda state: state.step == "transporting_deliver" and bool(state.holding))
        session.say("stop!")
        stopped = await until(session, lambda state: state.step == "stopped")
        assert [spec.type for spec in stopped.holding] == ["cup"]
        await session.clock.sleep(2)
        positions.append(session.robot.status().base)
        await session.clock.sleep(60)
        positions.append(session.robot.status().base)
        session.say("carry on")
        await until(session, lambda state: state.step == "task_done")

    session = converse(conversation)
    assert positions[0] == positions[1]
    assert any(thing.spec.type == "cup" and thing.place == "table" for thing in world(session).values())


def test_what_is_no_command_never_reaches_the_robot(converse: Converse) -> None:
    commands: list[m.Command] = []
    events: list[Any] = []

    async def conversation(session: Session) -> None:
        session.bus.on(COMMAND, commands.append)
        session.bus.on(EVENT, events.append)
        for text in ("uh-huh", "lovely weather today", "did you see the match yesterday", "mhm"):
            session.say(text)
            await session.clock.sleep(5)

    converse(conversation)
    assert commands == []
    ignored = [event for event in events if event.kind == "ignored"]
    assert len(ignored) >= 2
    assert all(event.text for event in ignored)


def test_an_object_that_does_not_exist_is_refused_with_an_answer(converse: Converse) -> None:
    replies: list[m.Reply] = []

    async def conversation(session: Session) -> None:
        session.bus.on(REPLY, replies.append)
        session.say("bring me the purple elephant")
        await session.clock.sleep(10)

    session = converse(conversation)
    state = session.bus.latest(ROBOT_STATE)
    assert replies
    assert state is not None
    assert state.step == "idle"


def test_every_command_has_its_cause_and_ends_in_an_outcome(converse: Converse) -> None:
    heard: list[m.Utterance] = []
    commands: list[m.Command] = []
    outcomes: list[m.CommandOutcome] = []

    async def conversation(session: Session) -> None:
        session.bus.on(COMMAND, commands.append)
        session.bus.on(OUTCOME, outcomes.append)
        heard.append(session.say("bring me a cup"))
        await session.clock.sleep(5)
        heard.append(session.say("bring me a bowl too"))
        await session.settled()

    converse(conversation)
    assert [command.cause for command in commands] == [utterance.id for utterance in heard]
    for command in commands:
        assert [o.status for o in outcomes if o.command == command.id][-1] == "done"


@pytest.mark.parametrize(("band", "place"), [("older", "table"), ("younger", "countertop")])
def test_things_are_delivered_where_the_age_band_has_them_by_default(converse: Converse, band: Any, place: str) -> None:
    places: list[str] = []

    async def conversation(session: Session) -> None:
        before = world(session)
        session.say("bring me a spoon", age=m.AgeEstimate(band=band, confidence=1.0, source="stated"))
        await session.settled()
        after = world(session)
        places.extend(
            session.scene.surface(thing.place).place
            for name, thing in after.items()
            if thing.position != before[name].position
        )

    converse(conversation)
    assert places == [place]
