"""The robot's voice in a simulated room: it does not hear itself, and people can speak over it.

Real voice, echo canceller, listener and recogniser; synthetic speech (espeak-ng), in virtual time.
"""

import anyio
import numpy as np
import pytest

from attune.core.bus import REPLY, SPEECH_ACTIVITY, SPEECH_STOP, UTTERANCE, VOICE_STATUS, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig, VoiceConfig
from attune.core.messages import Reply, SpeechActivity, StopSignal, Utterance, VoiceStatus
from attune.evaluation.room import RoomAudio
from attune.evaluation.speakers import Speaker, noise, people
from attune.speech.audio import FRAME_SAMPLES, Frame
from attune.speech.echo import LATENCY, EchoCanceller
from attune.speech.listener import Listener
from attune.speech.sphinx import SphinxRecogniser
from attune.voice.voice import Voice

pytest.importorskip("livekit", reason="the extra `echo` is not installed")

REPLY_TEXT = "I am bringing the milk from the fridge to the table now, please do not stop me, it takes a little while."
ANNA, DAN, ERIK = people()[0], people()[3], people()[4]


class Conversation:
    """A robot that speaks and listens in one room with a person."""

    def __init__(self, speaker: Speaker = ANNA, *, cancel: bool = True, **room: float) -> None:
        self.clock, self.bus = VirtualClock(), Bus()
        self.room = RoomAudio(self.clock, speaker, **room)  # type: ignore[arg-type]
        self.canceller = EchoCanceller() if cancel else None
        self.utterances: list[Utterance] = []
        self.stops: list[StopSignal] = []
        self.activity: list[SpeechActivity] = []
        self.voice: list[VoiceStatus] = []
        self.played: list[tuple[float, float]] = []
        self.bus.on(UTTERANCE, self.utterances.append)
        self.bus.on(SPEECH_STOP, self.stops.append)
        self.bus.on(SPEECH_ACTIVITY, self.activity.append)
        self.bus.on(VOICE_STATUS, self.voice.append)

    def hold(self, recogniser: SphinxRecogniser, says: str = "", at: float = 0.0, lasts: float = 12.0) -> float:
        """The robot speaks from 1 s on; the person says something at a time. Returns when they end."""
        end = at

        def played(samples: np.ndarray, rate: int, time: float) -> None:
            if np.abs(samples).max() > 1e-3:
                self.played.append((time, float(np.sqrt(np.mean(samples**2)))))
            if self.canceller:
                self.canceller.played(samples, rate, time)

        async def main() -> None:
            nonlocal end
            voice = Voice(self.bus, self.clock, VoiceConfig(), on_playback=played, output=self.room)
            clean = {"clean": self.canceller.clean} if self.canceller else {}
            listener = Listener(
                self.bus,
                self.clock,
                self.room,
                (),
                SpeechConfig(),
                recogniser=recogniser,
                **clean,  # type: ignore[arg-type]
            )
            async with anyio.create_task_group() as group:
                group.start_soon(voice.run)
                group.start_soon(listener.run)
                await self.clock.sleep(1.0)
                self.bus.publish(REPLY, Reply(time=self.clock.now(), text=REPLY_TEXT))
                if says:
                    end = self.room.person.say(says, at=at)
                await self.clock.sleep(lasts)
                group.cancel_scope.cancel()

        run(main, self.clock)
        return end

    @property
    def texts(self) -> list[str]:
        return [utterance.text for utterance in self.utterances]


@pytest.mark.parametrize("room", [
    {"echo_level": -3.0, "delay": 0.03},
    {"echo_level": -12.0, "delay": 0.12, "reverberation": 0.4},
], ids=["loud and near", "softer and late"])  # fmt: skip
def test_the_robot_does_not_hear_itself(room: dict[str, float], recogniser: SphinxRecogniser) -> None:
    talk = Conversation(**room)  # type: ignore[arg-type]
    talk.hold(recogniser)
    assert talk.voice[-1].state == "finished"
    assert (talk.texts, talk.stops, talk.activity) == ([], [], [])


def test_without_echo_cancellation_it_does(recogniser: SphinxRecogniser) -> None:
    talk = Conversation(cancel=False)
    talk.hold(recogniser)
    assert talk.activity


@pytest.mark.parametrize("speaker", [ANNA, DAN], ids=lambda speaker: speaker.name)
def test_a_person_who_speaks_over_it_silences_it_and_is_heard(speaker: Speaker, recogniser: SphinxRecogniser) -> None:
    talk = Conversation(speaker)
    talk.hold(recogniser, "i would like a red cup instead", at=3.0)
    assert talk.texts == ["i would like a red cup instead"]
    assert talk.voice[-1].state == "interrupted"
    # What is handed over 0.1 s ahead is dropped by the output.
    assert max(time for time, _ in talk.played) - 0.1 < 3.0 + 0.2


@pytest.mark.parametrize("speaker", [ERIK, DAN], ids=lambda speaker: speaker.name)
def test_a_backchannel_does_not_silence_it_for_good(speaker: Speaker, recogniser: SphinxRecogniser) -> None:
    talk = Conversation(speaker)
    talk.hold(recogniser, "uh huh", at=3.0)
    assert talk.activity[0].speaking
    assert talk.voice[-1].state == "finished"
    assert talk.voice[-1].spoken == REPLY_TEXT
    assert talk.stops == []


@pytest.mark.parametrize("speaker", [ANNA, DAN], ids=lambda speaker: speaker.name)
def test_stop_over_its_voice_is_heard(speaker: Speaker, recogniser: SphinxRecogniser) -> None:
    talk = Conversation(speaker)
    talk.hold(recogniser, "please stop", at=3.0)
    assert len(talk.texts) == 1
    assert "stop" in talk.texts[0]


def test_what_comes_out_is_what_went_in_when_the_robot_is_silent() -> None:
    canceller = EchoCanceller()
    speech = ANNA.say("bring me the red cup")
    speech = np.concatenate([noise(16000, -60, np.random.default_rng(0)), speech])
    frames = [
        canceller.clean(Frame(speech[i : i + FRAME_SAMPLES], i / 16000))
        for i in range(0, len(speech) - FRAME_SAMPLES, FRAME_SAMPLES)
    ]
    assert frames[0].time == pytest.approx(-LATENCY)
    out = np.concatenate([frame.samples for frame in frames])
    loud_before, loud_after = (
        np.sqrt(np.mean(sound[: len(out) // 320 * 320].reshape(-1, 320) ** 2, axis=1)) for sound in (speech, out)
    )
    assert np.corrcoef(loud_before[50:-1], loud_after[51:])[0, 1] > 0.9
    assert loud_after[50:].mean() == pytest.approx(loud_before[50:].mean(), rel=0.3)


def test_a_gap_in_the_microphone_s_times_does_not_break_it() -> None:
    canceller = EchoCanceller()
    silence = np.zeros(FRAME_SAMPLES, np.float32)
    times = [canceller.clean(Frame(silence, time)).time for time in (0.0, 0.032, 5.0, 5.032)]
    assert times == pytest.approx([time - LATENCY for time in (0.0, 0.032, 5.0, 5.032)])
