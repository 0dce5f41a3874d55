"""The network that hears orders to stop, on really synthesised speech."""

from typing import Literal

import numpy as np
import pytest

from attune.evaluation.noises import background
from attune.evaluation.speakers import Speaker, noise, people
from attune.speech.audio import FRAME_SAMPLES, Samples
from attune.speech.stop_network import StopNetwork
from attune.speech.stop_spotter import StopSpotter

SPEAKERS = [people()[index] for index in (0, 2, 6)]
ORDERS = ("stop", "please stop", "stop it")
OTHERS = ("bring me the red cup", "the weather is fine today", "we were at the station")


def heard(spotter: StopSpotter, sound: Samples) -> list[float]:
    """When a stop was spotted [s]."""
    frames = range(0, len(sound) - FRAME_SAMPLES, FRAME_SAMPLES)
    ends = [(at, (at + FRAME_SAMPLES) / 16000) for at in frames]
    return [end for at, end in ends if spotter.accept(sound[at : at + FRAME_SAMPLES], end)]


@pytest.mark.parametrize("surroundings", ["quiet", "kitchen"])
@pytest.mark.parametrize("speaker", SPEAKERS, ids=lambda speaker: speaker.name)
def test_an_order_is_spotted_as_it_is_said_and_told_from_other_talk(
    speaker: Speaker, surroundings: Literal["quiet", "kitchen"]
) -> None:
    rng = np.random.default_rng(1)
    for text in (*ORDERS, *OTHERS):
        speech = speaker.say(text)
        sound = np.concatenate([np.zeros(24000, np.float32), speech, np.zeros(14000, np.float32)])
        sound = sound + noise(len(sound), -65.0, rng)
        if surroundings == "kitchen":
            sound += 10 ** ((speaker.level - 18) / 20) * background("kitchen", len(sound), rng)
        end = 1.5 + len(speech) / 16000
        spotter = StopSpotter()
        times = heard(spotter, sound.astype(np.float32))
        if text in ORDERS:
            assert len(times) == 1, text
            assert 1.5 < times[0] < end + 0.15
            assert spotter.order(end) > 0.85, text
        else:
            assert spotter.order(end) < 0.5, text
            assert times == [], text


def test_what_it_hears_does_not_depend_on_how_the_sound_is_cut() -> None:
    sound = SPEAKERS[0].say("oh no please stop")
    whole = StopNetwork().accept(sound)
    network = StopNetwork()
    pieces = [network.accept(sound[at : at + 100]) for at in range(0, len(sound), 100)]
    assert whole is not None
    assert [piece for piece in pieces if piece][-1].stop == pytest.approx(whole.stop, abs=1e-4)
    assert whole.stop > 0.5
