"""How well a text fits the domain: for recognisers that know all of English and would transcribe anybody's talk."""

import math
from collections.abc import Sequence

from attune.speech.background import everyday_probability
from attune.speech.language_model import END, START, LanguageModel

_UNKNOWN = -5.0
"""Logarithm (base 10) of the probability that a word is one that the domain does not have."""
_TELLING = 0.5
"""Words that the domain has more often than everyday English by less than this (logarithm, base 10) tell nothing."""


class DomainFit:
    """Tells sentences of the domain from other talk.

    Args:
        sentences: What people may say: lower case, no punctuation.
    """

    def __init__(self, sentences: Sequence[str]) -> None:
        self._model = LanguageModel(sentences)
        self._known = {*self._model.words, END}
        self.words = self._model.words
        """All words of the domain."""

    def fit(self, text: str) -> float:
        """Mean logarithm (base 10) of the probability of each word after the two before it; 0 is certain."""
        words = (START, *text.split(), END)
        logs = [
            math.log10(self._model.probability(word, words[max(0, index - 2) : index]))
            if word in self._known
            else _UNKNOWN
            for index, word in enumerate(words)
            if index > 0
        ]
        return sum(logs) / len(logs)

    def log_probability(self, text: str) -> float:
        """Of the whole text (natural logarithm)."""
        return self.fit(text) * (len(text.split()) + 1) * math.log(10)

    def telling_words(self, text: str) -> dict[str, float]:
        """Words that are said to the robot rather than in everyday English, in order, with their lead (base 10)."""
        found: dict[str, float] = {}
        for word in text.split():
            if word in self._known and (lead := self._lead(word)) > 0:
                found[word] = found.get(word, 0.0) + lead
        return found

    def unknown_words(self, text: str) -> int:
        """How many words the domain does not have."""
        return sum(word not in self._known for word in text.split())

    def _lead(self, word: str) -> float:
        return math.log10(self._model.probability(word)) - everyday_probability(word) - _TELLING
