"""Many independent runs, in one process or in several."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_parallel(work: Callable[[Item], Result], items: Sequence[Item], jobs: int) -> Iterator[Result]:
    """Do `work` with each item; the results come in the items' order, each as soon as those before it are there.

    Args:
        work: What to do; with several jobs it must be picklable, as must items and results.
        items: What to do it with.
        jobs: Processes; 1 works in this one.
    """
    if jobs == 1 or len(items) < 2:
        yield from map(work, items)
        return
    chunk = max(1, min(50, len(items) // (4 * jobs)))
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(work, items, chunksize=chunk)
