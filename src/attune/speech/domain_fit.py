"""How well a text fits the domain: for recognisers that know all of English and would transcribe anybody's talk."""

import math
from collections.abc import Sequence

from attune.speech.language_model import END, START, LanguageModel

_UNKNOWN = -5.0
"""Logarithm (base 10) of the probability that a word is one that the domain does not have."""
IN_DOMAIN_FIT = -2.4
"""Mean logarithm (base 10) of a word's probability under which a text is about something else; chosen on text."""


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

    def contains(self, text: str) -> bool:
        """Whether a text may be of the domain."""
        return bool(text) and self.fit(text) >= IN_DOMAIN_FIT
