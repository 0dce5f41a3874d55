"""What listens by default, Whisper with the package's real weights beside PocketSphinx, on speech and other sounds."""

import numpy as np
import pytest

from attune.core.bus import UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.messages import Utterance
from attune.core.scene import load_scene
from attune.dialogue.corpus import domain_sentences
from attune.evaluation.speakers import noise, people
from attune.speech.audio import ArraySource, Samples
from attune.speech.choice import choose_recogniser
from attune.speech.listener import Listener
from attune.speech.recogniser import Recogniser, Recognition
from attune.speech.whisper import WhisperRecogniser, repeats

ERIK = people()[4]
ACTED_ON = 0.3


@pytest.fixture(scope="module")
def whisper() -> Recogniser:
    chosen = choose_recogniser(SpeechConfig(), domain_sentences(load_scene()))
    assert isinstance(chosen.recogniser, WhisperRecogniser)
    return chosen.recogniser


def in_quiet(*sounds: Samples | float) -> Samples:
    parts = [np.zeros(int(s * 16000), np.float32) if isinstance(s, float) else s for s in sounds]
    samples = np.concatenate(parts)
    return np.asarray(samples + noise(len(samples), -65, np.random.default_rng(0)), dtype=np.float32)


def read(whisper: Recogniser, sound: Samples) -> Recognition:
    whisper.start()
    whisper.accept(sound)
    return whisper.finish()


@pytest.mark.parametrize("said", ["bring me a cup", "stop", "please put the blue plate on the table"])
def test_orders_are_understood_and_not_repeated(said: str, whisper: Recogniser) -> None:
    heard = read(whisper, in_quiet(0.3, ERIK.say(said), 0.4))
    assert heard.text == said
    assert heard.in_domain
    assert heard.confidence >= ACTED_ON
    assert " ".join(word.text for word in heard.words) == said


def test_other_talk_is_understood_but_not_acted_on(whisper: Recogniser) -> None:
    heard = read(whisper, in_quiet(0.3, ERIK.say("the football match last night was wonderful"), 0.4))
    assert heard.text.endswith("was wonderful")
    assert not heard.in_domain or heard.confidence < ACTED_ON


def test_sounds_that_are_no_speech_are_not_acted_on(whisper: Recogniser) -> None:
    rng = np.random.default_rng(3)
    times = np.arange(16000) / 16000
    clatter = (0.3 * np.sin(2 * np.pi * 3000 * times) * np.exp(-20 * times)).astype(np.float32)
    hum = (0.1 * np.sin(2 * np.pi * 100 * times)).astype(np.float32)
    for sound in (noise(16000, -30, rng), noise(24000, -25, rng, "white"), clatter, hum, np.zeros(16000, np.float32)):
        heard = read(whisper, in_quiet(0.3, sound, 0.4))
        assert not heard.in_domain or heard.confidence < ACTED_ON, heard.text


def test_what_was_finished_too_early_goes_on(whisper: Recogniser) -> None:
    said = "please put the blue plate on the table"
    sound = in_quiet(0.3, ERIK.say(said), 0.4)
    whisper.start()
    whisper.accept(sound[:16000])
    assert whisper.finish().text != said
    whisper.accept(sound[16000:])
    assert whisper.at_pause() == whisper.finish().text == said


def test_who_goes_on_after_a_pause_is_read_to_the_end(whisper: Recogniser) -> None:
    clock, bus = VirtualClock(), Bus()
    heard: list[Utterance] = []
    bus.on(UTTERANCE, heard.append)
    sound = in_quiet(
        1.0,
        ERIK.say("could you get me"),
        0.6,
        ERIK.say("a glass of milk"),
        2.5,
        ERIK.say("please put the blue plate on the table"),
        1.5,
    )
    whole = {"could you get me a glass of milk": True, "please put the blue plate on the table": True}
    listener = Listener(bus, clock, ArraySource(sound), (), SpeechConfig(), is_complete=whole.get, recogniser=whisper)
    run(listener.run, clock)
    assert [utterance.text for utterance in heard] == list(whole)
    # What is complete ends half a second after its last word, because the text was there by then.
    assert heard[0].time - heard[0].end < 0.6


def test_a_decoder_that_repeats_itself_is_noticed() -> None:
    assert repeats("bring me a cup " * 4)
    assert not repeats("stop stop stop")
    assert not repeats("bring me a cup and a cup and a bowl")
