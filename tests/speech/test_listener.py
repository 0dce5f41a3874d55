"""Really synthesised speech, through the real voice activity detection, recogniser and stop spotter."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

import anyio
import numpy as np
import pytest

from attune.core.bus import EVENT, SPEECH_ACTIVITY, SPEECH_STOP, UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.messages import Band, SpeechActivity, StopSignal, Utterance
from attune.evaluation.noises import background
from attune.evaluation.speakers import Speaker, UserAudio, noise, people, with_noise
from attune.speech import stop_words
from attune.speech.age.norms import NormsEstimator
from attune.speech.audio import FRAME_SAMPLES, ArraySource, AudioSource, Frame, Samples
from attune.speech.echo import EchoCanceller
from attune.speech.endpointing import Endpointer, SpeechEnded
from attune.speech.listener import Listener
from attune.speech.sphinx import SphinxRecogniser

ANNA, DAN = people()[0], people()[3]


class Ear:
    """What a listener published."""

    def __init__(self) -> None:
        self.utterances: list[Utterance] = []
        self.stops: list[StopSignal] = []
        self.activity: list[SpeechActivity] = []
        self.clock, self.bus = VirtualClock(), Bus()
        self.bus.on(UTTERANCE, self.utterances.append)
        self.bus.on(SPEECH_STOP, self.stops.append)
        self.bus.on(SPEECH_ACTIVITY, self.activity.append)

    def listen(self, source: AudioSource, recogniser: SphinxRecogniser, **more: object) -> "Ear":
        listener = Listener(self.bus, self.clock, source, (), SpeechConfig(), recogniser=recogniser, **more)  # type: ignore[arg-type]
        run(listener.run, self.clock)
        return self

    @property
    def texts(self) -> list[str]:
        return [utterance.text for utterance in self.utterances]


def room(*sounds: Samples | float, level: float = -65.0) -> Samples:
    """Sounds and pauses [s] one after the other, over a room's noise."""
    parts = [np.zeros(int(s * 16000), np.float32) if isinstance(s, float) else s for s in sounds]
    samples = np.concatenate(parts)
    return np.asarray(samples + noise(len(samples), level, np.random.default_rng(0)), dtype=np.float32)


@pytest.mark.parametrize("speaker", [ANNA, DAN], ids=lambda speaker: speaker.name)
def test_a_spoken_sentence_becomes_an_utterance_with_its_times(speaker: Speaker, recogniser: SphinxRecogniser) -> None:
    speech = speaker.say("please bring me the red cup")
    ear = Ear().listen(ArraySource(room(1.0, speech, 1.5)), recogniser)
    assert ear.texts == ["please bring me the red cup"]
    heard = ear.utterances[0]
    assert heard.start == pytest.approx(1.0, abs=0.15)
    assert heard.end == pytest.approx(1.0 + len(speech) / 16000, abs=0.25)
    assert heard.time == pytest.approx(heard.end + SpeechConfig().end_silence, abs=0.1)
    assert heard.in_domain
    assert heard.confidence > 0.5
    assert heard.text not in heard.alternatives


