"""The kitchen of the robot without physics: things that are points on surfaces."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from attune.core.messages import ObjectSpec, Size
from attune.core.scene import Scene, Surface
from attune.robots.interface import Arm, Point, UnknownTarget
from attune.robots.simulated import TrueObject

CLEARANCE = 0.3
"""From the base's centre to the edge of any surface [m]."""
OVERLAP = 0.05
"""Two objects whose middles are nearer than this overlap: this world knows no shapes [m]."""
SPACING = 0.15
"""Between the free spots that are looked for [m]."""


@dataclass(frozen=True, slots=True)
class Thing:
    """What is really true of an object.

    Attributes:
        position: Of its bottom centre, in the map frame [m]; where the gripper took it while it is held.
        surface: Name of the surface it stands on; "" while held, and on the floor.
        held_by: The arm that holds it, or "".
    """

    name: str
    type: str
    color: str
    size: Size
    position: Point
    surface: str
    held_by: Literal["", "left", "right"] = ""


class SymbolicWorld:
    """What is true, and everything that changes it.

    Args:
        scene: The kitchen.

    Attributes:
        things: The objects by name.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.things: dict[str, Thing] = {}
        for item in scene.objects:
            x, y, z, _ = scene.starts[item.name]
            position = _moved((x, y, z), scene.surface(item.at).shift)
            self.things[item.name] = Thing(item.name, item.type, item.color, item.size, position, item.at)

    def true_objects(self) -> Mapping[str, TrueObject]:
        """All objects of the world by name."""
        return {
            thing.name: TrueObject(
                ObjectSpec(
                    type=thing.type,
                    color=thing.color,
                    size=thing.size,
                    location=self.surface(thing.surface).place if thing.surface else "",
                    name=thing.name,
                ),
                thing.surface,
                thing.position,
                thing.held_by or None,
            )
            for thing in self.things.values()
        }

    def add_object(self, name: str, type_: str, color: str, size: Size, surface: str) -> None:
        """Put a new object of a known type on a free spot of a surface."""
        spot = self._free_spot(self.surface(surface))
        self.things[name] = Thing(name, type_, color, size, spot, surface)

    def move_object(self, name: str, surface: str) -> None:
        """Move an object, also out of the gripper, to a free spot of a surface."""
        self._put(name, self._free_spot(self.surface(surface)), surface)

    def remove_object(self, name: str) -> None:
        """Take an object, also out of the gripper, away for good."""
        del self.things[name]

    def holding(self) -> dict[Arm, str]:
        """What each arm holds."""
        return {thing.held_by: thing.name for thing in tuple(self.things.values()) if thing.held_by}

    def surface(self, name: str) -> Surface:
        """The surface of this name. Raises `UnknownTarget`."""
        known = {surface.name: surface for surface in self._scene.surfaces}
        if name not in known:
            raise UnknownTarget("surface", name, tuple(known))
        return known[name]

    def container(self, name: str) -> Surface:
        """The surface in a container. Raises `UnknownTarget`."""
        known = {surface.container: surface for surface in self._scene.surfaces if surface.container}
        if name not in known:
            raise UnknownTarget("container", name, tuple(known))
        return known[name]

    def is_free(self, x: float, y: float) -> bool:
        """Whether the base can stand there [m]."""
        inside = 0.0 < x < self._scene.room[0] and 0.0 < y < self._scene.room[1]
        return inside and all(_distance_outside(surface, x, y) >= CLEARANCE for surface in self._scene.surfaces)

    def surface_at(self, point: Point) -> Surface | None:
        """The surface on which a point is."""
        over = (
            surface
            for surface in self._scene.surfaces
            if _distance_outside(surface, point[0] - surface.shift[0], point[1] - surface.shift[1]) <= 0
            and abs(surface.center[2] - point[2]) < 0.05
        )
        return next(over, None)

    def blocker(self, point: Point) -> str | None:
        """What stands where something else is to be put."""
        standing = (thing for thing in self.things.values() if not thing.held_by)
        return next((thing.name for thing in standing if math.dist(thing.position, point) < OVERLAP), None)

    def _free_spot(self, surface: Surface) -> Point:
        for point in _spots(surface):
            if self.blocker(point) is None:
                return point
        return middle(surface)

    def put_down(self, name: str, position: Point, *, beside: bool) -> None:
        """Put something down, or `beside` the wanted spot; where no surface is, it falls to the floor."""
        surface = self.surface_at(position)
        if surface and beside:
            position = self._free_spot(surface)
        self._put(name, position if surface else (*position[:2], 0.0), surface.name if surface else "")

    def _put(self, name: str, position: Point, surface: str) -> None:
        self.things[name] = replace(self.things[name], position=position, surface=surface, held_by="")


def _moved(point: Point, shift: Point) -> Point:
    return (point[0] + shift[0], point[1] + shift[1], point[2] + shift[2])


def middle(surface: Surface) -> Point:
    """The middle of a surface as it is used: a drawer's when it is open."""
    return _moved(surface.center, surface.shift)


def _distance_outside(surface: Surface, x: float, y: float) -> float:
    """How far a point of the floor plan is from a surface's rectangle; negative inside [m]."""
    own_x, own_y = surface.from_map(x, y)
    along, across = abs(own_x) - surface.size[0] / 2, abs(own_y) - surface.size[1] / 2
    return math.hypot(max(along, 0.0), max(across, 0.0)) or max(along, across)


def _spots(surface: Surface) -> Iterable[Point]:
    """A grid of points on a surface as it is used, map frame."""
    columns, rows = (max(1, int(length / SPACING)) for length in surface.size)
    for column in range(columns):
        for row in range(rows):
            along = ((column + 0.5) / columns - 0.5) * surface.size[0]
            across = ((row + 0.5) / rows - 0.5) * surface.size[1]
            yield _moved(surface.to_map(along, across), surface.shift)
