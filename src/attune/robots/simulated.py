"""What a simulated robot can tell beyond the Robot interface: the truth, from which verdicts are made."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from attune.core.messages import ObjectSpec
from attune.robots.interface import Arm, Point


@dataclass(frozen=True, slots=True)
class TrueObject:
    """An object of the simulated world.

    Attributes:
        spec: Its properties; `location` is the kind of place it is at, "" while held or on the floor.
        place: Name of the surface it rests on or in, "" while held or on the floor.
        position: Bottom centre, map frame [m].
        held_by: The arm whose fingers hold it, or None.
        upright: Whether its axis is within 20 degrees of upright.
    """

    spec: ObjectSpec
    place: str
    position: Point
    held_by: Arm | None
    upright: bool = True


@runtime_checkable
class Simulated(Protocol):
    """A robot whose world is simulated."""

    def true_objects(self) -> Mapping[str, TrueObject]:
        """All objects of the world by name. The planner never calls this."""
        ...

    def speed(self) -> float:
        """The fastest motion of any robot joint now [m/s or rad/s]."""
        ...
