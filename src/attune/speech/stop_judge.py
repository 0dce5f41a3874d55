"""Compares two readings of a short utterance: an order to stop, and the text that the recogniser has found."""

import math
import re
import tempfile
from pathlib import Path
from typing import Any

from attune.speech.audio import Samples
from attune.speech.pronunciation import UnpronounceableWordError, dictionary_text, pronounce
from attune.speech.sphinx import pcm16

_HEADER = "#JSGF V1.0; grammar {name}; public <{name}> = {rule};"
_ORDER = "[please | no | oh | oh no | no no | hey | robot | okay | just | wait] stop [stop [stop]]"
_LONGER_ORDER = f"{_ORDER} [it | now | please | right now | right there | that | that now | it now]"
_PRONUNCIATIONS = {"stop": ("S T AA P", "S T AO P")}
_WORD = re.compile(r"[a-z']+")


class StopJudge:
    """Scores a recording against a grammar of orders to stop and against any text, by sound alone.

    The recogniser's language model takes no part in it: to that, "please talk" or "don't stop" may be likelier. Belongs
    to one thread at a time; the acoustic model is loaded when it is first asked.
    """

    def __init__(self) -> None:
        self._decoder: Any = None
        self._known: set[str] = set()

    def lead(self, samples: Samples, text: str) -> float:
        """How much better an order to stop explains the sound than a text does.

        Args:
            samples: The utterance, 16 kHz mono, with a little of the silence around it.
            text: What else it may be.

        Returns:
            Difference of the acoustic scores for each frame of 10 ms (natural logarithm): about 0 if they sound alike,
            infinite if the text does not fit at all, minus infinite if it cannot be an order to stop.
        """
        decoder = self._decoder = self._decoder or self._make()
        words = _WORD.findall(text.lower())
        # Words after the stop that the recogniser has not heard would only be an excuse.
        decoder.activate_search("order" if words[-1:] == ["stop"] else "longer")
        order = self._score(samples, "stop")
        if order is None:
            return -math.inf
        if not words:
            return math.inf
        if not self._learns(words):
            return -math.inf
        decoder.add_jsgf_string("text", _HEADER.format(name="text", rule=" ".join(words)))
        decoder.activate_search("text")
        other = self._score(samples, words[-1])
        return math.inf if other is None else (order - other) / max(1, decoder.n_frames())

    def _make(self) -> Any:
        import pocketsphinx

        models = Path(pocketsphinx.get_model_path()) / "en-us"
        words = {*_WORD.findall(_LONGER_ORDER)}
        with tempfile.TemporaryDirectory() as folder:
            dictionary = Path(folder) / "order.dict"
            dictionary.write_text(dictionary_text({**pronounce(sorted(words)), **_PRONUNCIATIONS}))
            # All sounds are scored in every frame, so that the scores of two searches can be compared.
            decoder = pocketsphinx.Decoder(
                hmm=str(models / "en-us"), dict=str(dictionary), compallsen=True, cmn="batch", loglevel="FATAL"
            )
        decoder.add_jsgf_string("order", _HEADER.format(name="order", rule=_ORDER))
        decoder.add_jsgf_string("longer", _HEADER.format(name="longer", rule=_LONGER_ORDER))
        self._known = words
        return decoder

    def _learns(self, words: list[str]) -> bool:
        unknown = sorted({*words} - self._known)
        try:
            found = pronounce(unknown) if unknown else {}
        except UnpronounceableWordError:
            return False
        for word, ways in found.items():
            for index, phones in enumerate(ways):
                self._decoder.add_word(word if index == 0 else f"{word}({index + 1})", phones, index == len(ways) - 1)
        self._known.update(unknown)
        return True

    def _score(self, samples: Samples, needed: str) -> float | None:
        """Logarithm of the likelihood; None if the active grammar does not fit as far as a word of it."""
        self._decoder.start_utt()
        self._decoder.process_raw(pcm16(samples), full_utt=True)
        self._decoder.end_utt()
        hypothesis = self._decoder.hyp()
        if not hypothesis or needed not in hypothesis.hypstr.split():
            return None
        segments = list(self._decoder.seg())
        return sum(math.log(max(segment.ascore, 1e-300)) for segment in segments)
