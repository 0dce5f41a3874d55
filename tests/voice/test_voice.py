"""The voice speaks replies in order, says how far it got, and gives way to people."""

import wave
from collections.abc import Awaitable, Callable
from pathlib import Path

import anyio
import numpy as np
import pytest
from numpy.typing import NDArray

from attune.core.bus import EVENT, REPLY, RETRACTION, SPEECH_ACTIVITY, SPEECH_STOP, UTTERANCE, VOICE_STATUS, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import VoiceConfig
from attune.core.events import Event
from attune.core.messages import Reply, Retraction, SpeechActivity, StopSignal, Utterance, VoiceStatus
from attune.voice.playback import OutputError
from attune.voice.voice import Voice

LONG = "I am going to the table. Then I will look for the blue bowl in the cabinet, and bring it to you."


class Stage:
    """A voice in virtual time, with a record of its statuses and of all that sounded."""

    def __init__(self, output: str = "none", file: str = "") -> None:
        self.clock, self.bus = VirtualClock(), Bus()
        self.statuses: list[VoiceStatus] = []
        self.events: list[Event] = []
        self.heard: list[tuple[float, NDArray[np.float32]]] = []
        self.config = VoiceConfig.model_validate({"output": output, "file": file or "unused.wav"})
        self.bus.on(VOICE_STATUS, self.statuses.append)
        self.bus.on(EVENT, self.events.append)

    def perform(self, script: Callable[[], Awaitable[None]]) -> None:
        async def main() -> None:
            voice = Voice(
                self.bus, self.clock, self.config, on_playback=lambda samples, _, at: self.heard.append((at, samples))
            )
            async with anyio.create_task_group() as group:
                group.start_soon(voice.run)
                await self.clock.sleep(0)
                await script()
                group.cancel_scope.cancel()

        run(main, self.clock)

    def say(self, text: str, **more: object) -> Reply:
        reply = Reply(time=self.clock.now(), text=text, **more)  # type: ignore[arg-type]
        self.bus.publish(REPLY, reply)
        return reply

    def person(self, speaking: bool) -> None:
        self.bus.publish(SPEECH_ACTIVITY, SpeechActivity(time=self.clock.now(), speaking=speaking))

    def states(self, reply: Reply) -> list[str]:
        return [s.state for s in self.statuses if s.reply == reply.id and s.state != "word"]

    def last(self, reply: Reply) -> VoiceStatus:
        return [s for s in self.statuses if s.reply == reply.id][-1]


def test_a_reply_is_spoken_word_by_word_to_its_end() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        replies.append(stage.say(LONG))
        await stage.clock.sleep(30)

    stage.perform(script)
    assert stage.states(replies[0]) == ["started", "finished"]
    assert stage.last(replies[0]).spoken == LONG
    words = [s.spoken for s in stage.statuses if s.state == "word"]
    assert len(words) > 15
    assert all(LONG.startswith(spoken) for spoken in words)
    assert [len(spoken) for spoken in words] == sorted(len(spoken) for spoken in words)


def test_a_person_who_goes_on_speaking_silences_it_and_it_knows_what_was_said() -> None:
    stage, replies, spoke_at = Stage(), [], []

    async def script() -> None:
        replies.append(stage.say(LONG))
        await stage.clock.sleep(2)
        spoke_at.append(stage.clock.now())
        stage.person(True)
        await stage.clock.sleep(5)

    stage.perform(script)
    status = stage.last(replies[0])
    assert status.state == "interrupted"
    assert spoke_at[0] + 0.8 <= status.time <= spoke_at[0] + 0.9
    assert LONG.startswith(status.spoken)
    assert 5 < len(status.spoken) < len(LONG) - 20
    # It was silent from the beginning; what was handed over ahead of its time is dropped by the output.
    assert max(at for at, _ in stage.heard) <= spoke_at[0] + 0.15


def test_a_backchannel_pauses_the_voice_and_it_goes_on_from_there() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        replies.append(stage.say(LONG))
        await stage.clock.sleep(1.0)
        stage.person(True)
        await stage.clock.sleep(0.4)
        stage.person(False)
        await stage.clock.sleep(30)

    stage.perform(script)
    assert stage.states(replies[0]) == ["started", "finished"]
    assert stage.last(replies[0]).spoken == LONG
    # 0.1 s had been handed over when it paused: the output drops it, and it is handed over again.
    assert not [at for at, _ in stage.heard if 1.13 <= at < 1.39]
    assert min(at for at, _ in stage.heard if at > 1.13) == pytest.approx(1.4, abs=0.03)


def test_a_spotted_stop_silences_it_at_once_and_drops_what_was_to_come() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        replies.extend([stage.say(LONG), stage.say("And then the spoon.")])
        await stage.clock.sleep(1.5)
        stage.bus.publish(SPEECH_STOP, StopSignal(time=stage.clock.now(), state="spotted", source="spotter"))
        await stage.clock.sleep(0.3)
        replies.append(stage.say("I have stopped."))
        await stage.clock.sleep(10)

    stage.perform(script)
    first, second, after = replies
    assert stage.last(first).state == "interrupted"
    assert stage.last(first).time == pytest.approx(1.5, abs=0.03)
    assert stage.states(second) == ["dropped"]
    assert stage.states(after) == ["started", "finished"]


