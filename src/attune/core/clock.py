"""Time. Everything takes a clock; nothing else reads the time or sleeps.

`RealClock` is for people. `VirtualClock` is for tests and trials: waiting costs nothing, and the order of
events is reproducible. Under a virtual clock every timer
of the event loop (sleeps, deadlines, cancel scopes) runs in virtual time, and heavy work takes none of it.
"""

import asyncio
import selectors
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Any, Protocol, TypeVar

import anyio
import anyio.lowlevel
import anyio.to_thread

T = TypeVar("T")


class Clock(Protocol):
    """The time, and the only way to wait for it."""

    def now(self) -> float:
        """Seconds since the clock was made. May be called from any thread."""
        ...

    async def sleep(self, seconds: float) -> None:
        """Wait. Cancellable."""
        ...

    async def every(self, period: float, tick: Callable[[], None]) -> None:
        """Call `tick` each `period` seconds until cancelled.

        A real clock calls it from a thread of its own, so that a busy event loop does not delay it; a virtual
        clock calls it from the event loop. An exception in `tick` ends the wait and is raised here.
        """
        ...

    async def run_in_thread(self, work: Callable[[], T]) -> T:
        """Run heavy work off the event loop and wait for its result.

        A cancelled wait still lets the work finish first, so keep one piece of work under about 0.2 s.
        """
        ...


class RealClock:
    """Wall-clock time, monotonic."""

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        """Seconds since the clock was made."""
        return time.monotonic() - self._start

    async def sleep(self, seconds: float) -> None:
        """Wait for real."""
        await anyio.sleep(max(0.0, seconds))

    async def every(self, period: float, tick: Callable[[], None]) -> None:
        """Call `tick` from a thread; a late tick does not shift the ones after it."""
        stopped = threading.Event()

        def loop() -> None:
            due = time.monotonic()
            while not stopped.is_set():
                tick()
                # After a long stall, go on from now instead of firing the missed ticks in a burst.
                due = max(due + period, time.monotonic() - period)
                stopped.wait(max(0.0, due - time.monotonic()))

        try:
            await anyio.to_thread.run_sync(loop, abandon_on_cancel=True, limiter=anyio.CapacityLimiter(1))
        finally:
            stopped.set()

    async def run_in_thread(self, work: Callable[[], T]) -> T:
        """Run `work` in a worker thread."""
        return await anyio.to_thread.run_sync(work)


class VirtualClock:
    """Time that moves only when everybody waits. Use with `run`."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Virtual seconds since the start."""
        return self._now

    async def sleep(self, seconds: float) -> None:
        """Wait in virtual time."""
        self._check_loop()
        await anyio.sleep(max(0.0, seconds))

    async def every(self, period: float, tick: Callable[[], None]) -> None:
        """Call `tick` from the event loop, each `period` virtual seconds."""
        self._check_loop()
        while True:
            tick()
            await asyncio.sleep(period)  # Which anyio also does, after looking up each time on which loop it runs.

    async def run_in_thread(self, work: Callable[[], T]) -> T:
        """Run `work` at once, in the event loop: threads would race, and no two runs would be alike."""
        self._check_loop()
        await anyio.lowlevel.checkpoint()
        return work()

    def _check_loop(self) -> None:
        loop = asyncio.get_running_loop()
        if not isinstance(loop, _VirtualEventLoop) or loop.clock is not self:
            raise RuntimeError("a VirtualClock works only inside attune.core.clock.run(main, clock)")


class _VirtualEventLoop(asyncio.SelectorEventLoop):
    """An event loop that jumps to its next timer instead of waiting for it."""

    def __init__(self, clock: VirtualClock) -> None:
        self.clock = clock
        super().__init__(_VirtualSelector(clock))

    def time(self) -> float:
        return self.clock.now()


class _VirtualSelector(selectors.DefaultSelector):
    def __init__(self, clock: VirtualClock) -> None:
        super().__init__()
        self._clock = clock

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(0)
        if ready or timeout == 0:
            return ready
        if timeout is None:
            # Nobody waits for time: only another thread, another process or a signal can bring news.
            return super().select(None)
        self._clock._now += timeout
        return []


def run(main: Callable[[], Awaitable[T]], clock: Clock) -> T:
    """Run an async function to its end under `clock`.

    Raises:
        Whatever `main` raises.
    """
    options: dict[str, Any] = {}
    if isinstance(clock, VirtualClock):
        options["loop_factory"] = lambda: _VirtualEventLoop(clock)
    return anyio.run(main, backend="asyncio", backend_options=options)
