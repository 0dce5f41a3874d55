"""Measures hearing, from the sound to the utterance: real voice activity detection, recogniser and stop spotter."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from attune.core.bus import SPEECH_STOP, UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import SpeechConfig
from attune.core.messages import StopSignal, Utterance
from attune.evaluation.noises import Noise, background
from attune.evaluation.speakers import noise
from attune.evaluation.speech_samples import Sample, SampleSet
from attune.speech.audio import SAMPLE_RATE, ArraySource, Frame, Samples
from attune.speech.endpointing import TRAILING
from attune.speech.listener import Listener
from attune.speech.recogniser import Recogniser, Recognition
from attune.speech.whisper import plain

PAUSE = 1.6
"""After each sample [s]."""
_QUIET_ROOM = -65.0
"""Noise of the clean condition [dB full scale]."""
_AUDIBLE = 0.02
"""Of the peak: what is softer is a pause."""


@dataclass(frozen=True, slots=True)
class Ears:
    """What is measured.

    Attributes:
        make_recogniser: A recogniser that has not heard anybody; called once for each speaker.
        config: Of the listener.
        is_complete: As the listener takes it.
        make_clean: What cleans the sound before anything hears it; called once for each speaker.
        intent: What the dialogue makes of a text: "stop" halts the robot for good.
        confidence_ask: The dialogue asks back below this confidence.
        confidence_ignore: It does not even ask below this one.
    """

    make_recogniser: Callable[[], Recogniser]
    config: SpeechConfig = SpeechConfig()
    is_complete: Callable[[str], bool | None] = lambda _: None
    make_clean: Callable[[], Callable[[Frame], Frame]] = lambda: lambda frame: frame
    intent: Callable[[str], str] = lambda text: "stop" if text.split()[:1] == ["stop"] else ""
    confidence_ask: float = 0.3
    confidence_ignore: float = 0.15


@dataclass(frozen=True, slots=True)
class Heard:
    """What came of one sample.

    Attributes:
        sample: What was said.
        text: What was heard, of all its utterances.
        utterances: How many it was taken for; more than one is a sentence that was cut off.
        accepted: The dialogue would act on it: taken as of the domain, and surely enough.
        asked: It would not act but ask back.
        halts: The dialogue would halt the robot for good.
        delay: From the end of the speech to the utterance, without computing [s]; None when nothing was heard.
        stop_delay: From the end of the speech to the spotted stop [s], negative when before; None without one.
        paused: How long a spotted stop would have paused the robot until the text came [s]; 0 without one.
    """

    sample: Sample
    text: str
    utterances: int
    accepted: bool
    asked: bool
    halts: bool
    delay: float | None
    stop_delay: float | None
    paused: float

    @property
    def reference(self) -> str:
        """What was said, as recognisers write it."""
        return plain(self.sample.text)


@dataclass(frozen=True, slots=True)
class Condition:
    """Everything that was heard under one noise.

    Attributes:
        snr: Signal-to-noise ratio [dB]; None is clean.
        noise: What sounds besides the speech.
        heard: One for each sample.
        seconds: Length of the sound.
        processor_seconds: What listening to it took.
        finish_seconds: Processor time of each utterance's end, by which the transcript is late. What is done in the
            shortest pause before the end does not count.
    """

    snr: float | None
    heard: tuple[Heard, ...]
    seconds: float
    processor_seconds: float
    finish_seconds: tuple[float, ...]
    noise: Noise = "pink"

    @property
    def name(self) -> str:
        """For the report."""
        return "clean" if self.snr is None else f"{self.noise} noise, {self.snr:g} dB"


@dataclass(frozen=True, slots=True)
class SpeechEvaluation:
    """What came out."""

    recogniser: str
    samples: SampleSet
    conditions: tuple[Condition, ...]


def evaluate_speech(
    samples: SampleSet,
    ears: Ears,
    snrs: Sequence[float | None] = (None,),
    noise: Noise = "pink",
    progress: Callable[[int], None] = lambda _: None,
) -> SpeechEvaluation:
    """Let the samples be heard, speaker by speaker, each speaker's in one stream with pauses.

    Args:
        samples: What is said.
        ears: Who hears it.
        snrs: Signal-to-noise ratios of the added noise [dB]; None adds none.
        noise: What is added.
        progress: Called with the number of samples that were just heard.

    Raises:
        AudioError: A recording cannot be used.
    """
    name = ears.make_recogniser().name
    conditions = []
    for snr in snrs:
        streams = []
        for _, group in groupby(samples.samples, key=lambda sample: sample.speaker):
            of_speaker = tuple(group)
            streams.append(_hear(of_speaker, ears, snr, noise))
            progress(len(of_speaker))
        conditions.append(
            Condition(
                snr,
                tuple(heard for stream in streams for heard in stream.heard),
                sum(stream.seconds for stream in streams),
                sum(stream.processor_seconds for stream in streams),
                tuple(seconds for stream in streams for seconds in stream.finish_seconds),
                noise,
            )
        )
    return SpeechEvaluation(name, samples, tuple(conditions))


class _Timed:
    """A recogniser that notes how much work the end of each utterance is."""

    def __init__(self, recogniser: Recogniser, head_start: float) -> None:
        self._recogniser = recogniser
        self._head_start = head_start
        self.name = recogniser.name
        self.start, self.partial = recogniser.start, recogniser.partial
        self.finish_seconds: list[float] = []
        self._pause_seconds = 0.0

    def accept(self, samples: Samples) -> None:
        self._pause_seconds = 0.0
        self._recogniser.accept(samples)

    def at_pause(self) -> str:
        began = time.process_time()
        text = self._recogniser.at_pause()
        self._pause_seconds = time.process_time() - began
        return text

    def finish(self) -> Recognition:
        began = time.process_time()
        recognition = self._recogniser.finish()
        self.finish_seconds.append(time.process_time() - began + max(0.0, self._pause_seconds - self._head_start))
        return recognition


def _hear(samples: Sequence[Sample], ears: Ears, snr: float | None, kind: Noise) -> Condition:
    sound, spans = _stream(samples, snr, kind)
    clock, bus = VirtualClock(), Bus()
    utterances: list[Utterance] = []
    stops: list[StopSignal] = []
    bus.on(UTTERANCE, utterances.append)
    bus.on(SPEECH_STOP, stops.append)
    # An utterance ends this long after its pause was noticed, or later.
    recogniser = _Timed(ears.make_recogniser(), ears.config.end_silence_complete - TRAILING)
    listener = Listener(
        bus, clock, ArraySource(sound), (), ears.config,
        is_complete=ears.is_complete, is_stop=lambda text: bool(text) and ears.intent(text) == "stop",
        clean=ears.make_clean(), recogniser=recogniser,
    )  # fmt: skip
    began = time.process_time()
    run(listener.run, clock)
    processor_seconds = time.process_time() - began
    heard = []
    for sample, (start, end) in zip(samples, spans, strict=True):
        low, high = start - PAUSE / 2, end + PAUSE / 2
        heard.append(
            _judge(
                sample,
                end,
                [utterance for utterance in utterances if low <= utterance.start < high],
                [stop for stop in stops if low <= stop.time < high],
                ears,
            )
        )
    return Condition(snr, tuple(heard), len(sound) / SAMPLE_RATE, processor_seconds, tuple(recogniser.finish_seconds))


def _stream(samples: Iterable[Sample], snr: float | None, kind: Noise) -> tuple[Samples, list[tuple[float, float]]]:
    """The sound, and where in it each sample begins and ends [s]."""
    parts: list[Samples] = [np.zeros(SAMPLE_RATE, np.float32)]
    spans = []
    length = SAMPLE_RATE
    for sample in samples:
        speech = sample.sound()
        spans.append((length / SAMPLE_RATE, (length + len(speech)) / SAMPLE_RATE))
        parts += [speech, np.zeros(int(PAUSE * SAMPLE_RATE), np.float32)]
        length += len(speech) + len(parts[-1])
    sound = np.concatenate(parts)
    rng = np.random.default_rng(0)
    if snr is None:
        sound = sound + noise(len(sound), _QUIET_ROOM, rng)
    else:
        sound = sound + background(kind, len(sound), rng) * _sounding(sound) * 10 ** (-snr / 20)
    return sound.astype(np.float32), spans


def _sounding(samples: Samples) -> float:
    """Root mean square of the parts that sound."""
    loud = samples[np.abs(samples) > _AUDIBLE * np.abs(samples).max(initial=1e-9)]
    return float(np.sqrt(np.mean(loud**2))) if len(loud) else 0.0


def _judge(sample: Sample, end: float, utterances: list[Utterance], stops: list[StopSignal], ears: Ears) -> Heard:
    text = " ".join(utterance.text for utterance in utterances)
    sure = [u for u in utterances if u.in_domain and u.confidence >= ears.confidence_ask]
    decided = utterances[-1].time if utterances else None
    spotted = next((stop.time for stop in stops if stop.state == "spotted"), None)
    taken_back = next((stop.time for stop in stops if stop.state == "withdrawn"), decided)
    # Without a text the dialogue takes a stop back after its own deadline.
    paused = 0.0 if spotted is None else max(0.0, taken_back - spotted) if taken_back is not None else 3.0
    return Heard(
        sample=sample,
        text=text,
        utterances=len(utterances),
        accepted=bool(sure),
        asked=not sure and any(u.in_domain and u.confidence >= ears.confidence_ignore for u in utterances),
        halts=any(ears.intent(utterance.text) == "stop" for utterance in sure),
        delay=None if decided is None else decided - (end if sample.voice else utterances[-1].end),
        stop_delay=spotted - end if spotted is not None else None,
        paused=paused,
    )
