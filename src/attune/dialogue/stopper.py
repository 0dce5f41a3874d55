"""The dialogue's part in stopping: the final text makes a spotted stop one, or takes it back."""

from attune.core.bus import COMMAND, EVENT, ROBOT_STOP, Bus
from attune.core.clock import Clock
from attune.core.events import Event, EventKind
from attune.core.messages import Band, Stop, StopSignal, Utterance


class Stopper:
    """Publishes what is decided about stopping, at once; waits for nothing.

    Args:
        bus: Where signals and commands go.
        clock: The session's clock.
    """

    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self.spotted: StopSignal | None = None

    def spot(self, signal: StopSignal) -> None:
        """A stop was spotted while somebody still speaks, or is taken back because they went on differently."""
        if signal.state == "spotted":
            self.spotted = signal
            self._tell("stop_spotted", f"heard {signal.word or 'a stop word'!r}: pausing", signal.id)
            return
        if signal.state == "withdrawn" and self.spotted is not None:
            self._tell("stop_withdrawn", "what followed was no order to stop", self.spotted.id)
        self.spotted = None

    def confirm(self, utterance: Utterance, band: Band) -> None:
        """The final text is a stop."""
        now = self._clock.now()
        self.spotted = None
        self._bus.publish(ROBOT_STOP, StopSignal(time=now, cause=utterance.id, state="confirmed", source="utterance"))
        self._bus.publish(COMMAND, Stop(time=now, cause=utterance.id, band=band))
        self._tell("stop_confirmed", "stop", utterance.id)

    def withdraw(self, why: str, cause: str = "") -> None:
        """Take a spotted stop back, if there is one."""
        if self.spotted is None:
            return
        spotted, self.spotted = self.spotted, None
        self._bus.publish(
            ROBOT_STOP,
            StopSignal(
                time=self._clock.now(),
                cause=cause or spotted.id,
                state="withdrawn",
                source="utterance",
                word=spotted.word,
            ),
        )
        self._tell("stop_withdrawn", why, cause or spotted.id)

    def _tell(self, kind: EventKind, text: str, cause: str) -> None:
        self._bus.publish(EVENT, Event(time=self._clock.now(), cause=cause, kind=kind, text=text))
