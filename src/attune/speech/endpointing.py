"""Where speech begins and ends in the stream: Silero voice activity with hysteresis, pre-roll and an adaptive end."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from attune.core.config import SpeechConfig
from attune.core.messages import Band
from attune.speech.audio import FRAME_SECONDS, Frame
from attune.speech.loudness import SILENCE, Background
from attune.speech.loudness import level as level_of
from attune.speech.voice_activity import VoiceActivity

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
_WORD_FRAMES = 25
"""A spotted stop was said within so many frames (0.8 s)."""
_OVER_BACKGROUND = 6.0
"""Speech is louder than the background by this much [dB]: other people's talk in the distance is background."""
_UNDER_SPEECH = 18.0
"""What is softer than the utterance's loudest moment by more than this [dB] is not of the same person any more."""
_NEARER = 10.0
"""A voice that is louder than the utterance so far by this much [dB] is somebody else, nearer by: it begins its own."""
_OVER_OTHERS = 20.0
"""People who talk in the background are at most this much louder than the background's level [dB]; mostly 16."""
_REACHES_BACK = 4.0
"""So much of the sound [s] is looked through for the beginning of an order."""
_ORDER_GAP_FRAMES = 13
"""Within an order to stop nobody is so much softer for so long (0.4 s): of 70 orders in noise, for 0.38 s at most."""
_LEVEL_KNOWN_AFTER = 1.0
"""So much voice tells how loud a person speaks [s]."""
_CUT_OFF = 1.1
"""Who goes on within this time after an utterance [s] had not finished it."""
_HESITATES = 1.25
"""How much longer than the longest of a person's recent pauses we wait."""
_RECENT = 4
"""Utterances whose pauses are remembered."""


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


@dataclass(frozen=True, slots=True)
class _Heard:
    """A frame, its level [dB full scale], and whether a voice was in it."""

    frame: Frame
    level: float
    is_voice: bool


def _after_others(heard: Sequence[_Heard], nearer: float) -> int | None:
    """Index of what follows the last stretch in which only others spoke; None if there is none, or not only they did.

    Args:
        heard: Before a word.
        nearer: What is softer than this is others' [dB full scale].
    """
    softer = voices = 0
    for index in range(len(heard) - 1, -1, -1):
        each = heard[index]
        softer, voices = (softer + 1, voices + each.is_voice) if each.level < nearer else (0, 0)
        if softer == _ORDER_GAP_FRAMES:
            own = sum(each.is_voice and each.level >= nearer for each in heard[:index])
            is_talk = voices >= softer / 2 and own * FRAME_SECONDS < _SHORTEST_SPEECH
            return index + softer if is_talk else None
    return None


class Endpointer:
    """Finds utterances in a stream. Belongs to one thread at a time.

    An utterance ends after a pause: a short one when what was said so far is complete, a long one when it is a
    fragment ("bring me the ..."), the configured one when nobody knows. Older adults get more time, and so does
    everybody who paused for long within their last utterances, or went on right after one of them.
    """

    def __init__(self, config: SpeechConfig) -> None:
        self._config = config
        self._voice = VoiceActivity()
        self._pre_roll = round(config.pre_roll / FRAME_SECONDS)
        self._before: deque[Frame] = deque(maxlen=_BEGIN_FRAMES + self._pre_roll)
        self._recent: deque[_Heard] = deque(maxlen=round(_REACHES_BACK / FRAME_SECONDS))
        self._background = Background(FRAME_SECONDS)
        self._pauses: deque[float] = deque(maxlen=_RECENT)
        self._pause = 0.0
        self._voiced_in_a_row = 0
        self._nearer_in_a_row = 0
        self._voiced = 0.0
        self._loudest = SILENCE
        self._others = SILENCE
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
        self._recent.append(_Heard(frame, level, probability >= self._config.voice_off))
        if not self.active:
            return self._wait(frame, probability, level)
        if self._is_nearer(probability, level) and (ended := self.finish()):
            return (ended, self._begin(frame, level))
        if probability >= self._config.voice_off and level >= max(self._others, self._loudest - _UNDER_SPEECH):
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

    def stop_spotted(self) -> tuple[SpeechBegan | SpeechEnded, ...]:
        """The utterance is of whoever just said "stop": softer voices before and after it are others', where many talk.

        Without that the talk of others would hide that an order has ended, and lengthen it at its beginning.
        """
        if not self.active:
            return ()
        heard = [each for each in self._recent if each.frame.end > self._start]
        word = max(range(max(0, len(heard) - _WORD_FRAMES), len(heard)), key=lambda index: heard[index].level)
        nearer = heard[word].level - _NEARER
        self._others = max(self._others, min(nearer, self._background.level + _OVER_OTHERS))
        begin = _after_others(heard[:word], nearer)
        own = [each for each in heard[begin:] if each.is_voice and each.level >= self._others]
        if begin is None or not own:
            return ()
        others = SpeechEnded(self._start, heard[begin - _ORDER_GAP_FRAMES].frame.time, is_noise=True)
        self._start, self._end = heard[begin].frame.time, own[-1].frame.end
        self._voiced, self._pause, self._loudest = len(own) * FRAME_SECONDS, 0.0, heard[word].level
        return others, SpeechBegan(tuple(each.frame for each in heard[max(0, begin - self._pre_roll) :]), self._start)

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
        if self._others > self._loudest - _UNDER_SPEECH:
            # What was understood so far of an order tells little where it is loud.
            return config.end_silence_complete
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
        self._loudest, self._others = level, SILENCE
        frames = tuple(self._before)
        self._before.clear()
        return SpeechBegan(frames, self._start)
