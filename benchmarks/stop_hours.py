"""How often hours of other talk halt the robot for good, and how long they make it pause.

What is said: the sentences of `scripts/understanding` and of the packaged benchmark (fresh part) that are none of the
robot's business, and the talk of `stops.toml`. The dialogue has learnt from the first of these, what hears has not.
Every twentieth has the word "stop" in it, far more than people's talk. It goes through whole sessions whose robot works
all the time. All audio is synthetic.

ATTUNE_BENCHMARK_HOURS says how much. Sessions of some minutes are appended to `benchmarks/stop_hours.jsonl`
(ATTUNE_BENCHMARK_FILE) as they are done, and done only once: given again, the command goes on where it was.
"""

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import count
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from attune.evaluation.speakers import Speaker
from attune.speech.audio import SAMPLE_RATE, Samples
from attune.speech.stop_words import STOP_WORD
from benchmarks.stops import (
    DEVELOPMENT,
    QUIET_ROOM,
    SENTENCES,
    Said,
    Surroundings,
    background,
    listen,
    per_hour,
    voices,
)  # fmt: skip

HOURS = float(os.environ.get("ATTUNE_BENCHMARK_HOURS", "0.1"))
RESULTS = Path(os.environ.get("ATTUNE_BENCHMARK_FILE", Path(__file__).with_suffix(".jsonl")))
SESSION = 300.0
"""At least so long [s]."""
PAUSES = (0.3, 1.6)
"""Between sentences [s]."""
IN: tuple[tuple[Surroundings, float], ...] = (
    ("quiet", 0.0), ("kitchen", 15.0), ("quiet", 0.0), ("pink", 15.0), ("quiet", 0.0), ("babble", 15.0),
)  # fmt: skip
"""Every other session has noise [dB under the speech]."""
WITH_STOP_WORDS = 0.05
ERRANDS = ("bring the red cup to the table", "bring the red cup to the counter")
_UNDERSTANDING = Path(__file__).parents[1] / "scripts" / "understanding"


@dataclass(frozen=True, slots=True)
class Sentence:
    """What is said.

    Attributes:
        source: Whence it is: `understanding`, `fresh` or `talk`.
    """

    text: str
    source: str


def sentences() -> list[Sentence]:
    """Each once, in a fixed random order."""
    found = {}
    for path in sorted(_UNDERSTANDING.glob("*.jsonl")):
        for line in map(json.loads, path.read_text("utf-8").splitlines()):
            if line["expect"]["command"] == "other":
                found.setdefault(line["utterance"], Sentence(line["utterance"], "understanding"))
    fresh = resources.files("attune.data") / "benchmarks" / "language" / "fresh.jsonl"
    for line in map(json.loads, fresh.read_text("utf-8").splitlines()):
        if line["expected"]["command"] == "other":
            found.setdefault(line["utterance"], Sentence(line["utterance"], "fresh"))
    for text in SENTENCES["talk"]:
        found.setdefault(text, Sentence(text, "talk"))
    with_stops = [each for each in found.values() if STOP_WORD.search(each.text.lower())]
    listed = [each for each in found.values() if each not in with_stops]
    # Whole collections are of stops; a household says the word far less often.
    listed += with_stops[:: max(1, round(len(with_stops) / (WITH_STOP_WORDS * len(listed))))]
    return [listed[index] for index in np.random.default_rng(0).permutation(len(listed))]


def sessions(said: Sequence[Sentence], speakers: Sequence[Speaker]) -> Iterator[dict[str, Any]]:
    """Results of one session after the other, without an end; those that the file has are read from it."""
    done = [json.loads(line) for line in RESULTS.read_text("utf-8").splitlines()] if RESULTS.exists() else []
    yield from done
    at = sum(session["sentences"] for session in done)
    for number in count(len(done)):
        # Another voice for each session, and another kind of noise for a voice when it comes again.
        speaker = speakers[number % len(speakers)]
        surroundings, snr = IN[(number + number // len(speakers)) % len(IN)]
        result = session(number, said, at, speaker, surroundings, snr)
        at += result["sentences"]
        with RESULTS.open("a", encoding="utf-8") as file:
            file.write(json.dumps(result) + "\n")
        yield result


def session(
    number: int, said: Sequence[Sentence], first: int, speaker: Speaker, surroundings: Surroundings, snr: float
) -> dict[str, Any]:
    """One voice says sentences, from the first on, for `SESSION` seconds."""
    rng = np.random.default_rng([number, 7])
    parts: list[Samples] = [np.zeros(2 * SAMPLE_RATE, np.float32)]
    spans: list[tuple[Sentence, float, float]] = []
    length = len(parts[0])
    while length < SESSION * SAMPLE_RATE:
        sentence = said[(first + len(spans)) % len(said)]
        speech = speaker.say(sentence.text)
        pause = np.zeros(int(rng.uniform(*PAUSES) * SAMPLE_RATE), np.float32)
        spans.append((sentence, length / SAMPLE_RATE, (length + len(speech)) / SAMPLE_RATE))
        parts += [speech, pause]
        length += len(speech) + len(pause)
    sound = np.concatenate([*parts, np.zeros(3 * SAMPLE_RATE, np.float32)])
    level = QUIET_ROOM if surroundings == "quiet" else speaker.level - snr
    sound = (sound + background(surroundings, len(sound), level, rng)).astype(np.float32)
    signals, utterances = listen(sound, ERRANDS)
    pauses = Said("", "", 0.0, 0.0, tuple(signals), ()).pauses
    halts = []
    for signal in signals:
        if signal.state == "confirmed":
            about = [sentence for sentence, begin, _ in spans if signal.time - 8.0 <= begin < signal.time][-2:]
            heard = next((u.text for u in utterances if u.id == signal.cause), "")
            # The fresh sentences are not to be read by those who develop.
            halts.append({"time": signal.time, "said": [_shown(each) for each in about], "heard": heard})
    return {
        "session": number,
        "voice": speaker.name,
        "surroundings": surroundings,
        "hours": length / SAMPLE_RATE / 3600,
        "sentences": len(spans),
        "with stop words": sum(bool(STOP_WORD.search(each.text.lower())) for each, _, _ in spans),
        "utterances": len(utterances),
        "pauses": pauses,
        "halts": halts,
    }


def _shown(sentence: Sentence) -> str:
    return "(fresh)" if sentence.source == "fresh" else sentence.text


def main() -> dict[str, Any]:
    """Measure; an hour of talk takes about a quarter of an hour of processor time."""
    said, speakers = sentences(), voices(0)
    results: list[dict[str, Any]] = []
    for result in sessions(said, speakers):
        results.append(result)
        if sum(each["hours"] for each in results) >= HOURS:
            break
    hours = sum(each["hours"] for each in results)
    halts = [halt for each in results for halt in each["halts"]]
    pauses = [pause for each in results for pause in each["pauses"]]
    return {
        "measured on": f"{len({each['voice'] for each in results})} synthetic voices"
        f"{' of development' if DEVELOPMENT else ''}, {sum(each['sentences'] for each in results)} sentences, "
        f"{sum(each['with stop words'] for each in results)} with a stop word",
        "hours of talk": round(hours, 2),
        "of these in noise at 15 dB": round(sum(e["hours"] for e in results if e["surroundings"] != "quiet"), 2),
        "stopped for good per hour": per_hour(len(halts), hours),
        "stopped": halts,
        "wrongful pauses": len(pauses),
        "wrongful pause, median and longest [ms]": [round(1000 * median(pauses)), round(1000 * max(pauses))]
        if pauses
        else None,
    }
