"""Hears "stop" while the person is still speaking, from the raw stream and from partial results."""

import re
import tempfile
from collections.abc import Callable
from pathlib import Path

from attune.speech.audio import Samples
from attune.speech.pronunciation import dictionary_text
from attune.speech.sphinx import pcm16

_KEYWORDS = {"stop": ("S T AA P", 1e-10), "stop-british": ("S T AO P", 1e-10)}
"""Sounds and threshold of the keyword search. "Freeze" fires on "please" and "halt" on half of all speech, so only the
partial results tell those."""
_STOP = re.compile(r"(?<!\w)(stop|halt|freeze|wait|pause|hold (?:on|it)|don't move|stand still)(?!\w)")
_CERTAIN = {"stop", "halt"}
_STEADY = 3
"""Other stop words count once they stood in so many partial results in a row: they come and go in ordinary speech."""
_NEGATED = re.compile(r"(?<!\w)(?:don't|do not|not|never|without|can't|no need to)(?: \w+)? $")
_REFRACTORY = 1.0
"""Both ways of hearing tell the same word within this time [s]."""
_DOUBT = 0.5
"""Whoever speaks on for this long [s] without the text reading as a stop did not mean one."""
_LONGEST_DOUBT = 1.2
"""No text can be expected to make it a stop after this long [s]; the final one still may."""


class StopSpotter:
    """A keyword search that always runs, and the stop words of partial results. The first of the two counts.

    It errs towards stopping: a spotted stop only pauses the robot, and the whole utterance decides. Belongs to one
    thread at a time.
    """

    def __init__(self) -> None:
        import pocketsphinx

        models = Path(pocketsphinx.get_model_path()) / "en-us"
        with tempfile.TemporaryDirectory() as folder:
            dictionary, keywords = Path(folder) / "stop.dict", Path(folder) / "stop.keywords"
            dictionary.write_text(dictionary_text({word: (phones,) for word, (phones, _) in _KEYWORDS.items()}))
            keywords.write_text("".join(f"{word} /{threshold:g}/\n" for word, (_, threshold) in _KEYWORDS.items()))
            self._search = pocketsphinx.Decoder(
                hmm=str(models / "en-us"), dict=str(dictionary), kws=str(keywords), loglevel="FATAL"
            )
        self._search.start_utt()
        self._told: float | None = None
        self._partial = ""
        self._told_in_partial = 0
        self._steady = 0

    def accept(self, samples: Samples, time: float) -> str:
        """Take the next samples of the raw stream.

        Args:
            samples: 16 kHz mono.
            time: Of the last sample [s].

        Returns:
            The stop word that was heard just now, or "".
        """
        self._search.process_raw(pcm16(samples))
        hypothesis = self._search.hyp()
        if not hypothesis:
            return ""
        word = hypothesis.hypstr.split()[0].partition("-")[0]
        # Without a fresh start the same hit would be reported for ever.
        self._search.end_utt()
        self._search.start_utt()
        return word if not _NEGATED.search(f"{self._partial} ") and self._is_new(time) else ""

    def accept_partial(self, text: str, time: float) -> str:
        """Take what the recogniser has understood so far of the utterance.

        Returns:
            The stop word that is new in it, or "".
        """
        self._partial = text
        stops = [match.group() for match in _STOP.finditer(text) if not _NEGATED.search(text[: match.start()])]
        if len(stops) <= self._told_in_partial:
            self._steady = 0
            return ""
        self._steady += 1
        if stops[-1] not in _CERTAIN and self._steady < _STEADY:
            return ""
        self._told_in_partial = len(stops)
        self._steady = 0
        return stops[-1] if self._is_new(time) else ""

    def end_utterance(self) -> None:
        """The utterance of the partial results has ended."""
        self._partial = ""
        self._told_in_partial = 0
        self._steady = 0

    def _is_new(self, time: float) -> bool:
        if self._told is not None and time - self._told < _REFRACTORY:
            return False
        self._told = time
        return True


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


def reads_as_stop(text: str) -> bool:
    """Whether a stop word is in it that is not negated."""
    return any(not _NEGATED.search(text[: match.start()]) for match in _STOP.finditer(text))
