"""What else sounds in a home, made by computation: steady noise, many people who talk at once, work in the kitchen."""

from functools import cache
from typing import Literal

import numpy as np

from attune.evaluation.speakers import noise, people
from attune.speech.audio import SAMPLE_RATE, Samples

Noise = Literal["pink", "white", "babble", "kitchen"]
_TALK = (
    "the old bridge was closed for repairs until the end of the year",
    "my cousin has opened a small bookshop near the station",
    "last winter the lake was frozen for more than a month",
    "the neighbours are planning a party on saturday evening",
)
_TALKERS = 6
_CLATTER = 0.25
"""How long a dish rings [s]."""


def background(kind: Noise, count: int, rng: np.random.Generator) -> Samples:
    """Noise with a root mean square of 1, as far as it goes on all the time."""
    if kind == "babble":
        samples = np.asarray(np.sum([_rotated(talk, count, rng) for talk in _talks()], axis=0), dtype=np.float32)
    elif kind == "kitchen":
        samples = _kitchen(count, rng)
    else:
        samples = noise(count, 0.0, rng, kind)
    return (samples / max(float(np.sqrt(np.mean(np.square(samples)))), 1e-9)).astype(np.float32)


def _kitchen(count: int, rng: np.random.Generator) -> Samples:
    """A ventilator that hums, and once a second something that clatters."""
    times = np.arange(count) / SAMPLE_RATE
    samples = noise(count, 0.0, rng) + 0.8 * np.sin(2 * np.pi * 100 * times) + 0.4 * np.sin(2 * np.pi * 200 * times)
    ringing = np.arange(int(_CLATTER * SAMPLE_RATE)) / SAMPLE_RATE
    for _ in range(count // SAMPLE_RATE):
        begin, pitch = int(rng.integers(count - len(ringing))), rng.uniform(1500, 5000)
        dish = np.sin(2 * np.pi * pitch * ringing) + 0.5 * rng.standard_normal(len(ringing))
        samples[begin : begin + len(ringing)] += 3 * dish * np.exp(-30 * ringing)
    return np.asarray(samples, dtype=np.float32)


def _rotated(samples: Samples, count: int, rng: np.random.Generator) -> Samples:
    return np.resize(np.roll(samples, int(rng.integers(len(samples)))), count)


@cache
def _talks() -> tuple[Samples, ...]:
    return tuple(
        np.concatenate([speaker.say(text) for text in (*_TALK[index % 4 :], *_TALK[: index % 4])])
        for index, speaker in enumerate(people()[:_TALKERS])
    )
