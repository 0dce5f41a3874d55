"""Whether people who pause within a sentence are cut off. Synthetic voices (espeak-ng, flite), no human.

The sentences are said in two or three pieces with a pause between them, in one session for each voice, as the session's
listener hears them. A sentence is cut off if it becomes more than one utterance.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from attune.core.bus import UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.messages import Band, Utterance
from attune.core.scene import load_scene
from attune.dialogue.completeness import completeness, reads_as_stop
from attune.dialogue.corpus import domain_sentences
from attune.evaluation.speakers import Speaker, noise
from attune.speech.audio import SAMPLE_RATE, ArraySource
from attune.speech.choice import choose_recogniser
from attune.speech.listener import Listener
from benchmarks.stops import share, voices

WITHIN = (
    "bring me the|red cup", "could you|bring me a bowl", "i would like|um|a spoon please", "put it on the|table",
    "please get me|the blue plate from the|cabinet", "can i have a|glass of juice", "i need|a knife",
    "take the|small green cup", "instead of the cup|bring me a bowl", "i want the milk from the|fridge",
)  # fmt: skip
"""The pause is where nothing whole was said yet."""
AFTER_WHOLE = ("bring me a cup|from the cabinet", "i want the plate|please", "bring me a bowl|and a spoon")
"""The pause comes after what could have been all."""
PAUSES = (0.3, 0.8)
"""Shortest and longest [s]."""
BETWEEN = 2.5


def utterances(speaker: Speaker, sentences: Sequence[str], band: Band, seed: int) -> tuple[list[int], list[float]]:
    """For each sentence how many utterances it became, and from its end to the last of them [s]."""
    rng = np.random.default_rng(seed)
    parts, spans, length = [np.zeros(SAMPLE_RATE, np.float32)], [], SAMPLE_RATE
    for sentence in sentences:
        start = length
        pieces = sentence.split("|")
        for index, piece in enumerate(pieces):
            last = index == len(pieces) - 1
            pause = BETWEEN if last else rng.uniform(*PAUSES)
            parts += [speaker.say(piece), np.zeros(int(pause * SAMPLE_RATE), np.float32)]
            length += len(parts[-2]) + len(parts[-1])
        spans.append((start / SAMPLE_RATE, (length - len(parts[-1])) / SAMPLE_RATE))
    sound = np.concatenate(parts)
    sound = (sound + noise(len(sound), -65, rng)).astype(np.float32)
    clock, bus, scene = VirtualClock(), Bus(), load_scene()
    heard: list[Utterance] = []
    bus.on(UTTERANCE, heard.append)
    recogniser = choose_recogniser(SpeechConfig(), domain_sentences(scene)).recogniser
    listener = Listener(
        bus, clock, ArraySource(sound), (), SpeechConfig(), is_complete=completeness(scene),
        is_stop=reads_as_stop(scene), band=lambda: band, recogniser=recogniser,
    )  # fmt: skip
    run(listener.run, clock)
    found = [[u for u in heard if start - 0.5 <= u.start < end + 1] for start, end in spans]
    return [len(f) for f in found], [f[-1].time - end for f, (_, end) in zip(found, spans, strict=True) if f]


def main() -> dict[str, Any]:
    """Measure; takes some minutes."""
    results: dict[str, Any] = {
        "measured on": f"{len(voices())} synthetic voices, pauses of {PAUSES[0]} to {PAUSES[1]} s"
    }
    bands: tuple[Band, ...] = ("unknown", "older")
    for band in bands:
        for name, sentences in (("within a sentence", WITHIN), ("after what could be all", AFTER_WHOLE)):
            counts, delays = [], []
            for seed, speaker in enumerate(voices()):
                count, delay = utterances(speaker, sentences, band, seed)
                counts += count
                delays += delay
            results[f"{name}, age band {band}"] = {
                "cut off": share(sum(count > 1 for count in counts), len(counts)),
                "not heard": sum(count == 0 for count in counts),
                "end of speech to utterance, median [ms]": round(1000 * float(np.median(delays))),
            }
    return results
