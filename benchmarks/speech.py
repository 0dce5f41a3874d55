"""How well and how fast Attune hears. All audio is synthetic (espeak-ng voices), never human.

Each voice is one session through the whole path: source, voice activity, endpointing, recogniser, stop spotter. The
covered sentences are drawn from the grammar that the language model was drawn from, with another seed; the uncovered
ones were written by hand without looking at it. Not an independent test: the voices were chosen among espeak-ng's for
being intelligible, and the adaptation and the stop words were developed on sentences like these.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any

import jiwer
import numpy as np

from attune.core.bus import SPEECH_STOP, UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.messages import StopSignal, Utterance
from attune.core.scene import load_scene
from attune.dialogue.corpus import domain_sentences
from attune.evaluation.speakers import Speaker, noise, people, with_noise
from attune.speech.audio import SAMPLE_RATE, ArraySource, Samples
from attune.speech.listener import Listener
from attune.speech.recogniser import Recognition
from attune.speech.sphinx import SphinxRecogniser

SENTENCES = 10
"""Of each kind, for each voice."""
PAUSE = 1.5
TRAINED_WITH, TESTED_WITH = 0, 77
UNCOVERED = (
    "could you fetch the red cup for me", "i changed my mind i want the blue plate", "leave it on the table",
    "can i have the yellow mug from the shelf", "swap the cup for a glass", "the green one not the red one",
    "take the bread out of the cabinet", "i think i want cereal instead", "can you bring the bowl to the countertop",
    "please fetch me the white plate from the dishwasher",
)  # fmt: skip
OFF_TOPIC = (
    "did you watch the football game last night", "my sister is coming over on sunday afternoon",
    "the weather forecast says it will rain tomorrow", "he bought a new car for his daughter",
    "the train to london leaves at seven", "we should paint the bedroom next month", "i forgot my password again",
    "have you heard from your brother recently", "the cat has been sleeping all day",
    "turn the volume up i cannot hear the radio",
)  # fmt: skip
STOPS = ("stop", "please stop", "robot stop", "no stop", "you should stop")
NEGATED = ("don't stop", "please do not stop", "no need to stop")


@dataclass
class Session:
    """What came of the sentences that one voice said."""

    sentences: Sequence[str]
    ends: list[float] = field(default_factory=list)
    heard: list[list[Utterance]] = field(default_factory=list)
    stops: list[list[StopSignal]] = field(default_factory=list)
    seconds: float = 0.0
    processor_seconds: float = 0.0

    @property
    def texts(self) -> list[str]:
        """What was heard of each sentence."""
        return [" ".join(utterance.text for utterance in utterances) for utterances in self.heard]


class TimedRecogniser(SphinxRecogniser):
    """Keeps how long each utterance's end took."""

    def finish(self) -> Recognition:
        """End the utterance."""
        began = time.perf_counter()
        recognition = super().finish()
        self.times.append(time.perf_counter() - began)
        return recognition

    times: list[float] = []
    """Of all sessions."""


def session(speaker: Speaker, sentences: Sequence[str], model: Sequence[str], snr: float | None = None) -> Session:
    """One voice says the sentences, with a pause after each; `snr` is in decibels."""
    result = Session(sentences)
    parts: list[Samples] = [np.zeros(SAMPLE_RATE, np.float32)]
    starts = []
    for sentence in sentences:
        starts.append(sum(map(len, parts)) / SAMPLE_RATE)
        parts.append(speaker.say(sentence))
        result.ends.append(sum(map(len, parts)) / SAMPLE_RATE)
        parts.append(np.zeros(int(PAUSE * SAMPLE_RATE), np.float32))
    sound = np.concatenate(parts)
    rng = np.random.default_rng(0)
    sound = with_noise(sound, snr, rng) if snr is not None else sound + noise(len(sound), -65, rng)
    clock, bus = VirtualClock(), Bus()
    utterances: list[Utterance] = []
    stops: list[StopSignal] = []
    bus.on(UTTERANCE, utterances.append)
    bus.on(SPEECH_STOP, lambda stop: stops.append(stop) if stop.state == "spotted" else None)
    recogniser = TimedRecogniser(model)
    listener = Listener(bus, clock, ArraySource(sound), (), SpeechConfig(), recogniser=recogniser)
    began = time.process_time()
    run(listener.run, clock)
    result.processor_seconds = time.process_time() - began
    result.seconds = len(sound) / SAMPLE_RATE
    limits = [start - PAUSE / 2 for start in starts[1:]] + [float("inf")]
    for begin, limit in zip([0.0, *limits], limits, strict=False):
        result.heard.append([u for u in utterances if begin <= u.start < limit])
        result.stops.append([s for s in stops if begin <= s.time < limit])
    return result


