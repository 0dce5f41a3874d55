"""The bus delivers everything, in order, typed."""

import anyio
import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, ROBOT_STATE, ROBOT_STOP, Bus
from attune.core.clock import VirtualClock, run


def test_subscribers_get_every_message_in_order_even_if_they_read_late() -> None:
    clock, bus = VirtualClock(), Bus()
    sent = [m.BringMe(time=float(i), objects=(m.ObjectSpec(type="cup"),)) for i in range(1000)]

    async def main() -> list[m.Command]:
        with bus.subscribe(COMMAND) as commands:
            for command in sent:
                bus.publish(COMMAND, command)
            await clock.sleep(1)
            return [await commands.receive() for _ in sent]

    assert run(main, clock) == sent


def test_a_handler_has_run_when_publish_returns() -> None:
    bus = Bus()
    seen: list[m.StopSignal] = []
    forget = bus.on(ROBOT_STOP, seen.append)
    signal = m.StopSignal(time=0.0)
    bus.publish(ROBOT_STOP, signal)
    assert seen == [signal]
    forget()
    bus.publish(ROBOT_STOP, signal)
    assert seen == [signal]


def test_a_late_subscriber_gets_the_latched_state_first() -> None:
    clock, bus = VirtualClock(), Bus()
    bus.publish(ROBOT_STATE, m.RobotState(time=0.0, step="idle"))
    bus.publish(ROBOT_STATE, m.RobotState(time=1.0, step="transporting_search"))

    async def main() -> m.RobotState:
        with bus.subscribe(ROBOT_STATE) as states:
            return await states.receive()

    assert run(main, clock).step == "transporting_search"
    latest = bus.latest(ROBOT_STATE)
    assert latest is not None
    assert latest.step == "transporting_search"


def test_a_message_of_the_wrong_type_is_refused() -> None:
    with pytest.raises(TypeError, match="robot/command"):
        Bus().publish(COMMAND, m.RobotState(time=0.0))  # type: ignore[arg-type]


def test_a_waiting_subscriber_can_be_cancelled() -> None:
    clock, bus = VirtualClock(), Bus()

    async def main() -> bool:
        with bus.subscribe(COMMAND) as commands, anyio.move_on_after(1) as scope:
            await commands.receive()
        return scope.cancelled_caught

    assert run(main, clock)
