"""What becomes of an utterance that may have been an order to stop."""

import math

import numpy as np
import pytest

from attune.evaluation.speakers import Speaker, noise, people
from attune.speech.audio import Samples
from attune.speech.recogniser import Recognition
from attune.speech.stop_judge import StopJudge
from attune.speech.stop_review import Evidence, StopReview, overruled
from attune.speech.stop_words import reads_as_stop

CLARA, ERIK = people()[2], people()[4]


def said(speaker: Speaker, text: str) -> Samples:
    """In a quiet room, with a pause before and after."""
    pause = np.zeros(6000, np.float32)
    sound = np.concatenate([pause, speaker.say(text), pause])
    return np.asarray(sound + noise(len(sound), -65, np.random.default_rng(0)), np.float32)


@pytest.fixture(scope="module")
def judge() -> StopJudge:
    return StopJudge()


def never() -> float:
    raise AssertionError("the rest of the sound is asked only where it can decide")


@pytest.mark.parametrize(("heard", "confidence", "spotted", "order", "lead", "is_order"), [
    ("don't stop", 0.6, True, 0.98, 0.0, True),  # "no stop", misheard
    ("don't stop", 0.6, True, 0.9, 0.0, False),
    ("please don't stop", 0.6, True, 0.98, 0.0, False),
    ("blue not stop", 0.2, True, 0.95, 0.0, True),  # "robot stop", misheard
    ("you should not stop", 0.2, True, 0.95, 0.0, False),
    ("not stop now", 0.3, True, 0.96, 0.0, False),
    ("please talk", 0.3, True, 0.9, -2.0, True),
    ("please talk", 0.3, False, 0.9, -2.0, False),
    ("please talk", 0.3, False, 0.6, -0.4, True),
    ("please talk", 0.3, True, 0.6, -2.0, False),
    ("bring me a plate", 0.9, True, 0.9, 0.0, False),
    ("bring me a plate", 0.9, True, 0.98, -2.0, True),
    ("bring me a plate", 0.2, True, 0.2, 0.0, False),
    ("", 0.0, True, 0.6, math.inf, True),
    ("", 0.0, True, 0.1, math.inf, False),
    ("", 0.0, False, 0.9, math.inf, False),
    ("please stop", 0.2, True, 0.6, -0.4, True),
])  # fmt: skip
def test_sound_and_text_decide_together(
    heard: str, confidence: float, spotted: bool, order: float, lead: float, is_order: bool
) -> None:
    recognition = Recognition(heard, confidence=confidence, in_domain=True)
    result = overruled(recognition, Evidence(spotted, order, 1.0, lambda: lead), reads_as_stop)
    assert reads_as_stop(result.text) == is_order
    assert (result.text == heard) == (not is_order or reads_as_stop(heard))
    assert not is_order or result.confidence >= 0.5


@pytest.mark.parametrize(("heard", "order", "is_order"), [
    ("we could do with", 0.7, False),
    ("he could not stop laughing", 0.93, False),
    ("we could do with", 0.96, True),
    ("", 0.7, False),
    ("", 0.9, True),
    ("oh please stop", 0.7, True),
])  # fmt: skip
def test_whoever_speaks_for_long_has_to_sound_more_like_an_order(heard: str, order: float, is_order: bool) -> None:
    recognition = Recognition(heard, confidence=0.1, in_domain=bool(heard))
    result = overruled(recognition, Evidence(spotted=True, order=order, seconds=1.4, lead=lambda: -0.3), reads_as_stop)
    assert reads_as_stop(result.text) == is_order
    assert not is_order or result.confidence >= 0.5


def test_a_stop_that_only_the_text_has_is_no_speech_to_the_robot() -> None:
    heard = Recognition("that is a nice stop", confidence=0.7, in_domain=True)
    assert not overruled(heard, Evidence(False, 0.01, 1.2, never), reads_as_stop).in_domain
    assert overruled(heard, Evidence(True, 0.01, 1.2, never), reads_as_stop) == heard
    assert overruled(heard, Evidence(False, 0.4, 1.2, never), reads_as_stop).in_domain


@pytest.mark.parametrize(("heard", "confidence", "order", "seconds", "is_denied"), [
    ("please stop hitting your door", 0.2, 0.92, 2.1, True),  # what a child was told, misheard
    ("please stop right now robot", 0.2, 0.99, 1.7, False),
    ("please stop hitting your door", 0.6, 0.92, 2.1, False),
    ("stop my table we still have bread for a week", 0.2, 0.6, 3.0, True),
    ("stop it oh just stop it", 0.2, 0.98, 2.4, False),
    ("stop it oh just stop it", 0.2, 0.95, 2.4, True),
])  # fmt: skip
def test_long_talk_that_is_hard_to_understand_has_to_sound_like_an_order(
    heard: str, confidence: float, order: float, seconds: float, is_denied: bool
) -> None:
    recognition = Recognition(heard, confidence=confidence, in_domain=True)
    result = overruled(recognition, Evidence(True, order, seconds, lambda: -0.3), reads_as_stop)
    assert result.in_domain != is_denied


def test_what_the_network_does_not_know_is_left_to_the_text() -> None:
    heard = Recognition("never mind", confidence=0.7, in_domain=True)
    assert overruled(heard, Evidence(False, 0.01, 0.8, never), lambda text: text == "never mind") == heard


def test_a_pause_is_bounded_even_if_the_final_text_is_late() -> None:
    review = StopReview(reads_as_stop)
    review.spotted(1.0)
    assert not review.takes_back("stop", 2.4, speaking=False, order=0.9)
    assert review.takes_back("stop", 2.46, speaking=False, order=0.9)


def test_a_stop_that_is_spotted_after_an_utterance_waits_for_the_next() -> None:
    review = StopReview(reads_as_stop)
    review.spotted(2.0)
    assert not review.decided(1.0)
    assert not review.spotted_in(0.0, 1.0)
    assert review.spotted_in(1.6, 2.1)
    assert review.decided(2.1)
    assert not review.decided(2.1)


def test_a_spotted_stop_in_a_long_sentence_is_left_to_the_recogniser() -> None:
    heard = Recognition("the bus stop is around the corner", confidence=0.6)
    assert overruled(heard, Evidence(True, 0.95, 2.4, never), reads_as_stop) == heard


def test_an_alternative_that_is_an_order_to_stop_is_preferred() -> None:
    heard = Recognition("please talk", alternatives=("please stop", "please tell"), confidence=0.2)
    result = overruled(heard, Evidence(True, 0.9, 0.9, never), reads_as_stop)
    assert (result.text, result.alternatives, result.in_domain) == ("please stop", ("please talk", "please tell"), True)


@pytest.mark.parametrize("speaker", [CLARA, ERIK], ids=lambda speaker: speaker.name)
def test_the_rest_of_the_sound_speaks_for_an_order_or_for_the_text(speaker: Speaker, judge: StopJudge) -> None:
    assert judge.lead(said(speaker, "stop"), "") == math.inf
    assert judge.lead(said(speaker, "please stop"), "please talk") >= -0.8
    assert judge.lead(said(speaker, "bring me a plate"), "bring me a plate") < -0.8
