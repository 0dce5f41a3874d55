"""Hears "stop" while the person is still speaking, from the raw stream and from partial results."""

import math
from collections import deque

from attune.speech.audio import FRAME_SECONDS, Samples
from attune.speech.loudness import SILENCE, Background, level
from attune.speech.stop_network import StopNetwork, Verdict
from attune.speech.stop_words import is_negated_after, stops_in

_WORD = "stop"
_ALONE = 0.6
"""Probability of "stop" from which it counts whatever the recogniser hears. It errs towards stopping. Chosen, as those
below, on voices of development."""
_WITH_TEXT = 0.3
"""The same where a partial result holds a stop word."""
_AGAINST_TEXT = 0.97
"""The same after a partial result that would negate it: "no" is easily taken for "don't"."""
_CERTAIN = {"stop", "halt"}
_STEADY = 3
"""Other stop words count once they stood in so many partial results in a row: they come and go in ordinary speech."""
_LEAST_MARGIN = 10.0
"""A stop in the distance is somebody else's [dB over the background]."""
_WORD_LENGTH = 0.8
"""The loudness of the word, and what the network made of it, is that of the last moment [s]."""
_FALLEN, _FALLEN_FOR = 8.0, 0.4
"""Who is softer than the word by this [dB] for this long [s] is somebody else."""
_STILL_TOLD = 1.5
"""The network remembers 2 s: so long after a word [s] it still judges that."""
_REFRACTORY = 1.0
"""Both ways of hearing tell the same word within this time [s]."""
_REMEMBERED = 3.0
_SETTLED, _FORGOTTEN = 0.1, 0.7
"""The network is asked about an utterance so long after its end [s]."""


class StopSpotter:
    """A small network that always listens, and the stop words of partial results. The first of the two counts.

    A spotted stop only pauses the robot, and the whole utterance decides. Belongs to one thread at a time.
    """

    def __init__(self) -> None:
        self._network = StopNetwork()
        self._background = Background(FRAME_SECONDS)
        self._told: float | None = None
        self._loudness = SILENCE
        self._order_after = 0.0
        self._heard: deque[tuple[float, Verdict]] = deque(maxlen=round(_REMEMBERED / FRAME_SECONDS))
        self._partial = ""
        self._told_in_partial = 0
        self._steady = 0

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
        verdict = self._network.accept(samples)
        if verdict is None:
            return ""
        self._heard.append((time, verdict))
        if self._is_softer_now(time):
            self._order_after = max(self._order_after, verdict.order)
        needed = _AGAINST_TEXT if is_negated_after(self._partial) else _ALONE
        if verdict.stop < needed or not voiced or self._is_far():
            return ""
        return _WORD if self._is_new(time) else ""

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
        if (stops[-1] not in _CERTAIN and self._steady < _STEADY) or not self._is_likely(time):
            return ""
        self._told_in_partial = len(stops)
        self._steady = 0
        return stops[-1] if self._is_new(time) else ""

    def end_utterance(self) -> None:
        """The utterance of the partial results has ended."""
        self._partial = ""
        self._told_in_partial = 0
        self._steady = 0

    @property
    def latest_order(self) -> float:
        """As `order`, at this moment."""
        return self._heard[-1][1].order if self._heard else 0.0

    def order(self, end: float, start: float = math.inf) -> float:
        """Probability that what was said until then, within two seconds, was an order to stop and nothing else.

        Args:
            end: When it ended [s]; the probability is known 0.1 s after that.
            start: When it began [s]. If a stop was spotted since, the probability after that counts, too, if only much
                softer voices followed it: they may have hidden its end.
        """
        settled = [each.order for time, each in tuple(self._heard) if _SETTLED <= time - end <= _FORGOTTEN]
        is_told = self._told is not None and self._told >= start
        return max([*settled, self._order_after if is_told else 0.0])

    def _is_likely(self, time: float) -> bool:
        recent = [each for heard, each in tuple(self._heard) if heard >= time - _WORD_LENGTH]
        return any(max(each.stop, each.relative) >= _WITH_TEXT for each in recent)

    def _is_far(self) -> bool:
        return self._background.loudest(_WORD_LENGTH) - self._background.level < _LEAST_MARGIN

    def _is_softer_now(self, time: float) -> bool:
        is_told = self._told is not None and time - self._told < _STILL_TOLD
        return is_told and self._background.loudest(_FALLEN_FOR) <= self._loudness - _FALLEN

    def _is_new(self, time: float) -> bool:
        if self._told is not None and time - self._told < _REFRACTORY:
            return False
        self._told = time
        self._loudness, self._order_after = self._background.loudest(_WORD_LENGTH), 0.0
        return True