def recognition(sessions: Sequence[Session], keywords: frozenset[str]) -> dict[str, Any]:
    """Word error rate and what the dialogue needs."""
    spoken = [sentence for s in sessions for sentence in s.sentences]
    heard = [text for s in sessions for text in s.texts]
    wanted = [(word, text.split()) for said, text in zip(spoken, heard, strict=True) for word in said.split()]
    found = [word in words for word, words in wanted if word in keywords]
    by_voice = [jiwer.wer(list(s.sentences), s.texts) for s in sessions]
    return {
        "word error rate [%]": _percent(jiwer.wer(spoken, heard)),
        "best and worst voice [%]": [_percent(min(by_voice)), _percent(max(by_voice))],
        "things, colours and places heard [%]": _percent(np.mean(found)),
        "sentences exact [%]": _percent(np.mean([a == b for a, b in zip(spoken, heard, strict=True)])),
        "taken as out of domain or missed [%]": _percent(
            np.mean([not any(u.in_domain for u in utterances) for s in sessions for utterances in s.heard])
        ),
        "split in two or more [%]": _percent(np.mean([len(u) > 1 for s in sessions for u in s.heard])),
    }


def spotting(sessions: Sequence[Session]) -> dict[str, Any]:
    """Delay and misses of "stop" at the end of a sentence."""
    delays = [
        stops[0].time - end if stops else None for s in sessions for stops, end in zip(s.stops, s.ends, strict=True)
    ]
    spotted = [1000 * delay for delay in delays if delay is not None]
    return {
        "spoken": len(delays),
        "missed": delays.count(None),
        "median from end of word [ms]": round(float(np.median(spotted))),
        "95th percentile [ms]": round(float(np.percentile(spotted, 95))),
    }


def false_stops(sessions: Sequence[Session]) -> dict[str, Any]:
    """Stops spotted where nobody said stop."""
    return {
        "sentences": sum(len(s.sentences) for s in sessions),
        "with a stop spotted": sum(bool(stops) for s in sessions for stops in s.stops),
        "words": sorted(stop.word for s in sessions for stops in s.stops for stop in stops),
    }


def main() -> dict[str, Any]:
    """Measure; takes some minutes."""
    scene = load_scene()
    model = domain_sentences(scene, seed=TRAINED_WITH)
    stop_words = {"stop", "halt", "freeze", "wait", "pause", "hold", "still", "move"}
    others = [s for s in dict.fromkeys(domain_sentences(scene, seed=TESTED_WITH)) if not stop_words & set(s.split())]
    covered = Random(5).sample(others[2000:], SENTENCES)
    words = scene.vocabulary
    keywords = frozenset({*words.types, *words.colors, *words.places})
    voices = people()[:8]
    TimedRecogniser.times = []
    clean = {
        kind: [session(voice, sentences, model) for voice in voices]
        for kind, sentences in (("covered", covered), ("uncovered", UNCOVERED), ("off topic", OFF_TOPIC))
    }
    noisy = {snr: [session(voice, covered, model, snr) for voice in voices] for snr in (20.0, 10.0)}
    stops = {snr: [session(voice, STOPS, model, snr) for voice in voices] for snr in (None, 15.0)}
    negated = [session(voice, NEGATED, model) for voice in voices]
    all_clean = [s for sessions in clean.values() for s in sessions]
    delays = [u[-1].time - end for s in all_clean for u, end in zip(s.heard, s.ends, strict=True) if u]
    off_topic = [any(u.in_domain for u in heard) for s in clean["off topic"] for heard in s.heard]
    return {
        "measured on": f"{len(voices)} espeak-ng voices, {SENTENCES} sentences of each kind and voice",
        "covered phrasings, clean": recognition(clean["covered"], keywords),
        "uncovered phrasings, clean": recognition(clean["uncovered"], keywords),
        "covered, pink noise at 20 dB": recognition(noisy[20.0], keywords),
        "covered, pink noise at 10 dB": recognition(noisy[10.0], keywords),
        "off-topic speech taken as in domain [%]": _percent(np.mean(off_topic)),
        "stop, clean": spotting(stops[None]),
        "stop, pink noise at 15 dB": spotting(stops[15.0]),
        "stop spotted in speech without it": false_stops(all_clean),
        "stop spotted in negated stops": false_stops(negated),
        "end of speech to utterance, without computing [s]": round(float(np.median(delays)), 2),
        "computing at the end of an utterance, median and 95th percentile [ms]": [
            round(1000 * float(np.percentile(TimedRecogniser.times, q))) for q in (50, 95)
        ],
        "listening, processor time per time of speech and pauses [%]": _percent(
            sum(s.processor_seconds for s in all_clean) / sum(s.seconds for s in all_clean)
        ),
    }


def _percent(share: Any) -> float:
    return round(100 * float(share), 1)
