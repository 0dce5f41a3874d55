"""What becomes of a spotted stop, before and with the recogniser's final text."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from attune.speech.recogniser import Recognition
from attune.speech.stop_words import is_negated, stops_in

_WORD = "stop"
_DOUBT = 0.5
"""Whoever speaks on for this long [s] without the text reading as a stop did not mean one."""
_SHORT = 1.6
"""An order to stop is no longer than this [s], and so slow only from slow speakers."""
_SHOUT = 1.1
"""Where there is less to go by (no text, or nothing spotted), an order to stop is as short as a shout [s]."""
_COMES_NEAR, _COMES_NEAR_ENOUGH = -0.6, -1.2
"""Evidence of the sound (`StopJudge.lead`) from which an utterance in which a stop was spotted is an order to stop: as
usual, and if it was spotted surely. Chosen, as those below, on voices of development: other short sentences rarely have
more than -0.6, orders to stop less than -0.5."""
_LEADS = -0.2
"""The same if none was spotted and the text is doubtful."""
_NO_NEGATION = -0.3
"""The same if the text is "don't stop"."""
_SHORT_NEGATION = 2
"""Words of a text that may be "no stop" misheard; who says more than "don't stop" is understood."""
_SURE_TEXT = 0.5
"""Confidence from which a text without a stop is believed if none was spotted either."""
_BELIEVED = 0.5
"""Confidence of a stop that both have heard."""
_LONGEST_DOUBT = 1.4
"""No text can be expected to make it a stop after this long [s]; the final one still may."""
_LONGEST_ORDER = 1.4
"""An order to stop does not go on for longer than this after the word [s]: whoever still speaks then talks of something
else, even if it is mistaken for an order so far."""


_EARLY = 0.5
"""A stop may be spotted so long [s] before its utterance is said to have begun."""


class StopReview:
    """Takes a spotted stop back before the end of the sentence, once what is understood so far contradicts it.

    Nothing is lost by that: if the final text turns out to be a stop, it halts the robot all the same.

    Args:
        is_stop: Whether a text so far reads as an order to stop.
    """

    def __init__(self, is_stop: Callable[[str], bool]) -> None:
        self._is_stop = is_stop
        self._spotted: float | None = None
        self._doubtful: float | None = None
        self._last = -math.inf

    def spotted(self, time: float) -> None:
        """A stop was spotted."""
        self._last = time
        if self._spotted is None:
            self._spotted, self._doubtful = time, None

    @property
    def open(self) -> bool:
        """Whether a spotted stop waits for the text."""
        return self._spotted is not None

    def decided(self, start: float) -> bool:
        """The text is final, or there is none.

        Args:
            start: When the utterance began [s].

        Returns:
            Whether a stop was spotted in it, also if it was taken back meanwhile.
        """
        self._spotted = None
        return self._last >= start - _EARLY

    def takes_back(self, partial: str, time: float, *, speaking: bool, sure: bool) -> bool:
        """Whether the spotted stop is to be taken back now.

        Args:
            partial: What was understood so far of the utterance that is going on; "" without one.
            time: Now [s].
            speaking: Somebody speaks at this moment.
            sure: The stop was spotted so surely, or in such noise, that a text so far does not count against it.
        """
        if self._spotted is None:
            return False
        since = time - self._spotted
        if self._is_stop(partial):
            self._doubtful = None
            takes_back = speaking and since >= _LONGEST_ORDER
        else:
            self._doubtful = time if self._doubtful is None else self._doubtful
            takes_back = since >= _LONGEST_DOUBT or (speaking and not sure and time - self._doubtful >= _DOUBT)
        if takes_back:
            self._spotted = None
            return True
        return False


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known about an utterance besides its text.

    Attributes:
        spotted: A stop was spotted in it.
        sure: So surely that it counts for more than the text.
        seconds: Length of the speech.
        lead: How much better an order to stop explains the sound than the text does; see `StopJudge.lead`.
    """

    spotted: bool
    sure: bool
    seconds: float
    lead: Callable[[], float]


def overruled(heard: Recognition, evidence: Evidence, is_stop: Callable[[str], bool]) -> Recognition:
    """What was said, given that it may have been an order to stop. When in doubt it was one.

    A wrongful halt costs a "carry on", a missed one may cost more. So a short utterance in which a stop was spotted is
    one, unless its text holds none and the sound speaks against it, too. Where nothing was spotted, or the text is
    negated, the sound must say so clearly.

    Args:
        heard: By the recogniser.
        evidence: What else is known about the utterance.
        is_stop: Whether a text reads as an order to stop.
    """
    if evidence.seconds > _SHORT or not _is_order(heard, evidence, is_stop):
        return heard
    text = next((text for text in (heard.text, *heard.alternatives) if is_stop(text)), _WORD)
    others = tuple(other for other in dict.fromkeys((heard.text, *heard.alternatives)) if other not in {"", text})
    return replace(heard, text=text, alternatives=others, confidence=max(heard.confidence, _BELIEVED), in_domain=True)


def _is_order(heard: Recognition, evidence: Evidence, is_stop: Callable[[str], bool]) -> bool:
    if is_negated(heard.text):
        return len(heard.text.split()) <= _SHORT_NEGATION and evidence.lead() >= _NO_NEGATION
    if is_stop(heard.text):
        return evidence.spotted
    if evidence.spotted and stops_in(heard.text):
        return True
    if not heard.text:
        # Any short sound may be an order if there is nothing to compare it with.
        return evidence.spotted and evidence.seconds <= _SHOUT
    if evidence.spotted:
        return evidence.lead() >= (_COMES_NEAR_ENOUGH if evidence.sure else _COMES_NEAR)
    return evidence.seconds <= _SHOUT and heard.confidence < _SURE_TEXT and evidence.lead() >= _LEADS
