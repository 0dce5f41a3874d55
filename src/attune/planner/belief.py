"""What the robot believes about the objects: the inventory as expectation, then what it sees and does."""

import copy
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from attune.core.clock import Clock
from attune.core.messages import BelievedObject, ObjectSpec, Size, WorldState
from attune.core.scene import Scene
from attune.robots.interface import Arm, Percept, Point

EXPECTED = 0.5
"""Confidence in the inventory before anything was seen."""
VANISHED = 0.05
"""Confidence in an object that was not where it should be."""
DEFAULT_EXTENT: Point = (0.1, 0.1, 0.15)
"""Of an object that was not seen yet [m]."""


@dataclass(frozen=True, slots=True)
class Home:
    """Where an object came from: a surface's name, and where on it [m, map frame] if that is known."""

    surface: str
    position: Point | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Individual:
    """One object.

    Attributes:
        surface: Name of the surface it is believed on; "" while held or when nobody knows.
        position: Bottom centre in the map frame [m], None if not known.
        held_by: The arm that holds it, or "".
        confidence: 0 to 1 that it is there.
        seen: When it was last seen [s], or None.
        home: Where it belongs: where it stood before the robot moved it.
        displaced: Whether the robot has put it somewhere else than home.
        percept: As it was seen last, where the robot has put it since.
        taken_from: Name of the surface that the robot took it from last.
    """

    name: str
    type: str
    color: str
    size: Size
    surface: str
    home: Home
    position: Point | None = None
    held_by: Literal["", "left", "right"] = ""
    confidence: float = EXPECTED
    seen: float | None = None
    displaced: bool = False
    percept: Percept | None = None
    taken_from: str = ""

    @property
    def extent(self) -> Point:
        """Size of the bounding box [m]."""
        return self.percept.extent if self.percept else DEFAULT_EXTENT

    def is_a(self, spec: ObjectSpec) -> bool:
        """Whether this fits a partial description; its `location` is not compared."""
        pairs = ((spec.name, self.name), (spec.type, self.type), (spec.color, self.color), (spec.size, self.size))
        return all(not wanted or wanted == has for wanted, has in pairs)


