"""Everyday English as a rival of the domain: what it explains better than the domain does is about something else."""

from functools import cache
from pathlib import Path

WORDS = 3000
"""The commonest words; more cost time and change little."""


@cache
def everyday_dictionary() -> str:
    """Pronunciations of the commonest words of the acoustic model's own dictionary, as the recogniser reads them."""
    import pocketsphinx

    models = Path(pocketsphinx.get_model_path()) / "en-us"
    model = pocketsphinx.NGramModel.readfile(str(models / "en-us.lm.bin"))
    entries: dict[str, list[str]] = {}
    for line in (models / "cmudict-en-us.dict").read_text(encoding="utf-8").splitlines():
        entries.setdefault(line.split(" ")[0].split("(")[0], []).append(line)
    commonest = sorted(entries, key=lambda word: model.prob([word]), reverse=True)[:WORDS]
    return "\n".join([*(line for word in sorted(commonest) for line in entries[word]), ""])
