"""What becomes of a spotted stop, before and with the recogniser's final text."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from attune.speech.recogniser import Recognition
from attune.speech.stop_words import is_negated, stops_in

_WORD = "stop"
_DOUBT = 0.8
"""Whoever speaks on for this long [s] without the text reading as a stop did not mean one."""
_LONGEST = 2.2
"""An order to stop is no longer than this [s], and so slow only from slow speakers."""
_LONGEST_DOUBT = 1.4
"""No text can be expected to make it a stop after this long [s]; the final one still may."""
_LONGEST_PAUSE = 1.45
"""No pause that may be wrongful is longer than this [s], even if the final text is still to come."""
_LONGEST_ORDER = 1.4
"""An order to stop does not go on for longer than this after the word [s]: whoever still speaks then talks of something
else, even if it is mistaken for an order so far."""
_NO_ORDER = 0.05
"""Probability of an order under which it was none, whatever else was heard."""
_MAYBE, _LIKELY, _SURE = 0.5, 0.8, 0.97
"""Probabilities of an order: from which on it may be one, if it is short or its text is one, too; that count where the
text is doubtful or missing; and that count against a sure text. Chosen, as the two below, on voices of development,
clean and in noise at 10 to 20 dB: 180 orders had 0.89 and more, other sentences in which a stop was spotted 0.79 and
less; but voices that are hard to understand have less."""
_SHORT = 1.1
"""Most orders to stop are no longer than this [s]."""
_LONG, _LIKELY_IF_LONG = 1.6, 0.94
"""Longer than this [s] are few, so a doubtful text needs this probability. Of 14 such orders of voices of development,
clean and in noise at 15 dB, 13 had 0.95 and more; what others were told ("stop hitting your brother") 0.8 to 0.92.
Where the text says something else, all that is not short needs it: among people who talk, 2 of 15 sentences with "stop"
or "top" in them ("lisa stop it now") had it, and both such orders."""
_COMES_NEAR = -0.8
"""Evidence of the rest of the sound (`StopJudge.lead`) from which it may have been an order to stop."""
_SETTLED = 0.15
"""In the pause after somebody has spoken, the probability can be told from this time on [s]."""
_SHORT_NEGATION = 2
"""Words of a text that may be "no stop" misheard; who says more than "don't stop" is understood."""
_DOUBTFUL_TEXT = 0.5
"""Confidence under which a text is doubtful."""
_BELIEVED = 0.5
"""Confidence of a stop that both have heard."""
_EARLY, _LATE = 0.5, 0.5
"""A stop may be spotted so long [s] before its utterance is said to have begun, and after it is said to have ended."""
_REMEMBERED = 8
"""So many spotted stops."""


class StopReview:
    """Takes a spotted stop back before the end of the sentence, once what is understood so far contradicts it.

    Nothing is lost by that: if the final text turns out to be a stop, it halts the robot all the same.

    Args:
        is_stop: Whether a text so far reads as an order to stop.
    """

    def __init__(self, is_stop: Callable[[str], bool]) -> None:
        self._is_stop = is_stop
        self._waiting: list[float] = []
        self._times: deque[float] = deque(maxlen=_REMEMBERED)
        self._doubtful: float | None = None
        self._quiet: float | None = None

    def spotted(self, time: float) -> None:
        """A stop was spotted."""
        if not self._waiting:
            self._doubtful = None
        self._waiting.append(time)
        self._times.append(time)

    def spotted_in(self, start: float, end: float) -> bool:
        """Whether a stop was spotted in an utterance from start to end [s], also if it was taken back meanwhile."""
        return any(start - _EARLY <= time < end + _LATE for time in self._times)

    def decided(self, end: float) -> bool:
        """The text of an utterance that ended then [s] is final, or there is none.

        Returns:
            Whether a spotted stop waited for it. One that was spotted later waits for the next.
        """
        was_waiting = self._waiting
        self._waiting = [time for time in was_waiting if time >= end + _LATE]
        return len(self._waiting) < len(was_waiting)

    def takes_back(self, partial: str, time: float, *, speaking: bool, order: float) -> bool:
        """Whether the spotted stop is to be taken back now.

        Args:
            partial: What was understood so far of the utterance that is going on; "" without one.
            time: Now [s].
            speaking: Somebody speaks at this moment.
            order: Probability that what was said until now is an order to stop.
        """
        self._quiet = None if speaking else time if self._quiet is None else self._quiet
        if not self._waiting:
            return False
        since = time - self._waiting[0]
        if self._is_stop(partial):
            self._doubtful = None
            takes_back = since >= (_LONGEST_ORDER if speaking else _LONGEST_PAUSE)
        else:
            self._doubtful = time if self._doubtful is None else self._doubtful
            takes_back = since >= _LONGEST_DOUBT or (speaking and order < _LIKELY and time - self._doubtful >= _DOUBT)
        has_ended = self._quiet is not None and time - max(self._quiet, self._waiting[0]) >= _SETTLED
        if takes_back or (has_ended and order < _NO_ORDER):
            self._waiting.clear()
            return True
        return False


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known about an utterance besides its text.

    Attributes:
        spotted: A stop was spotted in it.
        order: Probability that it is an order to stop, by its sound alone; see `StopSpotter.order`.
        seconds: Length of the speech.
        lead: How much better an order to stop explains the sound than the text does; see `StopJudge.lead`. Takes long.
    """

    spotted: bool
    order: float
    seconds: float
    lead: Callable[[], float]