class Belief:
    """The objects believed to exist, by name.

    Args:
        scene: Its objects are expected where it says.
        clock: Time.
        changed: Told the whole belief when it has changed.
    """

    def __init__(self, scene: Scene, clock: Clock, changed: Callable[[WorldState], None] = lambda world: None) -> None:
        self._clock = clock
        self._changed = changed
        self._surfaces = {surface.name: surface for surface in scene.surfaces}
        self._published: tuple[BelievedObject, ...] = ()
        self._objects = {
            item.name: Individual(
                name=item.name,
                type=item.type,
                color=item.color,
                size=item.size,
                surface=item.at,
                home=Home(item.at),
            )
            for item in scene.objects
        }

    # --- reading -----------------------------------------------------------------------------------------------

    @property
    def objects(self) -> tuple[Individual, ...]:
        """All of them."""
        return tuple(self._objects.values())

    def get(self, name: str) -> Individual | None:
        """The object of this name."""
        return self._objects.get(name)

    def held(self) -> dict[Arm, Individual]:
        """What is in the grippers."""
        return {item.held_by: item for item in self._objects.values() if item.held_by}

    def on(self, surface: str) -> tuple[Individual, ...]:
        """What is believed to stand on a surface."""
        return tuple(item for item in self._objects.values() if item.surface == surface)

    def place_of(self, item: Individual) -> str:
        """The kind of place an object is believed at, "" when held or unknown."""
        return self._surfaces[item.surface].place if item.surface else ""

    def home_of(self, name: str) -> str:
        """The kind of place where an object belongs, "" when that is not known."""
        item = self._objects.get(name)
        return self._surfaces[item.home.surface].place if item and item.home.surface else ""

    def describe(self, item: Individual) -> ObjectSpec:
        """All that is known of an object, as a description."""
        return ObjectSpec(
            type=item.type, color=item.color, size=item.size, location=self.place_of(item), name=item.name
        )

    def supposing(self, name: str, surface: str, position: Point) -> "Belief":
        """What would be believed if an object stood somewhere else; nobody is told."""
        other = copy.copy(self)
        other._changed = lambda world: None
        moved = replace(self._objects[name], surface=surface, position=position)
        other._objects = {**self._objects, name: moved}
        return other

    def publish(self) -> None:
        """Tell the belief if it has changed since it was told last."""
        objects = tuple(
            BelievedObject(
                spec=self.describe(item),
                place=item.surface,
                position=item.position,
                held_by=item.held_by,
                confidence=item.confidence,
                seen=item.seen,
            )
            for item in self._objects.values()
        )
        if objects != self._published:
            self._published = objects
            self._changed(WorldState(time=self._clock.now(), objects=objects))

    # --- changing ----------------------------------------------------------------------------------------------

    def observe(self, percepts: Iterable[Percept]) -> tuple[Individual, ...]:
        """Take in what was seen; returns the individuals seen, in the same order."""
        individuals = tuple(self._see(percept) for percept in percepts)
        self.publish()
        return individuals

    def missing(self, surface: str, seen: Iterable[Individual]) -> None:
        """A whole surface was looked over: what should have been on it and was not seen is not there."""
        names = {item.name for item in seen}
        for item in self.on(surface):
            if item.name not in names:
                self._objects[item.name] = _gone(item)
        self.publish()

    def vanished(self, name: str) -> None:
        """An object is not where it was believed, nor in a gripper."""
        if item := self._objects.get(name):
            self._objects[name] = _gone(item)
        self.publish()

    def taken(self, name: str, arm: Arm) -> None:
        """The robot has taken an object."""
        item = self._objects[name]
        home = item.home if item.displaced or not item.surface else Home(item.surface, item.position)
        self._objects[name] = replace(
            item, surface="", position=None, held_by=arm, confidence=1.0, home=home, taken_from=item.surface
        )
        self.publish()

    def put(self, name: str, surface: str, position: Point, *, confidence: float = 1.0) -> None:
        """The robot has put an object down."""
        item = self._objects[name]
        percept = item.percept and replace(
            item.percept, pose=replace(item.percept.pose, position=position), place=surface
        )
        self._objects[name] = replace(
            item,
            percept=percept,
            surface=surface,
            position=position,
            held_by="",
            confidence=confidence,
            seen=self._clock.now(),
            displaced=surface != item.home.surface,
        )
        self.publish()

    def reconcile(self, holding: Mapping[Arm, str], surface: str, position: Point | None) -> None:
        """After an interruption: what the grippers hold is as the robot says.

        Args:
            holding: What the robot says.
            surface: Where something was just being put down, "" when nothing was.
            position: Where on it [m, map frame].
        """
        for arm, name in holding.items():
            item = self._objects.get(name)
            if item and item.held_by != arm:
                self.taken(name, arm)
        for arm, item in self.held().items():
            if holding.get(arm) != item.name:
                if surface and position:
                    self.put(item.name, surface, position, confidence=EXPECTED)
                else:
                    self.vanished(item.name)

    def _see(self, percept: Percept) -> Individual:
        known = self._objects.get(percept.name) or self._expected_as(percept)
        if known and known.held_by:
            return known
        surface = self._surface_of(percept)
        home = Home(surface, percept.pose.position)
        if known is None:
            known = Individual(
                name=percept.name,
                type=percept.type,
                color=percept.color,
                size=percept.size,
                surface=surface,
                home=home,
            )
        elif known.name != percept.name:
            del self._objects[known.name]
        # What somebody else has moved belongs where it is found.
        displaced = known.displaced and (not known.surface or surface in {known.surface, ""})
        seen = replace(
            known,
            name=percept.name,
            surface=surface,
            position=percept.pose.position,
            confidence=percept.confidence,
            seen=self._clock.now(),
            displaced=displaced,
            home=known.home if displaced or not surface else home,
            percept=percept,
        )
        self._objects[percept.name] = seen
        return seen

    def _expected_as(self, percept: Percept) -> Individual | None:
        """The expected object that a percept with a name of its own may be."""
        alike = (
            item
            for item in self._objects.values()
            if item.seen is None and (item.type, item.color, item.size) == (percept.type, percept.color, percept.size)
        )
        return next(alike, None)

    def _surface_of(self, percept: Percept) -> str:
        return percept.place if percept.place in self._surfaces else ""


def _gone(item: Individual) -> Individual:
    # What fell from the gripper or was taken from it still belongs where the robot found it.
    displaced = item.displaced or bool(item.held_by)
    return replace(item, surface="", position=None, held_by="", confidence=VANISHED, displaced=displaced)
