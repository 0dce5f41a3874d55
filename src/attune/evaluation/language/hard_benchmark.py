"""The harder part: what people say beyond the paper's benchmark, read from `data/benchmarks/language/hard.jsonl`.

Held out: nobody tunes an interpreter on these sentences. Errors are looked at by their cause, and the cause is mended
for all sentences like it.
"""

from importlib import resources
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from attune.core.codec import describe
from attune.evaluation.language.items import BenchmarkError, Item, Meaning, _Strict


class _Line(_Strict):
    """One line of the file: a line that `attune understand` reads, with its meaning and its difficulty."""

    id: str
    group: str
    utterance: str
    context: dict[str, Any]
    expected: Meaning


def hard_items() -> tuple[Item, ...]:
    """All items, in the order of the file.

    Raises:
        BenchmarkError: A line is wrong.
    """
    text = (resources.files("attune.data") / "benchmarks/language/hard.jsonl").read_text(encoding="utf-8")
    items: list[Item] = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            entry = _Line.model_validate_json(line)
        except ValidationError as error:
            raise BenchmarkError(f"hard.jsonl, line {number},", describe(error)) from None
        context = MappingProxyType(entry.context)
        items.append(Item(entry.id, "hard", entry.group, entry.utterance, entry.expected, context))
    return tuple(items)
