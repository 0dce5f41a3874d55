"""What becomes of a spotted stop, before and with the recogniser's final text."""

from collections.abc import Callable
from dataclasses import replace

from attune.speech.recogniser import Recognition
from attune.speech.stop_words import mentions_stop

_WORD = "stop"
_DOUBT = 0.5
"""Whoever speaks on for this long [s] without the text reading as a stop did not mean one."""
_SHORT = 1.3
"""A shout is no longer than this [s]: in it a spotted stop is evidence about its words."""
_BELIEVED = 0.5
"""Confidence of a stop that both have heard."""
_LONGEST_DOUBT = 1.2
"""No text can be expected to make it a stop after this long [s]; the final one still may."""


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
        self._spotted, self._doubtful = time, None

    def decided(self) -> bool:
        """The text is final, or there is none. Returns whether a spotted stop was waiting for it."""
        was_open, self._spotted = self._spotted is not None, None
        return was_open

    def takes_back(self, partial: str, time: float, *, speaking: bool) -> bool:
        """Whether the spotted stop is to be taken back now.

        Args:
            partial: What was understood so far of the utterance that is going on; "" without one.
            time: Now [s].
            speaking: Somebody speaks at this moment.
        """
        if self._spotted is None:
            return False
        if self._is_stop(partial):
            self._doubtful = None
            return False
        if self._doubtful is None:
            self._doubtful = time
        went_on = speaking and time - self._doubtful >= _DOUBT
        if went_on or time - self._spotted >= _LONGEST_DOUBT:
            self._spotted = None
            return True
        return False


def with_spotted(heard: Recognition, seconds: float, is_stop: Callable[[str], bool], *, in_noise: bool) -> Recognition:
    """What was said, given that a stop was spotted in it and still stands.

    Two who hear the same word in a short shout are believed: also where one of them has doubts, and in noise, which
    garbles single words for the recogniser, also where it hears another word. Whoever says "don't stop" is believed.

    Args:
        heard: By the recogniser.
        seconds: Length of the speech.
        is_stop: Whether a text reads as an order to stop.
        in_noise: Whether the stop was spotted in noise.
    """
    if seconds > _SHORT:
        return heard
    text = next((text for text in (heard.text, *heard.alternatives) if is_stop(text)), "")
    if mentions_stop(heard.text) and text != heard.text:
        return heard
    if not text and in_noise:
        text = _WORD
    if not text:
        return heard
    others = tuple(other for other in dict.fromkeys((heard.text, *heard.alternatives)) if other not in {"", text})
    return replace(heard, text=text, alternatives=others, confidence=max(heard.confidence, _BELIEVED), in_domain=True)
