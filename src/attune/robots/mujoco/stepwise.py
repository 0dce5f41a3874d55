"""Searches in short steps, run off the event loop."""

from collections.abc import AsyncIterator, Iterator
from typing import TypeVar

from attune.core.clock import Clock

T = TypeVar("T")


async def results(clock: Clock, search: Iterator[T | None]) -> AsyncIterator[T]:
    """What a search finds. Each of its steps runs in a thread; cancelled, it ends after the step that runs."""
    steps = enumerate(search)
    while (step := await clock.run_in_thread(lambda: next(steps, None))) is not None:
        if step[1] is not None:
            yield step[1]
