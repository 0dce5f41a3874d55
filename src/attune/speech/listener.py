"""Hearing: sound in; speech activity, stop signals and utterances out. It listens also while the robot speaks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import anyio
import numpy as np
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

from attune.core.bus import EVENT, SPEECH_ACTIVITY, SPEECH_STOP, UTTERANCE, Bus
from attune.core.clock import Clock
from attune.core.config import SpeechConfig
from attune.core.events import Event
from attune.core.log import get_logger
from attune.core.messages import AgeEstimate, Band, SpeechActivity, StopSignal, Utterance
from attune.speech.age.estimator import AgeEstimator
from attune.speech.age.tracker import AgeTracker
from attune.speech.audio import AudioSource, Frame
from attune.speech.choice import choose_recogniser
from attune.speech.endpointing import Endpointer, SpeechBegan, SpeechEnded, SpeechPauses
from attune.speech.levels import LevelMonitor, Problem, advice
from attune.speech.recogniser import Recogniser, Recognition
from attune.speech.stop_judge import StopJudge
from attune.speech.stop_review import Evidence, StopReview, overruled
from attune.speech.stop_spotter import StopSpotter
from attune.speech.stop_words import reads_as_stop

_Change = tuple[SpeechBegan | SpeechEnded, ...]
_HOPELESS = 0.02
"""Confidence under which what was recognised is no utterance at all."""


@dataclass(frozen=True, slots=True)
class _Over:
    """An utterance is over; the spotter takes it for an order to stop with this probability."""

    ended: SpeechEnded
    order: float


_Heard = Frame | SpeechBegan | SpeechPauses | _Over


@dataclass(frozen=True, slots=True)
class _Ears:
    """What works on the sound, made in a thread because it takes a moment."""

    endpointer: Endpointer
    spotter: StopSpotter
    recogniser: Recogniser
    judge: StopJudge


class Listener:
    """Listens to a source and publishes what is said.

    Two tasks share the work: one finds speech and stop words in every frame, without ever waiting for the other,
    which recognises the utterances one after the other.

    Args:
        source: Where the sound comes from.
        sentences: What people may say; the recogniser learns its words and phrasings from them.
        age: Estimates the speaker's age; None does not.
        is_complete: Whether a partial text is a whole sentence (True), a fragment (False), or unknown (None): it
            sets how long a pause ends the utterance.
        is_stop: Whether a partial text reads as an order to stop: a spotted stop is taken back early if not.
        band: The age band of who speaks, which sets how much time they get; None takes it from their voice.
        clean: Removes the robot's own voice (or noise) from each frame before anything hears it.
        recogniser: Used instead of the configured one.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        source: AudioSource,
        sentences: Sequence[str],
        config: SpeechConfig,
        *,
        age: AgeEstimator | None = None,
        is_complete: Callable[[str], bool | None] = lambda _: None,
        is_stop: Callable[[str], bool] = reads_as_stop,
        band: Callable[[], Band] | None = None,
        clean: Callable[[Frame], Frame] = lambda frame: frame,
        recogniser: Recogniser | None = None,
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._source = source
        self._sentences = sentences
        self._config = config
        self._age = age
        self._is_complete = is_complete
        self._clean = clean
        self._recogniser = recogniser
        self._is_stop = is_stop
        self._review = StopReview(is_stop)
        self._partial = ""
        self._spotted_by_text = False
        self.speaker_age = AgeTracker(config.older_from)
        """The mean of the last interactions."""
        self._band = band or (lambda: self.speaker_age.current.band)

    async def run(self) -> None:
        """Listen until cancelled, or until the source ends and its last utterance is out.

        Raises:
            AttuneError: The source or the recogniser cannot be used.
        """
        ears = await self._clock.run_in_thread(self._make_ears)
        send, receive = anyio.create_memory_object_stream[_Heard](max_buffer_size=np.inf)
        async with anyio.create_task_group() as group:
            group.start_soon(self._recognise, ears, receive)
            await self._watch(ears, send)

    def _make_ears(self) -> _Ears:
        recogniser = self._recogniser
        if recogniser is None:
            chosen = choose_recogniser(self._config, self._sentences)
            get_logger("speech").info("recogniser", name=chosen.recogniser.name, reason=chosen.reason)
            recogniser = chosen.recogniser
        return _Ears(Endpointer(self._config), StopSpotter(), recogniser, StopJudge())

    async def _watch(self, ears: _Ears, send: MemoryObjectSendStream[_Heard]) -> None:
        was_speaking = False
        levels = LevelMonitor()
        pause: list[Frame] = []
        with send:
            async for raw in self._source.frames(self._clock):
                hint = self._is_complete(self._partial) if self._partial else None
                frame, band = self._clean(raw), self._band()

                def hear(frame: Frame = frame, hint: bool | None = hint, band: Band = band) -> tuple[_Change, str]:
                    changes = ears.endpointer.accept(frame, hint, band)
                    voiced = ears.endpointer.heard_voice
                    word = ears.spotter.accept(frame.samples, frame.end, voiced=voiced)
                    if word or self._spotted_by_text:
                        self._spotted_by_text = False
                        changes += ears.endpointer.stop_spotted()
                    return changes, word

                changes, stop_word = await self._clock.run_in_thread(hear)
                if stop_word:
                    self._tell_stop(stop_word, frame.end)
                speaking, order = ears.endpointer.speaking, ears.spotter.latest_order
                if self._review.takes_back(self._partial, frame.end, speaking=speaking, order=order):
                    self._take_back()
                for problem in levels.accept(raw, speaking=ears.endpointer.speaking):
                    self._warn(problem)
                if ears.endpointer.speaking != was_speaking:
                    was_speaking = ears.endpointer.speaking
                    self._bus.publish(SPEECH_ACTIVITY, SpeechActivity(time=self._clock.now(), speaking=was_speaking))
                for change in changes:
                    send.send_nowait(self._with_order(ears, change))
                for heard in _for_recogniser(ears.endpointer, frame, pause, began_or_ended=bool(changes)):
                    send.send_nowait(heard)
            if (ended := ears.endpointer.finish()) is not None:
                send.send_nowait(self._with_order(ears, ended))
        if was_speaking:
            self._bus.publish(SPEECH_ACTIVITY, SpeechActivity(time=self._clock.now(), speaking=False))

    def _with_order(self, ears: _Ears, change: SpeechBegan | SpeechEnded) -> SpeechBegan | _Over:
        return (
            _Over(change, ears.spotter.order(change.end, change.start)) if isinstance(change, SpeechEnded) else change
        )

    async def _recognise(self, ears: _Ears, receive: MemoryObjectReceiveStream[_Heard]) -> None:
        utterance: list[Frame] = []
        recogniser = ears.recogniser

        def accept(frames: Sequence[Frame]) -> str:
            recogniser.accept(np.concatenate([frame.samples for frame in frames]))
            return recogniser.partial()

        with receive:
            async for heard in receive:
                if isinstance(heard, _Over):
                    await self._finish(ears, heard, utterance)
                    utterance = []
                    continue
                if isinstance(heard, SpeechPauses):
                    self._partial, time = await self._clock.run_in_thread(recogniser.at_pause), heard.time
                else:
                    if isinstance(heard, SpeechBegan):
                        recogniser.start()
                    frames = heard.frames if isinstance(heard, SpeechBegan) else (heard,)
                    utterance.extend(frames)
                    self._partial = await self._clock.run_in_thread(lambda frames=frames: accept(frames))  # type: ignore[misc]
                    time = frames[-1].end
                if stop_word := ears.spotter.accept_partial(self._partial, time):
                    self._spotted_by_text = True
                    self._tell_stop(stop_word, time)

    async def _finish(self, ears: _Ears, over: _Over, frames: Sequence[Frame]) -> None:
        ended = over.ended
        if ended.is_noise:
            self._forget_partial(ears)
            self._decide_spotted(ended)
            return
        samples = np.concatenate([frame.samples for frame in frames])

        def finish() -> tuple[Recognition, AgeEstimate]:
            recognition = ears.recogniser.finish()
            return recognition, self._age.estimate(samples, recognition) if self._age else AgeEstimate()

        heard, estimate = await self._clock.run_in_thread(finish)
        self._forget_partial(ears)
        evidence = Evidence(
            spotted=self._review.spotted_in(ended.start, ended.end),
            order=over.order,
            seconds=ended.end - ended.start,
            lead=lambda: ears.judge.lead(samples, heard.text),
        )
        recognition = await self._clock.run_in_thread(lambda: overruled(heard, evidence, self._is_stop))
        if not recognition.text or recognition.confidence < _HOPELESS:
            self._decide_spotted(ended)
            return
        self._review.decided(ended.end)
        now = self._clock.now()
        utterance = Utterance(
            time=now,
            text=recognition.text,
            alternatives=recognition.alternatives,
            confidence=recognition.confidence,
            in_domain=recognition.in_domain,
            age=self.speaker_age.update(estimate),
            start=ended.start,
            end=ended.end,
        )
        self._bus.publish(UTTERANCE, utterance)
        self._bus.publish(
            EVENT,
            Event(time=now, cause=utterance.id, kind="heard", text="Heard an utterance", data={"text": utterance.text}),
        )

    def _tell_stop(self, word: str, heard_at: float) -> None:
        now = self._clock.now()
        self._review.spotted(heard_at)
        self._bus.publish(SPEECH_STOP, StopSignal(time=now, state="spotted", source="spotter", word=word))
        self._bus.publish(EVENT, Event(time=now, kind="stop_spotted", text=f'Heard "{word}"'))

    def _forget_partial(self, ears: _Ears) -> None:
        self._partial = ""
        ears.spotter.end_utterance()

    def _decide_spotted(self, ended: SpeechEnded) -> None:
        """There is no text that could confirm a spotted stop."""
        if self._review.decided(ended.end):
            self._take_back()

    def _take_back(self) -> None:
        self._bus.publish(SPEECH_STOP, StopSignal(time=self._clock.now(), state="withdrawn", source="spotter"))

    def _warn(self, problem: Problem) -> None:
        data = {"microphone": problem}
        self._bus.publish(EVENT, Event(time=self._clock.now(), kind="warning", text=advice(problem), data=data))


def _for_recogniser(
    endpointer: Endpointer, frame: Frame, pause: list[Frame], *, began_or_ended: bool
) -> tuple[Frame | SpeechPauses, ...]:
    """What the recogniser hears of a frame; `pause` holds what it has not heard of the pause that is going on.

    The background of a pause is not to be taken for words, unless somebody speaks on after it.
    """
    if began_or_ended:
        pause.clear()
        return ()
    if endpointer.pausing:
        begins = not pause and not endpointer.noise_so_far
        pause.append(frame)
        return (SpeechPauses(frame.end),) if begins else ()
    kept = (*pause, frame) if endpointer.active else ()
    pause.clear()
    return kept
