"""Parts made of parts: sequence, parallel, try in order, repeat, retry with recovery, monitor."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import anyio

from attune.core.clock import Clock
from attune.core.errors import AttuneError
from attune.planner.plan import FAILURES, Node, Part

T = TypeVar("T")


def sequence(name: str, *parts: Part[Any], atomic: bool = False) -> Part[None]:
    """One after the other; fails with the first that fails."""

    async def body(node: Node) -> None:
        for part, child in zip(parts, node.expect(parts), strict=True):
            await node.do(part, child)

    return Part(name, body, atomic)


def parallel(name: str, *parts: Part[Any]) -> Part[None]:
    """All at once; succeeds when all have; the first failure interrupts the others."""

    async def body(node: Node) -> None:
        failures: list[AttuneError] = []

        async def branch(part: Part[Any], child: Node) -> None:
            try:
                await node.do(part, child)
            except FAILURES as failure:
                failures.append(failure)
                group.cancel_scope.cancel()

        async with anyio.create_task_group() as group:
            for part, child in zip(parts, node.expect(parts), strict=True):
                group.start_soon(branch, part, child)
        if failures:
            raise failures[0]

    return Part(name, body)


def try_in_order(
    name: str, *parts: Part[T], on: tuple[type[AttuneError], ...] = FAILURES, atomic: bool = False
) -> Part[T]:
    """The first that succeeds; goes on to the next when one fails with a type in `on`; else fails as the last did."""
    if not parts:
        raise ValueError("try_in_order needs a part")

    async def body(node: Node) -> T:
        children = node.expect(parts)
        for part, child in zip(parts[:-1], children[:-1], strict=True):
            try:
                return await node.do(part, child)
            except on:
                continue
        return await node.do(parts[-1], children[-1])

    return Part(name, body, atomic)


def repeat(name: str, part: Part[Any], while_: Callable[[int], bool]) -> Part[None]:
    """Again and again as long as `while_(rounds done)` holds."""

    async def body(node: Node) -> None:
        rounds = 0
        while while_(rounds):
            await node.do(part)
            rounds += 1

    return Part(name, body)


@dataclass(frozen=True, slots=True)
class Recovery:
    """What repairs the damage of one type of failure.

    Attributes:
        make: Makes the part that does, from the failure.
        times: How often in one `retry`.
    """

    make: Callable[[Any], Part[Any]]
    times: int


def retry(name: str, part: Callable[[int], Part[T]], recoveries: Mapping[type[AttuneError], Recovery]) -> Part[T]:
    """`part(attempt)` until it succeeds; between two attempts the recovery for the type of the failure.

    Fails with a failure that has no recovery, or whose recovery was used as often as it may be. A recovery that fails
    does not end it: the next attempt begins with the world as it is then.
    """

    async def body(node: Node) -> T:
        used: list[type[AttuneError]] = []
        while True:
            try:
                return await node.do(part(len(used)))
            except FAILURES as failure:
                type_ = next((type_ for type_ in recoveries if isinstance(failure, type_)), None)
                if type_ is None or used.count(type_) >= recoveries[type_].times:
                    raise
                used.append(type_)
                repair = recoveries[type_].make(failure)
            try:
                await node.do(repair)
            except FAILURES:
                continue

    return Part(name, body)


def monitor(
    name: str,
    part: Part[T],
    holds: Callable[[], bool],
    broken: Callable[[], AttuneError],
    clock: Clock,
    period: float = 0.2,
) -> Part[T]:
    """Run a part as long as `holds()`; when it does not any more, interrupt the part and fail with `broken()`."""

    async def watch() -> AttuneError:
        while holds():
            await clock.sleep(period)
        return broken()

    async def body(node: Node) -> T:
        return await _beside(watch, lambda: node.do(part))

    return Part(name, body)


def atomic_while(part: Part[T], holds: Callable[[], bool], clock: Clock, period: float = 0.2) -> Part[T]:
    """Run a part; as long as `holds()`, a minor interruption waits."""

    async def body(node: Node) -> T:
        with node.atomic_while(holds) as notice:

            async def watch() -> AttuneError:
                while True:
                    notice()
                    await clock.sleep(period)

            return await _beside(watch, lambda: part.body(node))

    return Part(part.name, body)


async def _beside(watch: Callable[[], Awaitable[AttuneError]], work: Callable[[], Awaitable[T]]) -> T:
    """Work while something watches; if the watch ends, the work is cancelled and has failed with what it returns."""
    values: list[T] = []
    failures: list[AttuneError] = []

    async def watching() -> None:
        failures.append(await watch())
        group.cancel_scope.cancel()

    async with anyio.create_task_group() as group:
        group.start_soon(watching)
        try:
            values.append(await work())
        except FAILURES as failure:
            failures.append(failure)
        group.cancel_scope.cancel()
    if values:
        return values[0]
    raise failures[0]
