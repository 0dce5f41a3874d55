"""A reading is trusted less when it fits the domain badly, when a word is doubtful, and in noise."""

from dataclasses import replace

import numpy as np
import pytest

from attune.core.config import DialogueConfig
from attune.evaluation.speakers import noise, people
from attune.speech.confidence import Reading, WrittenReading, signal_to_noise

CLEAR = Reading(over_everyday=10.0, fit=-1.1, weakest_word=0.9, snr=40.0)
DOUBTFUL = replace(CLEAR, fit=-1.6, weakest_word=0.3)
WRITTEN = WrittenReading(fit=-1.0, telling_words=3.0, tokens=-0.8, agreed=0.0, lead=6.0, unknown=0, snr=45.0)
ASK, IGNORE = DialogueConfig().confidence_ask, DialogueConfig().confidence_ignore


def test_a_clear_reading_is_acted_on_and_other_talk_is_not() -> None:
    assert CLEAR.in_domain
    assert CLEAR.confidence > 0.5
    other_talk = Reading(over_everyday=-12.0, fit=-2.5, weakest_word=0.1, snr=40.0)
    assert not other_talk.in_domain
    assert other_talk.confidence < IGNORE


def test_what_is_doubtful_is_acted_on_in_a_quiet_room_and_asked_back_in_noise() -> None:
    assert DOUBTFUL.confidence >= ASK
    in_noise = replace(DOUBTFUL, snr=18.0)
    assert in_noise.in_domain
    assert IGNORE <= in_noise.confidence < ASK


@pytest.mark.parametrize("worse", [{"over_everyday": -20.0}, {"fit": -2.4}, {"weakest_word": 0.0}, {"snr": 12.0}])
def test_each_sign_of_a_bad_reading_lowers_the_confidence(worse: dict[str, float]) -> None:
    assert replace(CLEAR, **worse).confidence < CLEAR.confidence


def test_a_word_about_which_the_recognisers_disagree_is_asked_about_rather_than_guessed_in_noise() -> None:
    assert WRITTEN.confidence >= ASK
    rival = replace(WRITTEN, lead=1.0)
    assert rival.confidence >= ASK
    in_noise = replace(rival, snr=27.0)
    assert in_noise.in_domain
    assert IGNORE <= in_noise.confidence < ASK
    assert replace(in_noise, agreed=1.0).confidence >= ASK


@pytest.mark.parametrize("worse", [
    {"fit": -2.0}, {"tokens": -3.0}, {"lead": 0.5}, {"unknown": 2}, {"snr": 25.0}, {"telling_words": 0.0}
])  # fmt: skip
def test_each_sign_of_a_bad_written_reading_lowers_the_confidence(worse: dict[str, float]) -> None:
    assert replace(WRITTEN, **worse).confidence < WRITTEN.confidence


@pytest.mark.parametrize("snr", [20.0, 10.0])
def test_the_signal_to_noise_ratio_is_told_from_the_pauses_around_an_utterance(snr: float) -> None:
    pause = np.zeros(8000, np.float32)
    speech = np.concatenate([pause, people()[0].say("bring me the red cup"), pause])
    loud = speech[np.abs(speech) > 0.02 * np.abs(speech).max()]
    level = 10 * float(np.log10(np.mean(loud**2))) - snr
    heard = speech + noise(len(speech), level, np.random.default_rng(0), "white")
    assert signal_to_noise(heard) == pytest.approx(snr, abs=4.0)
    assert signal_to_noise(np.zeros(10, np.float32)) == 0.0