def overruled(heard: Recognition, evidence: Evidence, is_stop: Callable[[str], bool]) -> Recognition:
    """What was said, given that it may have been an order to stop. When in doubt it was one.

    A wrongful halt costs a "carry on", a missed one may cost more. So a short utterance that sounds like an order to
    stop is one, unless its text is something else beyond doubt.

    Args:
        heard: By the recogniser.
        evidence: What else is known about the utterance.
        is_stop: Whether a text reads as an order to stop.
    """
    if evidence.seconds > _LONGEST or not _is_order(heard, evidence, is_stop):
        return replace(heard, in_domain=False) if is_stop(heard.text) and _is_denied(heard, evidence) else heard
    text = next((text for text in (heard.text, *heard.alternatives) if is_stop(text)), _WORD)
    others = tuple(other for other in dict.fromkeys((heard.text, *heard.alternatives)) if other not in {"", text})
    return replace(heard, text=text, alternatives=others, confidence=max(heard.confidence, _BELIEVED), in_domain=True)


def _is_order(heard: Recognition, evidence: Evidence, is_stop: Callable[[str], bool]) -> bool:
    if is_negated(heard.text):
        return evidence.spotted and len(heard.text.split()) <= _SHORT_NEGATION and evidence.order >= _SURE
    if not _is_doubtful(heard) and not is_stop(heard.text):
        return evidence.spotted and evidence.order >= _SURE
    if evidence.order < _least_if_long(evidence.seconds, says_else=bool(heard.text) and not is_stop(heard.text)):
        return False
    if evidence.spotted and evidence.order >= _LIKELY:
        return True
    if evidence.order < (_MAYBE if evidence.seconds <= _SHORT or is_stop(heard.text) else _LIKELY):
        return False
    # Any short sound may be an order if there is no text to compare it with.
    return evidence.lead() >= _COMES_NEAR if heard.text else evidence.spotted


def _least_if_long(seconds: float, *, says_else: bool) -> float:
    """Probability that an order of this length needs if its text is doubtful."""
    if seconds > _LONG:
        return _SURE if says_else else _LIKELY_IF_LONG
    return _LIKELY_IF_LONG if seconds > _SHORT and says_else else 0.0


def _is_denied(heard: Recognition, evidence: Evidence) -> bool:
    """Whether a text that reads as an order to stop is none."""
    # The network knows only the words of the spotter: "never mind" is left to the text.
    is_known = bool(stops_in(heard.text))
    # Long talk that is hard to understand often seems to have an order in it.
    if evidence.seconds > (_LONG if is_known else _LONGEST) and _is_doubtful(heard):
        return evidence.order < (_LIKELY_IF_LONG if evidence.seconds <= _LONGEST else _SURE)
    return is_known and evidence.seconds <= _LONGEST and not evidence.spotted and evidence.order < _NO_ORDER


def _is_doubtful(heard: Recognition) -> bool:
    return not heard.text or not heard.in_domain or heard.confidence < _DOUBTFUL_TEXT
