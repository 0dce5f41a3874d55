"""Hears "stop" while the person is still speaking, from the raw stream and from partial results."""

import math
import tempfile
from pathlib import Path

from attune.speech.audio import FRAME_SECONDS, Samples
from attune.speech.loudness import Background, level
from attune.speech.pronunciation import dictionary_text
from attune.speech.sphinx import pcm16
from attune.speech.stop_words import is_negated_after, stops_in

_KEYWORDS = {"stop": "S T AA P", "stop-british": "S T AO P"}
"""Sounds that the keyword search looks for. "Freeze" fires on "please" and "halt" on half of all speech, so only the
partial results tell those."""
_SPOTTED = "stop"
_SEARCHED = 1e-25
"""Threshold of the search, far lower than what counts."""
_SURE, _LEAST_SURE = -225.0, -560.0
"""Evidence that counts: in a quiet room, where ordinary speech often comes near, and in noise, which takes from the
evidence. Logarithm of the word's probability over that of any sounds (base 1.0001, in steps of 1024)."""
_OVERRULES, _OVERRULES_DOUBT = -100.0, -225.0
"""Evidence that nothing but this word gives, and evidence that counts for more than a doubtful text."""
_QUIET_MARGIN, _NOISY_MARGIN = 50.0, 36.0
"""The room is quiet or noisy when the loudest speech is so much louder than the background [dB]."""
_LEAST_MARGIN = 20.0
"""A stop in the distance is somebody else's [dB over the background]."""
_RIPENS = 0.16
"""The evidence still grows for this long after it was first found [s]."""
_WORD_LENGTH = 0.8
"""The loudness of the word is that of the last moment [s]."""
_LOG_BASE = math.log(1.0001)
_OFFSET = 1500.0
"""PocketSphinx takes this from the evidence (KWS_MAX in kws_search.h)."""
_CERTAIN = {"stop", "halt"}
_STEADY = 3
"""Other stop words count once they stood in so many partial results in a row: they come and go in ordinary speech."""
_REFRACTORY = 1.0
"""Both ways of hearing tell the same word within this time [s]."""


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
            dictionary.write_text(dictionary_text({word: (phones,) for word, phones in _KEYWORDS.items()}))
            keywords.write_text("".join(f"{word} /{_SEARCHED:g}/\n" for word in _KEYWORDS))
            self._search = pocketsphinx.Decoder(
                hmm=str(models / "en-us"), dict=str(dictionary), kws=str(keywords), loglevel="FATAL"
            )
        self._search.start_utt()
        self._found: float | None = None
        self._background = Background(FRAME_SECONDS)
        self._told: float | None = None
        self._partial = ""
        self._told_in_partial = 0
        self._steady = 0
        self._evidence_told = -math.inf
        self._in_noise = False

    def accept(self, samples: Samples, time: float, *, voiced: bool = True) -> str:
        """Take the next samples of the raw stream.

        Args:
            samples: 16 kHz mono.
            time: Of the last sample [s].
            voiced: Somebody's voice was heard just now. What is left of the robot's own is none.

        Returns:
            The stop word that was heard just now, or "".
        """
        self._background.accept(level(samples))
        self._search.process_raw(pcm16(samples))
        found = self._search.hyp()
        if not found:
            return ""
        if self._found is None:
            self._found = time
        evidence, needed = self._evidence(), self._needed()
        counts = evidence >= needed
        if counts or time - self._found >= _RIPENS:
            # Without a fresh start the same word would be found for ever.
            self._search.end_utt()
            self._search.start_utt()
            self._found = None
        if not voiced or not counts or is_negated_after(self._partial):
            return ""
        if not self._is_new(time):
            return ""
        self._evidence_told, self._in_noise = evidence, needed < _SURE
        return _SPOTTED

    def overrules(self, *, doubtful: bool) -> bool:
        """Whether the last stop that the search found is to be believed where the recogniser hears another word.

        So it is when the search is quite sure, and in noise, which garbles what the recogniser hears.

        Args:
            doubtful: The recogniser is not sure either.
        """
        return self._in_noise or self._evidence_told >= (_OVERRULES_DOUBT if doubtful else _OVERRULES)

    def _evidence(self) -> float:
        return max(math.log(max(segment.prob, 1e-300)) / _LOG_BASE + _OFFSET for segment in self._search.seg())

    def _needed(self) -> float:
        margin = self._background.loudest(_WORD_LENGTH) - self._background.level
        if margin < _LEAST_MARGIN:
            return math.inf
        noisy = (_QUIET_MARGIN - margin) / (_QUIET_MARGIN - _NOISY_MARGIN)
        return _SURE + min(1.0, max(0.0, noisy)) * (_LEAST_SURE - _SURE)

    def accept_partial(self, text: str, time: float) -> str:
        """Take what the recogniser has understood so far of the utterance.

        Returns:
            The stop word that is new in it, or "".
        """
        self._partial = text
        stops = stops_in(text)
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
