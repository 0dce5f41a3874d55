"""What keeps a microphone from hearing well is told in one line, and not again and again."""

import numpy as np
import pytest

from attune.core.bus import EVENT, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.events import Event
from attune.evaluation.speakers import at_level, noise, people
from attune.speech.audio import SAMPLE_RATE, ArraySource, Samples
from attune.speech.levels import advice
from attune.speech.listener import Listener
from attune.speech.sphinx import SphinxRecogniser

SECONDS = 5
TIMES = np.arange(SECONDS * SAMPLE_RATE) / SAMPLE_RATE


def talk(level: float, gain: float = 1.0) -> Samples:
    """Somebody talks all the time, in a quiet room."""
    speech = at_level(people()[0].say("bring me the red cup and the blue bowl from the table please"), level)
    sound = np.resize(np.concatenate([speech, np.zeros(4000, np.float32)]), len(TIMES)) * gain
    return np.clip(sound + noise(len(TIMES), -70, np.random.default_rng(0)), -1, 1).astype(np.float32)


def hum(level: float, frequency: float) -> Samples:
    wave = sum(np.sin(2 * np.pi * frequency * k * TIMES) / k for k in (1, 2, 3))
    return np.asarray(wave * 10 ** (level / 20) + noise(len(TIMES), -65, np.random.default_rng(0)), np.float32)


def warnings(sound: Samples, recogniser: SphinxRecogniser) -> list[str]:
    clock, bus = VirtualClock(), Bus()
    events: list[Event] = []
    bus.on(EVENT, events.append)
    run(Listener(bus, clock, ArraySource(sound), (), SpeechConfig(), recogniser=recogniser).run, clock)
    return [event.text for event in events if event.kind == "warning"]


@pytest.mark.parametrize(("sound", "problem"), [
    (np.zeros(len(TIMES), np.float32), "dead"),
    (noise(len(TIMES), -65, np.random.default_rng(0)) + np.float32(0.1), "offset"),
    (hum(-35, 50), "hum"),
    (hum(-35, 60), "hum"),
    (talk(-20, gain=12.0), "too_loud"),
    (talk(-55), "too_quiet"),
], ids=["dead", "offset", "50 Hz", "60 Hz", "clipped", "soft"])  # fmt: skip
def test_each_problem_is_told_once(sound: Samples, problem: str, recogniser: SphinxRecogniser) -> None:
    assert warnings(sound, recogniser) == [advice(problem)]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "sound", [talk(-23), noise(len(TIMES), -40, np.random.default_rng(0))], ids=["speech", "noise"]
)
def test_good_sound_gives_no_warning(sound: Samples, recogniser: SphinxRecogniser) -> None:
    assert warnings(sound, recogniser) == []
