"""How surely and how fast a spoken stop halts the robot, and how often other talk does.

Everything runs through a whole session (listener, dialogue, planner, robot without physics) in virtual time. All audio
is synthetic: espeak-ng voices, and flite's where it is installed; no human. The voices, and half of the sentences that
are no stops, were not used in development.
"""

import math
import os
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from statistics import median
from typing import Any, Literal

import anyio
import numpy as np

from attune.core.bus import ROBOT_STOP, UTTERANCE
from attune.core.clock import VirtualClock, run
from attune.core.config import load_config, with_values
from attune.core.messages import StopSignal, Utterance
from attune.evaluation.speakers import Speaker, noise, people
from attune.evaluation.speech_samples import held_out_speakers
from attune.session.session import Session
from attune.speech.audio import SAMPLE_RATE, ArraySource, Samples

Surroundings = Literal["quiet", "white", "pink", "babble", "kitchen"]
SENTENCES: dict[str, list[str]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
DEVELOPMENT = bool(os.environ.get("ATTUNE_BENCHMARK_DEVELOPMENT"))
"""Measure with what development may look at."""
MOST_VOICES = int(os.environ.get("ATTUNE_BENCHMARK_VOICES", "4"))
"""For `voices`."""
PAUSE = 2.2
"""After a stop [s]: the sentence must be decided by then."""
QUIET_ROOM = -65.0
"""Noise where there is no other [dB full scale]."""
_FOR_DEVELOPMENT = ("en-us+m2", "en-us+m4", "en-gb+m5", "en-us+Andy", "en-us+Annie", "en-gb+steph", "en-us+linda")
_FOR_MEASURING = (
    "en-us+Alex", "en-gb+Alicia", "en-us+Michael", "en-us+john", "en-gb+belinda", "en-us+shelby", "en-gb+travis",
    "en-us+zac", "en-gb+quincy", "en-us+paul", "en-gb-scotland+m8", "en-us+steph3",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Said:
    """What one voice said once, and what the robot was told about stopping.

    Attributes:
        start: When it began [s].
        end: When it ended [s].
        signals: Of `robot/stop`, from just before it until the next sentence.
        heard: What was understood.
    """

    text: str
    voice: str
    start: float
    end: float
    signals: tuple[StopSignal, ...]
    heard: tuple[str, ...]

    @property
    def delay(self) -> float | None:
        """From the end of the sentence to the first pause of the robot [s], negative when before."""
        first = next((s for s in self.signals if s.state != "withdrawn"), None)
        return None if first is None else first.time - self.end

    @property
    def halted(self) -> bool:
        """Whether the robot was stopped for good."""
        return any(signal.state == "confirmed" for signal in self.signals)

    @property
    def pauses(self) -> list[float]:
        """Lengths of the pauses that were taken back [s]."""
        found, since = [], None
        for signal in self.signals:
            if signal.state == "spotted":
                since = signal.time if since is None else since
            elif since is not None:
                if signal.state == "withdrawn":
                    found.append(signal.time - since)
                since = None
        return found


def voices(most: int = MOST_VOICES) -> list[Speaker]:
    """Who speaks: so many, spread; 0 takes all."""
    found: Sequence[Speaker]
    if DEVELOPMENT:
        found = [*people()[:8], *(Speaker(voice, voice) for voice in _FOR_DEVELOPMENT)]
    else:
        found = [*held_out_speakers(), *(Speaker(voice, voice) for voice in _FOR_MEASURING)]
    most = most or len(found)
    return [found[index * len(found) // most] for index in range(most)]


def faster(speaker: Speaker) -> Speaker:
    """The same voice in a hurry and a little higher, as somebody who is frightened."""
    return replace(speaker, rate_wpm=round(1.2 * speaker.rate_wpm), pitch=min(99, speaker.pitch + 12))


def hear(
    speaker: Speaker, sentences: Sequence[str], surroundings: Surroundings = "quiet", snr: float = math.inf,
    pause: float = PAUSE, seed: int = 0,
) -> list[Said]:  # fmt: skip
    """One voice says the sentences to a session.

    Args:
        speaker: The voice.
        sentences: What it says.
        surroundings: What else sounds.
        snr: Speech over that [dB], where the speech sounds.
        pause: After each sentence [s].
        seed: Of the noise.
    """
    rng = np.random.default_rng(seed)
    parts: list[Samples] = [np.zeros(2 * SAMPLE_RATE, np.float32)]
    spans = []
    length = len(parts[0])
    for text in sentences:
        speech = speaker.say(text)
        spans.append((length / SAMPLE_RATE, (length + len(speech)) / SAMPLE_RATE))
        parts += [speech, np.zeros(int(pause * SAMPLE_RATE), np.float32)]
        length += len(speech) + len(parts[-1])
    sound = np.concatenate(parts)
    level = QUIET_ROOM if surroundings == "quiet" else speaker.level - snr
    sound = (sound + background(surroundings, len(sound), level, rng)).astype(np.float32)
    signals, utterances = listen(sound)
    limits = [start - 0.1 for start, _ in spans[1:]] + [math.inf]
    return [
        Said(
            text, speaker.name, start, end,
            tuple(s for s in signals if start - 0.1 <= s.time < limit),
            tuple(f"{u.text} ({u.confidence:.2f}{'' if u.in_domain else ', other talk'})"
                  for u in utterances if start - 0.1 <= u.time < limit),
        )
        for text, (start, end), limit in zip(sentences, spans, limits, strict=True)
    ]  # fmt: skip


def listen(sound: Samples, errands: Sequence[str] = ()) -> tuple[list[StopSignal], list[Utterance]]:
    """What a session makes of a sound.

    Args:
        sound: 16 kHz mono, from the session's beginning.
        errands: What the robot is told (typed) one after the other, again and again, so that it always works; without
            them it stands by.

    Returns:
        The signals of `robot/stop`, and what was heard.
    """
    signals: list[StopSignal] = []
    utterances: list[Utterance] = []
    clock = VirtualClock()

    async def work(session: Session) -> None:
        for errand in cycle(errands):
            session.say(errand)
            await session.settled()

    async def main() -> None:
        settings = {"robot": {"kind": "symbolic"}, "voice": {"output": "none"}}
        session = Session(with_values(load_config(environment={}), settings), clock, audio=ArraySource(sound))
        session.bus.on(ROBOT_STOP, signals.append)
        session.bus.on(UTTERANCE, lambda utterance: None if utterance.typed else utterances.append(utterance))
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(work, session)
            await clock.sleep(len(sound) / SAMPLE_RATE + 1.0)
            group.cancel_scope.cancel()

    run(main, clock)
    return signals, utterances


def background(surroundings: Surroundings, count: int, level: float, rng: np.random.Generator) -> Samples:
    """Other sound of a root mean square [dB full scale]."""
    if surroundings in {"quiet", "pink"}:
        return noise(count, level, rng)
    if surroundings == "white":
        return noise(count, level, rng, "white")
    sound = _babble(count, rng) if surroundings == "babble" else _kitchen(count, rng)
    return np.asarray(sound / np.sqrt(np.mean(sound**2)) * 10 ** (level / 20), np.float32)


def _babble(count: int, rng: np.random.Generator) -> Samples:
    """Six people who talk at once, all the time."""
    sound = np.zeros(count, np.float32)
    texts = SENTENCES["talk"][::2]
    for speaker in [*people()[:5], Speaker("extra", "en-gb+f1")]:
        at = -int(rng.integers(0, 2 * SAMPLE_RATE))
        while at < count:
            speech = speaker.say(texts[int(rng.integers(len(texts)))])
            piece = speech[max(0, -at) : count - at]
            sound[max(0, at) : max(0, at) + len(piece)] += piece
            at += len(speech)
    return sound


def _kitchen(count: int, rng: np.random.Generator) -> Samples:
    """An extractor hood, running water, and now and then the clatter of dishes."""
    times = np.arange(count) / SAMPLE_RATE
    hood = sum(np.sin(2 * np.pi * 98 * k * times + rng.uniform(0, 6)) / k for k in range(1, 9)) * 0.4
    hood = hood + noise(count, 0.0, rng)
    water = np.diff(noise(count + 1, 0.0, rng, "white")) * (0.6 + 0.2 * np.sin(2 * np.pi * 0.3 * times))
    sound = hood + 0.5 * water
    for at in np.flatnonzero(rng.random(count) < 0.7 / SAMPLE_RATE):
        ring = np.arange(min(count - at, SAMPLE_RATE // 4)) / SAMPLE_RATE
        tones = sum(np.sin(2 * np.pi * rng.uniform(1500, 6000) * ring) for _ in range(4))
        sound[at : at + len(ring)] += 1.5 * tones * np.exp(-ring / 0.05)
    return np.asarray(sound, np.float32)


def share(events: int, count: int) -> str:
    """A rate with its 95 % confidence interval (Wilson)."""
    if not count:
        return "none"
    z = 1.96
    p = events / count
    middle = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count)) / (1 + z * z / count)
    low, high = max(0.0, middle - half), min(1.0, middle + half)
    return f"{100 * p:.1f} % ({events} of {count}; {100 * low:.1f} to {100 * high:.1f} %)"


def per_hour(events: int, hours: float) -> str:
    """A rate with its 95 % upper limit (Poisson, by the chi-squared approximation of Wilson and Hilferty)."""
    degrees = 2 * (events + 1)
    limit = degrees * (1 - 2 / (9 * degrees) + 1.645 * math.sqrt(2 / (9 * degrees))) ** 3 / 2
    return f"{events / hours:.2f} ({events} in {hours:.2f} h; below {limit / hours:.2f})"


def stops(said: Sequence[Said]) -> dict[str, Any]:
    """Of sentences that order the robot to stop."""
    ends = [s for s in said if s.text in SENTENCES["stops"] and s.text != "stop stop"]
    delays = [1000 * s.delay for s in ends if s.delay is not None]
    resumed = sum(bool(s.pauses) and s.halted for s in said)
    return {
        "neither paused nor stopped": share(sum(s.delay is None for s in said), len(said)),
        "not stopped for good": share(sum(not s.halted for s in said), len(said)),
        "end of word to pause, median [ms]": round(median(delays)) if delays else None,
        "95th percentile [ms]": round(float(np.percentile(delays, 95))) if delays else None,
        "moved on for a moment before the text confirmed": resumed,
    }


def others(said: Sequence[Said]) -> dict[str, Any]:
    """Of sentences that do not."""
    hours = sum(s.end - s.start + PAUSE / 2 for s in said) / 3600
    pauses = [pause for s in said for pause in s.pauses]
    return {
        "sentences": len(said),
        "paused": share(sum(s.delay is not None for s in said), len(said)),
        "stopped for good": share(sum(s.halted for s in said), len(said)),
        "stopped for good per hour of it": per_hour(sum(s.halted for s in said), hours),
        "wrongful pause, median and longest [ms]": [round(1000 * median(pauses)), round(1000 * max(pauses))]
        if pauses
        else None,
    }


def main() -> dict[str, Any]:
    """Measure; about ten minutes of processor time with four voices."""
    speakers = voices()
    both = [*speakers, *(faster(speaker) for speaker in speakers)]
    orders = [*SENTENCES["stops"], *SENTENCES["stops_within"]]
    half = slice(0, None, 2) if DEVELOPMENT else slice(1, None, 2)
    noises: tuple[Surroundings, ...] = ("pink", "babble", "kitchen")
    results: dict[str, Any] = {"measured on": f"{len(speakers)} synthetic voices, each at two speeds"}
    results["stop, clean"] = stops([s for v in both for s in hear(v, orders)])
    for kind in noises:
        results[f"stop, {kind} at 15 dB"] = stops([s for v in speakers for s in hear(v, orders, kind, 15.0)])
    results["halt, freeze, wait and the like, clean"] = stops(
        [s for v in speakers for s in hear(v, SENTENCES["relatives"])]
    )
    results["sounds like stop, or no order"] = others([s for v in both for s in hear(v, SENTENCES["not_stops"][half])])
    talk = SENTENCES["talk"][half]
    results["other talk, clean"] = others([s for v in both for s in hear(v, talk, pause=1.0)])
    return results


if __name__ == "__main__":
    import json

    print(json.dumps(main(), indent=2))
