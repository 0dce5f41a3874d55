"""Everyday English as a rival of the domain: what it explains better than the domain does is about something else."""

import math
from functools import cache
from pathlib import Path
from typing import Any

WORDS = 3000
"""The commonest words; more cost time and change little."""


_LOG_BASE = math.log10(1.0001)
"""PocketSphinx gives probabilities as logarithms to the base 1.0001."""
_RAREST = -7.0
"""Logarithm (base 10) of the probability of a word that the model does not know."""


@cache
def everyday_dictionary() -> str:
    """Pronunciations of the commonest words of the acoustic model's own dictionary, as the recogniser reads them."""
    entries: dict[str, list[str]] = {}
    for line in (_models() / "cmudict-en-us.dict").read_text(encoding="utf-8").splitlines():
        entries.setdefault(line.split(" ")[0].split("(")[0], []).append(line)
    commonest = sorted(entries, key=lambda word: _model().prob([word]), reverse=True)[:WORDS]
    return "\n".join([*(line for word in sorted(commonest) for line in entries[word]), ""])


@cache
def everyday_probability(word: str) -> float:
    """Logarithm (base 10) of how often a word is said in everyday English."""
    return max(_RAREST, float(_model().prob([word])) * _LOG_BASE)


def _models() -> Path:
    import pocketsphinx

    return Path(pocketsphinx.get_model_path()) / "en-us"


@cache
def _model() -> Any:
    import pocketsphinx

    return pocketsphinx.NGramModel.readfile(str(_models() / "en-us.lm.bin"))
