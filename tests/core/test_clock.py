"""Virtual time costs nothing and is reproducible; both clocks keep the same contract."""

import threading

import anyio
import pytest

from attune.core.clock import Clock, RealClock, VirtualClock, run


def test_an_hour_of_virtual_time_passes_at_once_and_exactly() -> None:
    clock = VirtualClock()

    async def main() -> None:
        await clock.sleep(3600)

    run(main, clock)
    assert clock.now() == pytest.approx(3600)


def test_virtual_sleepers_wake_in_the_order_of_their_times() -> None:
    clock = VirtualClock()
    woken: list[tuple[str, float]] = []

    async def sleeper(name: str, seconds: float) -> None:
        await clock.sleep(seconds)
        woken.append((name, round(clock.now(), 6)))

    async def main() -> None:
        async with anyio.create_task_group() as group:
            for name, seconds in (("late", 30.0), ("early", 10.0), ("middle", 20.0)):
                group.start_soon(sleeper, name, seconds)

    run(main, clock)
    assert woken == [("early", 10.0), ("middle", 20.0), ("late", 30.0)]


def test_deadlines_run_in_virtual_time() -> None:
    clock = VirtualClock()

    async def main() -> bool:
        with anyio.move_on_after(5) as scope:
            await clock.sleep(60)
        return scope.cancelled_caught

    assert run(main, clock)
    assert clock.now() == pytest.approx(5)


def test_heavy_work_takes_no_virtual_time() -> None:
    clock = VirtualClock()
    released = threading.Event()

    async def main() -> tuple[float, float]:
        async with anyio.create_task_group() as group:
            group.start_soon(clock.sleep, 100)  # a timer that time must not jump to
            before = clock.now()
            threading.Timer(0.05, released.set).start()
            await clock.run_in_thread(released.wait)
            after = clock.now()
            group.cancel_scope.cancel()
        return before, after

    before, after = run(main, clock)
    assert before == after


@pytest.mark.parametrize("make_clock", [RealClock, VirtualClock])
def test_every_ticks_until_cancelled_and_not_after(make_clock: type[Clock]) -> None:
    clock = make_clock()
    ticks: list[float] = []

    async def main() -> int:
        async with anyio.create_task_group() as group:
            group.start_soon(clock.every, 0.01, lambda: ticks.append(clock.now()))
            while len(ticks) < 5:
                await clock.sleep(0.01)
            group.cancel_scope.cancel()
        ended_with = len(ticks)
        await clock.sleep(0.05)
        return len(ticks) - ended_with

    assert run(main, clock) <= 1  # a tick that had begun may end


@pytest.mark.parametrize("make_clock", [RealClock, VirtualClock])
def test_a_failing_tick_is_not_swallowed(make_clock: type[Clock]) -> None:
    clock = make_clock()

    def tick() -> None:
        raise ValueError("the motor controller is gone")

    async def main() -> None:
        await clock.every(0.01, tick)

    with pytest.raises(ValueError, match="motor controller"):
        run(main, clock)


def test_a_virtual_clock_outside_its_own_loop_says_so() -> None:
    clock, other = VirtualClock(), VirtualClock()

    async def main() -> None:
        await other.sleep(1)

    with pytest.raises(RuntimeError, match="VirtualClock"):
        run(main, clock)
