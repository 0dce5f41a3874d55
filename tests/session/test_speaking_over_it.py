"""A person in one room with a robot that speaks: real sound from the loudspeaker to the microphone, in virtual time."""

from dataclasses import dataclass, field

import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, REPLY, ROBOT_STATE, ROBOT_STOP, UTTERANCE, VOICE_STATUS
from attune.core.clock import VirtualClock, run
from attune.core.config import Config, with_values
from attune.evaluation.room import RoomAudio
from attune.evaluation.speakers import Speaker, people
from attune.session.session import Session

pytest.importorskip("livekit", reason="the extra `echo` is not installed")

ANNA, DAN = people()[0], people()[3]
LONG_REPLY = "I am on my way to the cabinet now. There I will look for the cup, and then I will bring it to the table."


@dataclass
class Talk:
    """What came of it."""

    began: float = 0.0
    ended: float = 0.0
    signals: list[m.StopSignal] = field(default_factory=list)
    utterances: list[m.Utterance] = field(default_factory=list)
    commands: list[m.Command] = field(default_factory=list)
    voice: list[m.VoiceStatus] = field(default_factory=list)
    state: m.RobotState | None = None


def talk(config: Config, speaker: Speaker, says: str) -> Talk:
    """The robot fetches something and talks about it; the person says something over its voice."""
    clock, talk = VirtualClock(), Talk()
    room = RoomAudio(clock, speaker)

    async def main() -> None:
        session = Session(with_values(config, {"speech": {"asr": "sphinx"}}), clock, audio=room, loudspeaker=room)
        session.bus.on(ROBOT_STOP, talk.signals.append)
        session.bus.on(UTTERANCE, lambda heard: None if heard.typed else talk.utterances.append(heard))
        session.bus.on(VOICE_STATUS, talk.voice.append)
        async with session.running():
            await clock.sleep(2.0)
            session.say("bring me a cup")
            await clock.sleep(0.5)
            session.bus.on(COMMAND, talk.commands.append)
            session.bus.publish(REPLY, m.Reply(time=clock.now(), text=LONG_REPLY, urgency="urgent"))
            await clock.sleep(2.0)
            talk.began = clock.now()
            if says:
                talk.ended = room.person.say(says)
            await clock.sleep(5.0)
            talk.state = session.bus.latest(ROBOT_STATE)

    run(main, clock)
    return talk


@pytest.mark.parametrize("speaker", [ANNA, DAN], ids=lambda speaker: speaker.name)
def test_a_single_stop_over_the_robot_s_voice_halts_it(speaker: Speaker, config: Config) -> None:
    heard = talk(config, speaker, "stop")
    assert [signal.state for signal in heard.signals] == ["spotted", "confirmed"]
    assert heard.signals[0].time < heard.ended + 0.15
    assert heard.state is not None
    assert heard.state.step == "stopped"


def test_its_own_voice_is_nothing_that_somebody_said(config: Config) -> None:
    heard = talk(config, ANNA, "")
    assert heard.voice[-1].state in {"finished", "word", "started"}
    assert (heard.signals, heard.utterances, heard.commands) == ([], [], [])


def test_a_person_who_speaks_over_it_is_understood(config: Config) -> None:
    heard = talk(config, ANNA, "bring me a bowl instead")
    assert any(status.state == "interrupted" for status in heard.voice if status.time < heard.ended)
    assert [command.kind for command in heard.commands] == ["replace_object"]


@pytest.mark.parametrize("words", ["uh huh", "okay"])
def test_a_backchannel_does_not_silence_it_for_good(words: str, config: Config) -> None:
    heard = talk(config, ANNA, words)
    assert not any(status.state == "interrupted" for status in heard.voice if heard.began < status.time)
    assert heard.signals == []
    assert heard.commands == []
