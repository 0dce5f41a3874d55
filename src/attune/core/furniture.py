"""Furniture: the pieces a kitchen can be made of, and the surfaces and compartments they bring.

A piece has its own frame: origin on the floor (or under it, for what hangs on a wall) in the middle of its footprint,
y pointing from its front to its back, z up; so with yaw 0 its front faces down the map, towards smaller y. Lengths in
metres, angles in radians.
"""

from dataclasses import dataclass
from math import cos, inf, sin
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, model_validator

Point = tuple[float, float, float]
Hinge = Literal["left", "right", "bottom"]
Material = Literal["wood", "white", "grey", "dark", "steel"]
Place = Literal["countertop", "table", "cabinet", "dishwasher", "drawer", "fridge", "shelf"]

TOP_THICKNESS = 0.04
"""Of counters' and tables' tops."""
BOARD = 0.02
"""Thickness of boards and doors."""
EDGE = 0.03
"""Strip along the edge of an open surface where nothing should stand."""
DRAWER_WALL = 0.01


@dataclass(frozen=True, slots=True)
class Surface:
    """An upright-facing rectangle that objects can stand on.

    Attributes:
        name: The furniture's or compartment's name.
        place: The kind of place people call it.
        center: Middle of its top in the map frame, its container closed [m].
        size: Extent along its own x (along the front) and y (front to back) [m].
        yaw: Of its own frame in the map [rad].
        container: Name of the container to open first, or "".
        shift: How far it moves when its container is opened as far as `Container.opened` says [m]; a drawer's does.
        clearance: Free height above it [m].
        headroom: What stands there must be lower, or its container does not close [m]; only a drawer has walls.
    """

    name: str
    place: str
    center: Point
    size: tuple[float, float]
    yaw: float
    container: str = ""
    shift: Point = (0.0, 0.0, 0.0)
    clearance: float = inf
    headroom: float = inf

    def to_map(self, x: float, y: float) -> Point:
        """A point of the surface, given in its own frame, in the map frame."""
        return (*_turned(self.center, self.yaw, x, y), self.center[2])

    def from_map(self, x: float, y: float) -> tuple[float, float]:
        """A point of the map's floor plan in the surface's own frame."""
        return _turned((0.0, 0.0, 0.0), -self.yaw, x - self.center[0], y - self.center[1])


@dataclass(frozen=True, slots=True)
class Container:
    """Something with a door or drawer.

    Attributes:
        name: Also that of the surface inside it.
        furniture: Name of the piece it is part of.
        place: The kind of place people call it.
        kind: `drawer` slides out, `door` turns.
        hinge: Where a door's hinge is, seen from the front; "" for a drawer.
        travel: How far it can move [m or rad].
        opened: How far it is opened for use [m or rad].
    """

    name: str
    furniture: str
    place: str
    kind: Literal["drawer", "door"]
    hinge: Hinge | Literal[""]
    travel: float
    opened: float


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Drawer(_Strict):
    """A drawer of a counter, right under its top."""

    name: str = Field(min_length=1)
    place: Place = "drawer"
    x: float
    """Middle, along the counter's front [m]."""
    width: float = Field(0.5, ge=0.25, le=1.0)
    height: float = Field(0.18, ge=0.1, le=0.3)
    """Of its front."""
    depth: float = Field(0.45, ge=0.3, le=0.6)
    travel: float = Field(0.40, ge=0.2, le=0.5)
    """How far it slides."""


class Sink(_Strict):
    """A sink at one end of a counter; nothing is put there."""

    side: Literal["left", "right"] = "right"
    width: float = Field(0.6, ge=0.3, le=1.2)


class _Piece(_Strict):
    name: str = Field(min_length=1)
    place: Place
    """The kind of place people call it."""
    position: tuple[float, float]
    """Middle of its footprint, map frame [m]."""
    yaw: float = 0.0
    size: tuple[PositiveFloat, PositiveFloat, PositiveFloat]
    """Along its front, front to back, and height [m]."""
    material: Material = "wood"

    @property
    def bottom(self) -> float:
        """Height of its underside above the floor [m]."""
        return 0.0

    @property
    def containers(self) -> tuple[Container, ...]:
        """Its doors and drawers."""
        return ()

    def _surface(self, name: str, place: str, middle: Point, size: tuple[float, float], **more: object) -> Surface:
        center = (*self.to_map(middle[0], middle[1]), middle[2])
        return Surface(name, place, center, size, self.yaw, **more)  # type: ignore[arg-type]

    def to_map(self, x: float, y: float) -> tuple[float, float]:
        """A point of the footprint, given in the piece's own frame, in the map frame."""
        return _turned((*self.position, 0.0), self.yaw, x, y)


