"""What is wanted: a list of deliveries. Commands edit it; what to do next is computed from it and from what is held.

Immutable, so that a command can be tried and taken back, and old and new can be compared.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from attune.core.messages import ObjectSpec, new_id

Status = Literal["waiting", "returning", "delivered", "returned", "dropped", "failed"]

HISTORY = 50
"""Closed deliveries that are remembered."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Delivery:
    """One object that is wanted somewhere.

    Attributes:
        spec: As it was asked for.
        destination: Kind of place.
        command: Id of the command it belongs to; "" for the robot's own tidying up.
        kind: Of that command.
        status: waiting, returning (to be brought home) are open; the others are closed.
        individual: Name of the object chosen for it, "" while none is.
        past: Belongs to a task that was finished before the present one began.
    """

    spec: ObjectSpec
    destination: str
    command: str
    kind: str
    status: Status = "waiting"
    individual: str = ""
    past: bool = False
    id: str = field(default_factory=lambda: new_id("delivery"))

    @property
    def open(self) -> bool:
        """Whether there is still something to do."""
        return self.status in {"waiting", "returning"}


@dataclass(frozen=True, slots=True)
class Goal:
    """What to work on: a delivery, and where its object goes ("" for home). Two equal goals need the same plan."""

    delivery: str
    destination: str


@dataclass(frozen=True, slots=True)
class Agenda:
    """All deliveries, in the order in which they are served."""

    deliveries: tuple[Delivery, ...] = ()

    @property
    def open(self) -> tuple[Delivery, ...]:
        """Those with something left to do."""
        return tuple(delivery for delivery in self.deliveries if delivery.open)

    @property
    def waiting(self) -> tuple[Delivery, ...]:
        """Those that are wanted and not there yet."""
        return tuple(delivery for delivery in self.deliveries if delivery.status == "waiting")

    @property
    def task(self) -> tuple[Delivery, ...]:
        """Those of the present task."""
        return tuple(delivery for delivery in self.deliveries if not delivery.past)

    @property
    def reserved(self) -> frozenset[str]:
        """Names of the objects that open deliveries are about."""
        return frozenset(delivery.individual for delivery in self.open if delivery.individual)

    def get(self, id_: str) -> Delivery:
        """The delivery of this id."""
        return next(delivery for delivery in self.deliveries if delivery.id == id_)

    def of(self, individual: str) -> Delivery | None:
        """The open delivery about this object."""
        return next((delivery for delivery in self.open if delivery.individual == individual), None)

    def add(self, *deliveries: Delivery, before: str = "") -> "Agenda":
        """With more deliveries, at the end or before the one of this id."""
        ids = [delivery.id for delivery in self.deliveries]
        at = ids.index(before) if before else len(ids)
        return Agenda((*self.deliveries[:at], *deliveries, *self.deliveries[at:]))

    def change(self, id_: str, **changes: Any) -> "Agenda":
        """With one delivery changed."""
        return Agenda(tuple(replace(item, **changes) if item.id == id_ else item for item in self.deliveries))

    def begin_task(self) -> "Agenda":
        """With what is closed put into the past, if nothing is open: a new task begins."""
        if self.open:
            return self
        return Agenda(tuple(replace(item, past=True) for item in self.deliveries[-HISTORY:]))

    def without_open(self) -> "Agenda":
        """With everything open dropped."""
        return Agenda(tuple(replace(item, status="dropped") if item.open else item for item in self.deliveries))

    def goal(self, held: Iterable[str]) -> Goal | None:
        """What to do next: what is held first, then what somebody asked for, in its order, then tidying up."""
        for name in held:
            if delivery := self.of(name):
                return _goal(delivery)
        return next((_goal(delivery) for delivery in sorted(self.open, key=lambda item: not item.command)), None)


def _goal(delivery: Delivery) -> Goal:
    return Goal(delivery.id, "" if delivery.status == "returning" else delivery.destination)
