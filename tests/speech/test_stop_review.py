"""Whether a short utterance is an order to stop, from real sound and from what a recogniser may have made of it."""

import math

import numpy as np
import pytest

from attune.evaluation.speakers import Speaker, noise, people
from attune.speech.audio import Samples
from attune.speech.recogniser import Recognition
from attune.speech.stop_judge import StopJudge
from attune.speech.stop_review import Evidence, overruled
from attune.speech.stop_words import reads_as_stop

ANNA, _, CLARA, _, ERIK = people()[:5]


def said(speaker: Speaker, text: str) -> Samples:
    """In a quiet room, with a pause before and after."""
    pause = np.zeros(6000, np.float32)
    sound = np.concatenate([pause, speaker.say(text), pause])
    return np.asarray(sound + noise(len(sound), -65, np.random.default_rng(0)), np.float32)


@pytest.fixture(scope="module")
def judge() -> StopJudge:
    return StopJudge()


@pytest.mark.parametrize("speaker", [CLARA, ERIK], ids=lambda speaker: speaker.name)
@pytest.mark.parametrize(("spoken", "heard", "spotted", "is_order"), [
    ("no stop", "don't stop", False, True),
    ("don't stop", "don't stop", True, False),
    ("please stop", "please talk", True, True),
    ("bring me a plate", "bring me a plate", True, False),
    ("hey stop", "do you stop", True, True),
    ("hello robot", "hello robot", True, False),
    ("stop", "", True, True),
    ("stop", "", False, False),
])  # fmt: skip
def test_the_sound_decides_where_the_text_may_be_wrong(
    speaker: Speaker, spoken: str, heard: str, spotted: bool, is_order: bool, judge: StopJudge
) -> None:
    samples = said(speaker, spoken)
    evidence = Evidence(spotted, sure=False, seconds=1.0, lead=lambda: judge.lead(samples, heard))
    result = overruled(Recognition(heard, confidence=0.6, in_domain=True), evidence, reads_as_stop)
    assert reads_as_stop(result.text) == is_order
    assert (result.text == heard) == (not is_order or reads_as_stop(heard))


def test_a_spotted_stop_in_a_long_sentence_is_left_to_the_recogniser() -> None:
    heard = Recognition("the bus stop is around the corner", confidence=0.6)
    assert overruled(heard, Evidence(True, True, 2.4, lambda: math.inf), reads_as_stop) == heard


def test_an_alternative_that_is_an_order_to_stop_is_preferred() -> None:
    heard = Recognition("please talk", alternatives=("please stop", "please tell"), confidence=0.2)
    result = overruled(heard, Evidence(True, False, 0.9, lambda: 0.1), reads_as_stop)
    assert (result.text, result.alternatives, result.in_domain) == ("please stop", ("please talk", "please tell"), True)
    assert result.confidence >= 0.5


def test_the_evidence_is_infinite_where_there_is_no_text_and_small_where_the_text_fits(judge: StopJudge) -> None:
    assert judge.lead(said(ANNA, "stop"), "") == math.inf
    assert judge.lead(said(ANNA, "bring me a plate"), "bring me a plate") < -0.6 < judge.lead(said(ANNA, "stop"), "top")
