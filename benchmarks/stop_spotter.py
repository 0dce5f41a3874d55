"""How surely and how fast the stop spotter alone hears a spoken stop, without the recogniser, and what it mistakes.

Much cheaper than the whole session (`stops`), so with every voice that was not used in development. All audio is
synthetic.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from attune.evaluation.speakers import Speaker
from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE, Frame
from attune.speech.echo import EchoCanceller
from attune.speech.stop_spotter import StopSpotter
from benchmarks.stops import PAUSE, QUIET_ROOM, SENTENCES, Surroundings, background, faster, share, voices

_LATEST = 0.7
"""A stop that is spotted later than this after its end [s] is missed."""


@dataclass(frozen=True, slots=True)
class Spotted:
    """What was made of one sentence.

    Attributes:
        delay: From its end to the spotted stop [s]; None without one.
        order: Probability that it was an order to stop, half a second after its end.
    """

    text: str
    delay: float | None
    order: float


def spot(speaker: Speaker, sentences: Sequence[str], surroundings: Surroundings, snr: float) -> list[Spotted]:
    """One voice says the sentences to a spotter, behind what lowers noise."""
    rng = np.random.default_rng(0)
    spoken = [speaker.say(text) for text in sentences]
    pause = np.zeros(int(PAUSE * SAMPLE_RATE), np.float32)
    sound = np.concatenate([pause, *(part for speech in spoken for part in (speech, pause))])
    level = QUIET_ROOM if surroundings == "quiet" else speaker.level - snr
    sound = (sound + background(surroundings, len(sound), level, rng)).astype(np.float32)
    ends, at = [], PAUSE
    for speech in spoken:
        at += len(speech) / SAMPLE_RATE
        ends.append(at)
        at += len(pause) / SAMPLE_RATE
    spotter, cleaner = StopSpotter(), EchoCanceller(echo_cancellation=False, noise_suppression=True)
    times: list[float] = []
    orders: list[float] = []
    for index in range(0, len(sound) - FRAME_SAMPLES, FRAME_SAMPLES):
        frame = cleaner.clean(Frame(sound[index : index + FRAME_SAMPLES], index / SAMPLE_RATE))
        if spotter.accept(frame.samples, frame.end):
            times.append(frame.end)
        if len(orders) < len(ends) and frame.end >= ends[len(orders)] + 0.6:
            orders.append(spotter.order(ends[len(orders)]))
    found = []
    for text, speech, end, order in zip(sentences, spoken, ends, orders, strict=True):
        begin = end - len(speech) / SAMPLE_RATE
        first = next((time for time in times if begin <= time <= end + _LATEST), None)
        found.append(Spotted(text, None if first is None else first - end, order))
    return found


def stops(found: Sequence[Spotted]) -> dict[str, Any]:
    """Of orders to stop."""
    last = [f for f in found if f.text in SENTENCES["stops"] and f.text != "stop stop"]
    delays = [1000 * f.delay for f in last if f.delay is not None]
    return {
        "not spotted": share(sum(f.delay is None for f in found), len(found)),
        "end of word to spotting, median and 95th percentile [ms]": [
            round(float(np.quantile(delays, each))) for each in (0.5, 0.95)
        ],
        "taken for no order (under 0.5)": share(sum(f.order < 0.5 for f in found), len(found)),
    }


def main() -> dict[str, Any]:
    """Measure; some minutes of processor time with all voices (ATTUNE_BENCHMARK_VOICES=0)."""
    speakers = voices()
    both = [*speakers, *(faster(speaker) for speaker in speakers)]
    orders = [*SENTENCES["stops"], *SENTENCES["stops_within"]]
    results: dict[str, Any] = {"measured on": f"{len(speakers)} synthetic voices, clean at two speeds"}
    results["stop, clean"] = stops([f for v in both for f in spot(v, orders, "quiet", 0.0)])
    noises: tuple[Surroundings, ...] = ("pink", "kitchen", "babble")
    for kind in noises:
        results[f"stop, {kind} at 15 dB"] = stops([f for v in speakers for f in spot(v, orders, kind, 15.0)])
    for name in ("relatives", "not_stops"):
        found = [f for v in speakers for f in spot(v, SENTENCES[name], "quiet", 0.0)]
        results[name] = {
            "spotted": share(sum(f.delay is not None for f in found), len(found)),
            "taken for an order (0.5, 0.9)": [share(sum(f.order >= t for f in found), len(found)) for t in (0.5, 0.9)],
        }
    return results
