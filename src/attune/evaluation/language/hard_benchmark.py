"""The harder parts: what people say beyond the paper's benchmark, from `hard.jsonl` and `fresh.jsonl`.

Nobody tunes an interpreter on these sentences. `hard` was written before its author had seen a rule; its errors are
looked at by their cause, and the cause is mended for all sentences like it. `fresh` was written later, by the same
author and two others; its errors are only counted, so that one figure stays honest. Whoever works from them writes a
new `fresh`. The command model has learnt from neither.
"""

from importlib import resources
from types import MappingProxyType
from typing import Any, Literal

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


def hard_items(part: Literal["hard", "fresh"] = "hard") -> tuple[Item, ...]:
    """All items of a part, in the order of the file.

    Raises:
        BenchmarkError: A line is wrong.
    """
    text = (resources.files("attune.data") / f"benchmarks/language/{part}.jsonl").read_text(encoding="utf-8")
    items: list[Item] = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            entry = _Line.model_validate_json(line)
        except ValidationError as error:
            raise BenchmarkError(f"{part}.jsonl, line {number},", describe(error)) from None
        context = MappingProxyType(entry.context)
        items.append(Item(entry.id, part, entry.group, entry.utterance, entry.expected, context))
    return tuple(items)