def test_an_answer_comes_before_an_announcement_that_waits_and_a_newer_announcement_replaces_it() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        for text, urgency in (("Hello.", "normal"), ("I look around.", "background"), ("I drive now.", "background"),
                              ("I bring a spoon, too.", "normal")):  # fmt: skip
            replies.append(stage.say(text, urgency=urgency))
            await stage.clock.sleep(0.01)
        await stage.clock.sleep(20)

    stage.perform(script)
    assert [stage.states(reply)[-1] for reply in replies] == ["finished", "dropped", "finished", "finished"]
    assert stage.last(replies[3]).time < stage.last(replies[2]).time


def test_what_is_taken_back_is_not_spoken_and_what_was_begun_ends_with_its_sentence() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        replies.extend([stage.say(LONG), stage.say("I am driving to the table.", urgency="background")])
        await stage.clock.sleep(1)
        ids = tuple(reply.id for reply in replies)
        stage.bus.publish(RETRACTION, Retraction(time=stage.clock.now(), replies=ids))
        await stage.clock.sleep(30)

    stage.perform(script)
    begun, waiting = replies
    assert stage.states(begun) == ["started", "interrupted"]
    assert stage.last(begun).spoken == LONG.partition(" Then")[0]
    assert stage.states(waiting) == ["dropped"]


def test_an_urgent_reply_cuts_off_and_a_superseded_one_is_never_spoken() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        replies.append(stage.say(LONG))
        replies.append(stage.say("I will bring the cup."))
        replies.append(stage.say("I look around.", urgency="background"))
        await stage.clock.sleep(1.0)
        replies.append(stage.say("I have dropped it.", urgency="urgent", supersedes=(replies[1].id,)))
        await stage.clock.sleep(10)

    stage.perform(script)
    first, superseded, background, urgent = replies
    assert stage.states(first) == ["started", "interrupted"]
    assert stage.states(superseded) == ["dropped"]
    assert stage.states(background) == ["dropped"]
    assert stage.states(urgent) == ["started", "finished"]


def test_it_does_not_begin_while_somebody_speaks() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        stage.person(True)
        replies.append(stage.say("Here you are."))
        await stage.clock.sleep(2)
        assert stage.states(replies[0]) == []
        stage.person(False)
        await stage.clock.sleep(5)

    stage.perform(script)
    assert stage.states(replies[0]) == ["started", "finished"]


def test_it_waits_out_a_pause_in_a_sentence_but_answers_a_whole_one_at_once() -> None:
    stage, replies = Stage(), []

    async def script() -> None:
        for heard in (False, True):
            stage.person(True)
            await stage.clock.sleep(1)
            stage.person(False)
            await stage.clock.sleep(0.3)
            if heard:
                now = stage.clock.now()
                stage.bus.publish(UTTERANCE, Utterance(time=now, text="bring me a cup", start=now - 1, end=now))
            replies.append(stage.say("All right."))
            await stage.clock.sleep(5)

    stage.perform(script)
    delays = [next(s.time for s in stage.statuses if s.reply == reply.id) - reply.time for reply in replies]
    assert delays == [pytest.approx(0.7, abs=0.05), pytest.approx(0.0, abs=0.05)]


def test_the_file_is_valid_at_every_moment_and_ends_where_the_voice_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "spoken.wav"
    stage = Stage("file", str(path))
    lengths: list[float] = []

    def measure() -> None:
        with wave.open(str(path)) as reader:
            lengths.append(reader.getnframes() / reader.getframerate())

    async def script() -> None:
        measure()
        stage.say(LONG)
        await stage.clock.sleep(1.5)
        measure()
        stage.bus.publish(SPEECH_STOP, StopSignal(time=stage.clock.now(), state="spotted"))
        await stage.clock.sleep(5)
        measure()

    stage.perform(script)
    assert lengths[0] == 0
    assert lengths[1] == pytest.approx(1.6, abs=0.05)
    assert lengths[2] == lengths[1]


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    stage = Stage("file", str(tmp_path / "missing" / "spoken.wav"))

    async def script() -> None:
        await stage.clock.sleep(1)

    with pytest.raises(ExceptionGroup) as failure:
        stage.perform(script)
    assert failure.group_contains(OutputError, match="missing")


def test_without_a_loudspeaker_it_warns_once_and_keeps_its_pace() -> None:
    stage, replies = Stage("speaker"), []

    async def script() -> None:
        replies.extend([stage.say("Hello."), stage.say("Hello again.")])
        await stage.clock.sleep(10)

    try:
        import sounddevice

        has_output = any(device["max_output_channels"] for device in sounddevice.query_devices())
    except OSError:
        has_output = False
    if has_output:
        pytest.skip("this machine has a loudspeaker")
    stage.perform(script)
    assert [event.kind for event in stage.events] == ["warning"]
    assert "not audible" in stage.events[0].text
    assert stage.states(replies[1]) == ["started", "finished"]