class Counter(_Piece):
    """A block with a top; it may have drawers and a sink."""

    kind: Literal["counter"]
    drawers: tuple[Drawer, ...] = ()
    sink: Sink | None = None
    usable_depth: float = Field(inf, gt=0.1)
    """Depth from the front edge in which things are put; what is farther back cannot be reached [m]."""

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """Its top, and the inside of each drawer."""
        width, depth, height = self.size
        sink = self.sink.width if self.sink else 0.0
        middle = 0.0 if not self.sink else sink / 2 * (1 if self.sink.side == "left" else -1)
        usable = min(self.usable_depth, depth)
        top = self._surface(
            self.name,
            self.place,
            (middle, (usable - depth) / 2, height),
            (width - sink - 2 * EDGE, usable - 2 * EDGE),
        )
        inside = []
        for drawer in self.drawers:
            floor = height - TOP_THICKNESS - drawer.height + 2 * DRAWER_WALL
            inside.append(
                self._surface(
                    drawer.name,
                    drawer.place,
                    (drawer.x, (drawer.depth - depth) / 2, floor),
                    (drawer.width - 4 * DRAWER_WALL, drawer.depth - 4 * DRAWER_WALL),
                    container=drawer.name,
                    shift=(*_turned((0.0, 0.0, 0.0), self.yaw, 0.0, -drawer.travel), 0.0),
                    headroom=drawer.height - 2 * DRAWER_WALL,
                )
            )
        return top, *inside

    @property
    def containers(self) -> tuple[Container, ...]:
        """Its drawers."""
        return tuple(
            Container(drawer.name, self.name, drawer.place, "drawer", "", drawer.travel, drawer.travel)
            for drawer in self.drawers
        )


class Table(_Piece):
    """A top on four legs."""

    kind: Literal["table"]

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """Its top."""
        width, depth, height = self.size
        return (self._surface(self.name, self.place, (0, 0, height), (width - 2 * EDGE, depth - 2 * EDGE)),)


class Shelf(_Piece):
    """A low open shelf; things are put on its top."""

    kind: Literal["shelf"]

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """Its top."""
        width, depth, height = self.size
        return (self._surface(self.name, self.place, (0, 0, height), (width - 2 * EDGE, depth - 2 * EDGE)),)


class Cupboard(_Piece):
    """A box with one door and one board inside: a cabinet, a fridge, a dishwasher. `size` is that of the box."""

    kind: Literal["cupboard"]
    above_floor: float = Field(0.0, ge=0)
    """Height of its underside [m]."""
    board: float = Field(BOARD, ge=BOARD)
    """Height of the board that things stand on, above its underside [m]; below it the box is filled."""
    usable_depth: float = Field(0.36, gt=0.1)
    """Depth from the front in which things are put; what is farther back cannot be reached [m]."""
    hinge: Hinge = "left"
    """Where the door's hinge is, seen from the front."""
    travel: float = Field(1.9, gt=0.5, le=2.2)
    """How far the door turns [rad]."""
    opened: float = Field(1.4, gt=0.5, le=2.2)
    """How far it is opened for use [rad]."""

    @model_validator(mode="after")
    def _opens_far_enough(self) -> "Cupboard":
        if self.opened > self.travel:
            raise ValueError(f"opened: must not be more than travel, which is {self.travel}")
        return self

    @property
    def bottom(self) -> float:
        """Height of its underside above the floor [m]."""
        return self.above_floor

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """The board inside."""
        width, depth, height = self.size
        usable = min(self.usable_depth, depth - BOARD)
        inside = (width - 2 * BOARD - 0.02, usable - 0.02)
        middle = (0.0, (usable - depth) / 2, self.above_floor + self.board)
        clearance = height - self.board - BOARD
        return (self._surface(self.name, self.place, middle, inside, container=self.name, clearance=clearance),)

    @property
    def containers(self) -> tuple[Container, ...]:
        """Its door."""
        return (Container(self.name, self.name, self.place, "door", self.hinge, self.travel, self.opened),)


Furniture = Annotated[Counter | Table | Shelf | Cupboard, Field(discriminator="kind")]
KINDS: tuple[type[_Piece], ...] = (Counter, Table, Shelf, Cupboard)


def _turned(origin: Point, yaw: float, x: float, y: float) -> tuple[float, float]:
    return origin[0] + x * cos(yaw) - y * sin(yaw), origin[1] + x * sin(yaw) + y * cos(yaw)