def test_two_utterances_are_kept_apart_and_a_short_pause_does_not_split_one(recogniser: SphinxRecogniser) -> None:
    ear = Ear().listen(
        ArraySource(
            room(0.5, ANNA.say("bring me a cup"), 1.5, ANNA.say("i would like"), 0.3, ANNA.say("a bowl instead"), 1.0)
        ),
        recogniser,
    )
    assert ear.texts == ["bring me a cup", "i would like a bowl instead"]
    assert [a.speaking for a in ear.activity][::2] == [True] * (len(ear.activity) // 2)


def test_the_pause_that_ends_an_utterance_depends_on_what_was_said(recogniser: SphinxRecogniser) -> None:
    sound = ArraySource(room(0.5, ANNA.say("bring me a"), 0.9, ANNA.say("red cup"), 1.5))
    hesitant = Ear().listen(sound, recogniser, is_complete=lambda text: "cup" in text)
    assert len(hesitant.texts) == 1
    quick = Ear().listen(sound, recogniser, is_complete=lambda text: True)
    assert len(quick.texts) == 2


@pytest.mark.parametrize("make", [
    lambda rng: noise(16000 * 6, -20, rng, "white"),
    lambda rng: noise(16000 * 6, -20, rng, "pink"),
    lambda rng: np.zeros(16000 * 6, np.float32),
    lambda rng: (0.5 * (rng.random(16000 * 6) > 0.9997)).astype(np.float32),
], ids=["white noise", "pink noise", "silence", "clicks"])  # fmt: skip
def test_what_is_no_speech_gives_no_utterance_and_no_stop(
    make: Callable[[np.random.Generator], Samples], recogniser: SphinxRecogniser
) -> None:
    ear = Ear().listen(ArraySource(make(np.random.default_rng(1))), recogniser)
    assert (ear.texts, ear.stops, ear.activity) == ([], [], [])


@pytest.mark.parametrize("speaker", people()[:4], ids=lambda speaker: speaker.name)
def test_stop_is_heard_before_the_utterance_has_ended(speaker: Speaker, recogniser: SphinxRecogniser) -> None:
    speech = speaker.say("stop")
    ear = Ear().listen(ArraySource(room(1.0, speech, 1.5)), recogniser)
    assert [(stop.state, stop.source, stop.word) for stop in ear.stops] == [("spotted", "spotter", "stop")]
    assert ear.stops[0].time < 1.0 + len(speech) / 16000 + 0.15
    assert ear.utterances[0].time > ear.stops[0].time


def test_a_negated_stop_is_no_stop_and_a_repeated_one_is_told_again(recogniser: SphinxRecogniser) -> None:
    assert Ear().listen(ArraySource(room(1.0, ANNA.say("don't stop"), 1.5)), recogniser).stops == []
    ear = Ear().listen(ArraySource(room(1.0, ANNA.say("stop"), 1.2, ANNA.say("stop"), 1.5)), recogniser)
    assert len(ear.stops) == 2


@pytest.mark.parametrize(("text", "reads_as_stop", "states"), [
    ("stop over there for the mail and bring me a bottle of milk please", False, ["spotted", "withdrawn"]),
    ("stop over there for the mail and bring me a bottle of milk please", True, ["spotted", "withdrawn"]),
    ("stop it please", True, ["spotted"]),
], ids=["contradicted", "far too long", "short"])  # fmt: skip
def test_a_stop_is_taken_back_while_people_speak_on(
    text: str, reads_as_stop: bool, states: list[str], recogniser: SphinxRecogniser
) -> None:
    speech = ANNA.say(text)
    ear = Ear().listen(ArraySource(room(1.0, speech, 1.5)), recogniser, is_stop=lambda _: reads_as_stop)
    assert [stop.state for stop in ear.stops][:2] == states
    if "withdrawn" in states:
        assert ear.stops[1].time - ear.stops[0].time < 1.5
        assert ear.stops[1].time < 1.0 + len(speech) / 16000


@pytest.mark.parametrize("colour", ["white", "pink"])
def test_stop_is_heard_in_noise(colour: Literal["white", "pink"], recogniser: SphinxRecogniser) -> None:
    """As a session hears: noise is lowered first."""
    rng = np.random.default_rng(5)
    sound = with_noise(room(3.0, DAN.say("stop"), 2.0, ANNA.say("stop it"), 2.0), 15, rng, colour)
    cleaner = EchoCanceller(echo_cancellation=False, noise_suppression=True)
    ear = Ear().listen(ArraySource(sound), recogniser, clean=cleaner.clean)
    assert [stop.state for stop in ear.stops] == ["spotted", "spotted"]
    assert [stop_words.reads_as_stop(text) for text in ear.texts] == [True, True]


def test_an_order_to_stop_is_an_utterance_of_its_own_while_others_talk_on(recogniser: SphinxRecogniser) -> None:
    speech = DAN.say("please stop")
    sound = np.concatenate([np.zeros(48_000, np.float32), speech, np.zeros(48_000, np.float32)])
    sound += background("babble", len(sound), np.random.default_rng(0)) * 10 ** ((DAN.level - 15) / 20)
    cleaner = EchoCanceller(echo_cancellation=False, noise_suppression=True)
    ear = Ear().listen(ArraySource(sound), recogniser, clean=cleaner.clean)
    [order] = [each for each in ear.utterances if stop_words.reads_as_stop(each.text)]
    assert (order.start, order.end) == pytest.approx((3.0, 3.0 + len(speech) / 16000), abs=0.3)
    [*_, last] = [stop for stop in ear.stops if stop.time < order.time]
    assert last.state == "spotted"


def test_older_and_hesitant_people_get_more_time(recogniser: SphinxRecogniser) -> None:
    def texts(*sounds: Samples | float, band: Band = "unknown") -> int:
        return len(Ear().listen(ArraySource(room(0.5, *sounds, 2.0)), recogniser, band=lambda: band).texts)

    cup, bowl = ANNA.say("bring me a cup"), ANNA.say("and a bowl")
    pauses = SpeechConfig().end_silence + 0.15
    assert texts(cup, pauses, bowl) == 2
    assert texts(cup, pauses, bowl, band="older") == 1
    # Whoever went on right after what seemed to be the end is given the time the next time.
    assert texts(cup, pauses, bowl, 3.0, cup, pauses, bowl) == 3


def test_an_utterance_begins_and_ends_with_the_nearest_voice_while_others_talk_on_in_the_background() -> None:
    talk = ["the weather forecast says it will rain tomorrow", "she told him that the meeting was cancelled again"]
    voices = [np.concatenate([speaker.say(text) for text in talk]) for speaker in people()[1:3]]
    shortest = min(map(len, voices))
    sound = 0.06 * np.sum([voice[:shortest] for voice in voices], axis=0)
    speech = ANNA.say("bring me a cup")
    sound[32000 : 32000 + len(speech)] += speech
    endpointer = Endpointer(SpeechConfig())
    found = [
        change
        for at in range(0, shortest - FRAME_SAMPLES, FRAME_SAMPLES)
        for change in endpointer.accept(Frame(sound[at : at + FRAME_SAMPLES].astype(np.float32), at / 16000))
    ]
    spans = [(change.start, change.end) for change in found if isinstance(change, SpeechEnded)]
    assert (2.0, 2.0 + len(speech) / 16000) in [pytest.approx(span, abs=0.5) for span in spans]


def test_other_talk_is_marked_as_out_of_domain(recogniser: SphinxRecogniser) -> None:
    talk = ["the weather forecast says it will rain tomorrow", "she told him that the meeting was cancelled"]
    ear = Ear().listen(ArraySource(room(0.5, ANNA.say(talk[0]), 1.5, ANNA.say(talk[1]), 1.5)), recogniser)
    assert not any(utterance.in_domain for utterance in ear.utterances)


def test_it_understands_in_some_noise(recogniser: SphinxRecogniser) -> None:
    speech = with_noise(room(1.0, ANNA.say("bring me a cup"), 1.5), 20, np.random.default_rng(3))
    ear = Ear().listen(ArraySource(speech), recogniser)
    assert len(ear.texts) == 1
    assert "cup" in ear.texts[0]


def test_hearing_is_reproducible(domain: list[str], cache: Path) -> None:
    sound = room(0.5, DAN.say("bring me a cup"), 1.0, DAN.say("stop"), 1.0)
    results = []
    for _ in range(2):
        ear = Ear().listen(ArraySource(sound), SphinxRecogniser(domain, cache), age=NormsEstimator())
        results.append(([(u.time, u.text, u.confidence, u.age) for u in ear.utterances], [s.time for s in ear.stops]))
    assert results[0] == results[1]
    assert results[0][0][0][3].probabilities


def test_a_scripted_person_is_heard_at_the_times_they_speak(recogniser: SphinxRecogniser) -> None:
    ear = Ear()
    user = UserAudio(ear.clock, ANNA)
    ends: list[float] = []

    async def main() -> None:
        listener = Listener(ear.bus, ear.clock, user, (), SpeechConfig(), recogniser=recogniser)
        async with anyio.create_task_group() as group:
            group.start_soon(listener.run)
            await ear.clock.sleep(1)
            ends.append(user.say("bring me a cup"))
            ends.append(user.say("stop", at=6.0, speaker=DAN))
            await ear.clock.sleep(9)
            group.cancel_scope.cancel()

    run(main, ear.clock)
    assert ear.texts == ["bring me a cup", "stop"]
    assert [u.end for u in ear.utterances] == pytest.approx(ends, abs=0.25)
    assert 6.0 < ear.stops[0].time < ends[1] + 0.15


def test_an_event_never_carries_what_was_said_in_its_text(recogniser: SphinxRecogniser) -> None:
    ear, texts = Ear(), []
    ear.bus.on(EVENT, lambda event: texts.append(event.text))
    ear.listen(ArraySource(room(0.5, ANNA.say("bring me a cup"), 1.0)), recogniser)
    assert texts
    assert not any("cup" in text for text in texts)
