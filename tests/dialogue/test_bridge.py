"""The bridge on a real bus in virtual time: what is heard becomes commands and words, and noise becomes nothing."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, field, replace

import anyio
import pytest

from attune.core import messages as m
from attune.core.bus import (
    COMMAND,
    EVENT,
    OUTCOME,
    REPLY,
    RETRACTION,
    ROBOT_STATE,
    ROBOT_STOP,
    SPEECH_STOP,
    UTTERANCE,
    VOICE_STATUS,
    WORLD,
    Bus,
)
from attune.core.clock import VirtualClock, run
from attune.core.config import DialogueConfig
from attune.core.events import Event
from attune.core.messages import BelievedObject, ObjectSpec
from attune.core.scene import load_scene
from attune.dialogue.bridge import DialogueBridge


def spec(type_: str, color: str = "", size: m.Size = "", location: str = "") -> ObjectSpec:
    return ObjectSpec(type=type_, color=color, size=size, location=location)


KITCHEN = (
    spec("cup", "red", "normal", "table"), spec("cup", "blue", "normal", "shelf"),
    spec("bowl", "white", "normal", "cabinet"), spec("spoon", "blue", "normal", "drawer"),
    spec("milk", "blue", "normal", "fridge"), spec("milk", "red", "big", "fridge"),
)  # fmt: skip


@dataclass
class Talk:
    """One conversation and all that came of it."""

    bus: Bus
    clock: VirtualClock
    commands: list[m.Command] = field(default_factory=list)
    replies: list[m.Reply] = field(default_factory=list)
    stops: list[m.StopSignal] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)

    async def say(self, text: str, *, band: m.Band = "unknown", wait: float = 1.0, **more: object) -> m.Utterance:
        age = m.AgeEstimate(band=band, confidence=0.9)
        utterance = replace(m.Utterance(time=self.clock.now(), text=text, age=age, typed=True), **more)  # type: ignore[arg-type]
        self.bus.publish(UTTERANCE, utterance)
        await self.clock.sleep(wait)
        return utterance

    async def works_on(self, *objects: ObjectSpec, step: m.Step = "transporting_fetch", **more: object) -> None:
        queue = tuple(m.QueuedTask(object=o, destination="table", status="active") for o in objects)
        state = m.RobotState(
            time=self.clock.now(), step=step, object=objects[0] if objects else ObjectSpec(), queue=queue
        )
        self.bus.publish(ROBOT_STATE, replace(state, **more))  # type: ignore[arg-type]
        await self.clock.sleep(0.1)

    def kinds(self) -> list[str]:
        return [command.kind for command in self.commands]

    def said(self) -> str:
        return self.replies[-1].text


def converse(scenario: Callable[[Talk], Awaitable[None]], known: Sequence[ObjectSpec] = KITCHEN) -> Talk:
    clock = VirtualClock()
    talk = Talk(Bus(), clock)
    for topic, kept in (
        (COMMAND, talk.commands),
        (REPLY, talk.replies),
        (ROBOT_STOP, talk.stops),
        (EVENT, talk.events),
    ):
        talk.bus.on(topic, kept.append)  # type: ignore[attr-defined, arg-type]

    async def main() -> None:
        bridge = DialogueBridge(talk.bus, clock, load_scene(), DialogueConfig())
        async with anyio.create_task_group() as group:
            group.start_soon(bridge.run)
            await clock.sleep(0.1)
            talk.bus.publish(
                WORLD, m.WorldState(time=clock.now(), objects=tuple(BelievedObject(spec=s) for s in known))
            )
            await scenario(talk)
            group.cancel_scope.cancel()

    run(main, clock)
    return talk


def test_a_request_becomes_a_command_and_a_reply_with_the_utterance_as_cause() -> None:
    heard: list[m.Utterance] = []

    async def scenario(talk: Talk) -> None:
        heard.append(await talk.say("bring me a cup", band="younger"))

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.BringMe)
    assert command.objects == (spec("cup"),)
    assert (command.band, command.cause) == ("younger", heard[0].id)
    assert talk.replies[0].cause == heard[0].id
    assert [event.kind for event in talk.events] == ["heard", "understood"]


def test_a_definite_noun_with_two_candidates_is_asked_about_and_the_answer_completes_the_request() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the cup to the table")
        assert talk.commands == []
        assert "red" in talk.said()
        assert "blue" in talk.said()
        await talk.say("the blue one")

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.BringMe)
    assert command.objects[0].color == "blue"
    assert command.destination == "table"


def test_a_question_expires() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the cup")
        await talk.clock.sleep(25)
        await talk.say("yes")

    talk = converse(scenario)
    assert talk.commands == []
    assert talk.events[-1].kind == "ignored"


def test_the_answer_to_a_question_about_a_replacement_replaces() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.works_on(spec("bowl", "white"))
        await talk.say("I'd like the cup instead")
        await talk.say("the red one please")

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.ReplaceObject)
    assert (command.remove.type, command.add.type, command.add.color) == ("bowl", "cup", "red")


def test_what_is_not_there_is_said_and_the_nearest_offered() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("please bring me a green bowl")
        assert "white bowl" in talk.said()
        await talk.say("yes please")

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.BringMe)
    assert command.objects[0].color == "white"


def test_what_is_clear_is_brought_while_the_rest_is_asked_about() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me a spoon and the cup")

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.BringMe)
    assert [o.type for o in command.objects] == ["spoon"]
    assert talk.said().endswith("?")


def test_stop_is_published_before_publishing_the_utterance_returns() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.works_on(spec("cup", "red"))
        talk.bus.publish(UTTERANCE, m.Utterance(time=talk.clock.now(), text="stop"))
        assert [signal.state for signal in talk.stops] == ["confirmed"]
        assert talk.kinds() == ["stop"]
        await talk.clock.sleep(0.5)

    talk = converse(scenario)
    assert talk.kinds() == ["stop"]
    assert talk.replies[-1].urgency == "urgent"


def test_a_spotted_stop_that_the_sentence_denies_is_taken_back() -> None:
    async def scenario(talk: Talk) -> None:
        talk.bus.publish(
            SPEECH_STOP, m.StopSignal(time=talk.clock.now(), state="spotted", source="spotter", word="stop")
        )
        await talk.clock.sleep(0.4)
        await talk.say("don't stop")

    talk = converse(scenario)
    assert [signal.state for signal in talk.stops] == ["withdrawn"]
    assert talk.commands == []


def test_a_spotted_stop_without_words_is_taken_back_after_three_seconds() -> None:
    async def scenario(talk: Talk) -> None:
        talk.bus.publish(SPEECH_STOP, m.StopSignal(time=talk.clock.now(), state="spotted", source="spotter"))
        await talk.clock.sleep(2.9)
        assert talk.stops == []
        await talk.clock.sleep(0.2)

    talk = converse(scenario)
    assert [signal.state for signal in talk.stops] == ["withdrawn"]


def test_noise_side_talk_and_backchannels_reach_nobody_and_each_has_a_reason() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("Mum, can you pass me the milk?")
        await talk.say("uh huh")
        await talk.say("bring me a cup", typed=False, in_domain=False, confidence=0.9)
        await talk.say("bring me a cup", typed=False, confidence=0.05)
        await talk.say("I told him to bring me the cup yesterday")
        await talk.say("")

    talk = converse(scenario)
    assert talk.commands == []
    assert talk.replies == []
    ignored = [event for event in talk.events if event.kind == "ignored"]
    assert len(ignored) == 6
    assert all(event.text for event in ignored)


def test_what_was_heard_badly_is_asked_back_and_not_done() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me a cup", typed=False, confidence=0.2)

    talk = converse(scenario)
    assert talk.commands == []
    assert talk.said().endswith("?")


def test_a_fragment_waits_for_its_continuation() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("could you bring me the", wait=0.8)
        assert talk.replies == []
        await talk.say("white bowl")

    talk = converse(scenario)
    (command,) = talk.commands
    assert isinstance(command, m.BringMe)
    assert command.objects == (spec("bowl", "white"),)


def test_a_fragment_without_continuation_is_ignored_with_a_question() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the", wait=2.0)

    talk = converse(scenario)
    assert talk.events[-1].kind == "ignored"
    assert talk.said().endswith("?")


def test_a_misheard_word_is_repaired_or_asked_about() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me a bull", typed=False, confidence=0.8)
        await talk.say("get me the read cop", typed=False, confidence=0.8, alternatives=("get me the red cup",))

    talk = converse(scenario)
    assert [command.objects[0] for command in talk.commands if isinstance(command, m.BringMe)] == [
        spec("bowl"),
        spec("cup", "red"),
    ]


def test_older_people_hear_each_movement_before_it_begins_and_younger_people_only_results() -> None:
    async def scenario(talk: Talk, band: m.Band) -> None:
        await talk.say("bring me a spoon", band=band)
        spoon = spec("spoon", "blue")
        await talk.works_on(spoon, step="transporting_search", move_base=True, destination_location="drawer")
        await talk.works_on(spoon, step="transporting_fetch", move_arm=True, current_location="drawer")
        await talk.works_on(spoon, step="transporting_deliver", move_base=True, destination_location="table")

    async def with_older(talk: Talk) -> None:
        await scenario(talk, "older")

    async def with_younger(talk: Talk) -> None:
        await scenario(talk, "younger")

    older, younger = converse(with_older), converse(with_younger)
    assert len(older.replies) == 4
    assert len(younger.replies) == 1
    assert older.replies[0].rate < younger.replies[0].rate
    assert [reply.urgency for reply in older.replies[1:]] == ["background"] * 3


def test_an_announcement_that_is_overtaken_is_taken_back_unless_it_was_spoken() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me a spoon", band="older")
        await talk.works_on(spec("spoon"), step="transporting_search")
        await talk.clock.sleep(1.0)
        await talk.works_on(spec("spoon"), step="transporting_fetch", move_arm=True)
        spoken = talk.replies[-1]
        talk.bus.publish(VOICE_STATUS, m.VoiceStatus(time=talk.clock.now(), reply=spoken.id, state="finished"))
        await talk.works_on(spec("spoon"), step="transporting_deliver", move_base=True, destination_location="table")

    talk = converse(scenario)
    assert talk.replies[2].supersedes == (talk.replies[1].id,)
    assert talk.replies[3].supersedes == ()


@pytest.mark.parametrize("band", ["older", "unknown"])
def test_an_announcement_is_taken_back_when_its_step_is_over_even_if_nothing_new_is_said(band: m.Band) -> None:
    retracted: list[m.Retraction] = []

    async def scenario(talk: Talk) -> None:
        talk.bus.on(RETRACTION, retracted.append)
        await talk.say("bring me a spoon", band=band)
        await talk.works_on(spec("spoon"), step="transporting_search")
        await talk.works_on(spec("spoon"), step="paused")
        await talk.works_on(spec("spoon"), step="paused", progress=0.5)

    talk = converse(scenario)
    assert talk.replies[-1].urgency == "background"
    assert [message.replies for message in retracted] == [(talk.replies[-1].id,)]


def test_wishes_win_over_age_at_once_and_stay() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("slower please", band="younger")
        await talk.say("tell me what you are doing", band="younger")
        for number in range(30):
            await talk.say("bring me a spoon" if number % 2 else "thank you", band="younger")
        await talk.works_on(spec("spoon"), step="transporting_fetch", move_arm=True)

    talk = converse(scenario)
    assert talk.replies[0].rate < 190
    assert talk.replies[-1].urgency == "background"
    assert talk.replies[-1].rate == talk.replies[0].rate


def test_a_stated_age_is_the_band_of_the_next_command() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("I am eighty years old", band="younger")
        await talk.say("bring me a spoon", band="younger")

    talk = converse(scenario)
    assert talk.commands[0].band == "older"
    assert talk.replies[-1].style == "older"


def test_outcomes_are_told_and_an_alternative_can_be_accepted() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the red cup")
        command = talk.commands[0]
        talk.bus.publish(
            OUTCOME,
            m.CommandOutcome(
                time=talk.clock.now(), command=command.id, kind="bring_me", status="failed", reason="not_found",
                object=spec("cup", "red"), alternative=spec("cup", "blue"),
            ),
        )  # fmt: skip
        await talk.clock.sleep(0.1)
        assert "blue cup" in talk.said()
        await talk.say("okay")

    talk = converse(scenario)
    assert isinstance(talk.commands[1], m.BringMe)
    assert talk.commands[1].objects[0].color == "blue"


def test_where_the_robot_could_not_see_is_told_with_what_was_not_found() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the red cup", band="older")
        talk.bus.publish(
            OUTCOME,
            m.CommandOutcome(
                time=talk.clock.now(), command=talk.commands[0].id, kind="bring_me", status="failed",
                reason="not_found", object=spec("cup", "red"), behind=m.ObjectSpec(type="milk", location="cabinet"),
            ),
        )  # fmt: skip
        await talk.clock.sleep(0.1)

    texts = [reply.text for reply in converse(scenario).replies]
    assert texts[-2:] == [
        "I could not see what is behind the milk in the cabinet.",
        "I am sorry, I looked everywhere, but I cannot find the red cup.",
    ]


def test_done_is_told_with_the_object() -> None:
    async def scenario(talk: Talk) -> None:
        await talk.say("bring me the red cup", band="older")
        done = m.CommandOutcome(
            time=0.0,
            command=talk.commands[0].id,
            kind="bring_me",
            status="done",
            object=spec("cup", "red"),
            place="table",
        )
        talk.bus.publish(OUTCOME, done)
        await talk.clock.sleep(0.1)

    assert "red cup" in converse(scenario).said()


def test_a_place_that_this_kitchen_lacks_is_refused_in_words() -> None:
    async def scenario(talk: Talk) -> None:
        talk.bus.publish(WORLD, m.WorldState(time=0.0))
        await talk.say("say that again")
        await talk.say("where is the milk?")
        await talk.say("what are you doing?")

    talk = converse(scenario)
    assert talk.commands == []
    assert len(talk.replies) == 3


def test_replies_vary_and_repeat_never_twice_in_a_row() -> None:
    async def scenario(talk: Talk) -> None:
        for _ in range(6):
            await talk.say("bring me a spoon")

    texts = [reply.text for reply in converse(scenario).replies]
    assert len(set(texts)) > 1
    assert all(first != second for first, second in zip(texts, texts[1:], strict=False))


def test_what_goes_back_is_not_announced_as_brought_and_an_incomplete_breakfast_is_not_ready() -> None:
    cup = spec("cup", "red")

    async def scenario(talk: Talk) -> None:
        await talk.say("please make breakfast")
        command = talk.commands[0]
        back = (m.QueuedTask(object=cup, destination="", status="returning"),)
        await talk.works_on(cup, step="transporting_deliver", move_base=True, destination_location="shelf", queue=back)
        assert "back" in talk.said()
        assert "ringing" not in talk.said()
        ended = m.CommandOutcome(time=0.0, command=command.id, kind="setting_breakfast", status="failed", place="table")
        talk.bus.publish(OUTCOME, ended)
        await talk.clock.sleep(0.1)

    talk = converse(scenario)
    assert "ready" not in talk.said()
    assert "orry" in talk.said()
