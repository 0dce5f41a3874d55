"""Runs the language benchmark with any interpreter."""

from collections.abc import Awaitable, Callable, Sequence
from typing import Any

import anyio
from pydantic import ValidationError

from attune.core.clock import Clock
from attune.core.codec import describe
from attune.evaluation.language.hard_benchmark import hard_items
from attune.evaluation.language.items import Item, Meaning, Part
from attune.evaluation.language.paper_benchmark import paper_items
from attune.evaluation.language.report import LanguageReport
from attune.evaluation.language.scoring import Answer

Respond = Callable[[Sequence[Item], Callable[[dict[str, Any]], None]], Awaitable[None]]
"""Answers items in their order; hands over each answer, a line of `attune understand`'s output, when it is there."""


def benchmark_items(parts: Sequence[Part] = ("paper", "hard", "fresh"), sample: int = 0) -> tuple[Item, ...]:
    """The items of the benchmark.

    Args:
        parts: Which parts.
        sample: Evenly spread, at most so many of each part, for endpoints that cost money; 0 takes all.
    """
    found: list[Item] = []
    for part in parts:
        items = paper_items() if part == "paper" else hard_items(part)
        count = min(sample, len(items)) if sample else len(items)
        found += [items[number * len(items) // count] for number in range(count)]
    return tuple(found)


async def evaluate(
    interpreter: str,
    items: Sequence[Item],
    respond: Respond,
    clock: Clock,
    *,
    model: str = "",
    at_once: int = 1,
    on_progress: Callable[[], None] = lambda: None,
) -> LanguageReport:
    """Let an interpreter answer all items.

    Args:
        interpreter: Its name, for the report.
        items: What to ask it.
        respond: How to ask it.
        clock: Times the answers.
        model: The language model behind it, if there is one.
        at_once: How many items may be under way at the same time.
        on_progress: Called after each item.
    """
    answers: list[Answer | None] = [None] * len(items)

    async def ask(indices: range) -> None:
        left = iter(indices)
        before = clock.now()

        def receive(line: dict[str, Any]) -> None:
            nonlocal before
            now, index = clock.now(), next(left)
            answers[index] = _answer(items[index], line, now - before)
            before = now
            on_progress()

        await respond([items[index] for index in indices], receive)

    async with anyio.create_task_group() as tasks:
        for first in range(min(at_once, len(items))):
            tasks.start_soon(ask, range(first, len(items), at_once))
    return LanguageReport(interpreter, tuple(answer for answer in answers if answer is not None), model)


def _answer(item: Item, line: dict[str, Any], seconds: float) -> Answer:
    try:
        return Answer(item, Meaning.model_validate(line), seconds, str(line.get("reason", "")))
    except ValidationError as error:
        return Answer(item, None, seconds, "; ".join(describe(error)))
