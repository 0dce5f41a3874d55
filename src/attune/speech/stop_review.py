"""What becomes of a spotted stop, before and with the recogniser's final text."""

from collections.abc import Callable
from dataclasses import replace

from attune.speech.recogniser import Recognition
from attune.speech.stop_words import is_negated

_WORD = "stop"
_DOUBT = 0.5
"""Whoever speaks on for this long [s] without the text reading as a stop did not mean one."""
_SHORT = 1.2
"""A shout is no longer than this [s]: in it a spotted stop is evidence about its words."""
_BELIEVED = 0.5
"""Confidence of a stop that both have heard."""
_LONGEST_DOUBT = 1.4
"""No text can be expected to make it a stop after this long [s]; the final one still may."""
_LONGEST_ORDER = 1.3
"""An order to stop does not go on for longer than this after the word [s]: whoever still speaks then talks of something
else, even if it is mistaken for an order so far."""


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

    def spotted(self, time: float) -> None:
        """A stop was spotted."""
        if self._spotted is None:
            self._spotted, self._doubtful = time, None

    def decided(self) -> bool:
        """The text is final, or there is none. Returns whether a spotted stop was waiting for it."""
        was_open, self._spotted = self._spotted is not None, None
        return was_open

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


def overruled(heard: Recognition, seconds: float, is_stop: Callable[[str], bool]) -> Recognition:
    """What was said, given that a search that knows only this word has found a stop in it and may be believed.

    It is believed about a short shout, also where the recogniser has doubts or hears another word; but whoever is heard
    to say "don't stop" is believed, too.

    Args:
        heard: By the recogniser.
        seconds: Length of the speech.
        is_stop: Whether a text reads as an order to stop.
    """
    if seconds > _SHORT or is_negated(heard.text):
        return heard
    text = next((text for text in (heard.text, *heard.alternatives) if is_stop(text)), _WORD)
    others = tuple(other for other in dict.fromkeys((heard.text, *heard.alternatives)) if other not in {"", text})
    return replace(heard, text=text, alternatives=others, confidence=max(heard.confidence, _BELIEVED), in_domain=True)
