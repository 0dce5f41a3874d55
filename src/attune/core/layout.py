"""Where the things of a scene are, and whether they can be there: pure geometry on rectangles seen from above."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import cos, hypot, isfinite, sin
from typing import TYPE_CHECKING

from attune.core.shapes import COLORS, clearance_needed

if TYPE_CHECKING:
    from attune.core.furniture import Counter as CounterTop
    from attune.core.furniture import Furniture, Surface
    from attune.core.scene import Scene, SceneObject
    from attune.core.shapes import Shape

HIGHEST = 1.3
"""Highest surface that a PR2 can use [m]."""
LOWEST = 0.3
"""Lowest surface that a PR2 can use [m]."""
GAP = 0.01
"""Least distance between two objects' outlines [m]."""
SPACING = 0.06
"""Distance between the outlines of objects that are put wherever there is room [m]."""
ROBOT_RADIUS = 0.48
"""Of the circle in which the robot can turn on the spot [m]."""

_TOLERANCE = 1e-3

Pose = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class _Rectangle:
    x: float
    y: float
    half: tuple[float, float]
    yaw: float

    @property
    def axes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        return (cos(self.yaw), sin(self.yaw)), (-sin(self.yaw), cos(self.yaw))

    def reach(self, axis: tuple[float, float]) -> float:
        """Half of its extent along a unit vector."""
        return sum(
            half * abs(axis[0] * own[0] + axis[1] * own[1]) for half, own in zip(self.half, self.axes, strict=True)
        )

    def apart(self, other: _Rectangle) -> float:
        """Widest gap between the two along any of their sides' directions; negative when they overlap."""
        return max(
            abs((other.x - self.x) * axis[0] + (other.y - self.y) * axis[1]) - self.reach(axis) - other.reach(axis)
            for axis in (*self.axes, *other.axes)
        )


def lay_out(scene: Scene) -> Mapping[str, Pose]:
    """The start pose of each object that fits: x, y, z of its bottom centre and yaw, map frame.

    Objects without a position take the first spot with room around it, front to back from the surface's middle.
    """
    surfaces = {surface.name: surface for surface in scene.surfaces}
    poses: dict[str, Pose] = {}
    taken: dict[str, list[_Rectangle]] = {name: [] for name in surfaces}
    placed_first = sorted(scene.objects, key=lambda thing: thing.position is None)
    for thing in placed_first:
        surface = surfaces[thing.at]
        extent = scene.all_types[thing.type].sizes[thing.size].extent
        half = (extent[0] / 2, extent[1] / 2)
        spots = iter([thing.position]) if thing.position else _spots(surface)
        for x, y in spots:
            outline = _Rectangle(x, y, half, thing.yaw)
            free = all(outline.apart(other) >= SPACING for other in taken[thing.at])
            if thing.position or (free and _inside(outline, surface)):
                taken[thing.at].append(outline)
                poses[thing.name] = (*surface.to_map(x, y), surface.yaw + thing.yaw)
                break
    return poses


def layout_problems(scene: Scene) -> list[str]:
    """What is impossible in a scene, in words that name the entry; empty when all is well."""
    problems = _naming_problems(scene) + _furniture_problems(scene) + _start_problems(scene)
    for thing in scene.objects:
        problems += _object_problems(scene, thing)
    # Positions are compared only when every object has a shape and a surface.
    return problems or _position_problems(scene)


def unfit(surface: Surface, shape: Shape) -> str:
    """Why an object of this shape can be neither taken from nor put on a surface; "" if it can.

    A clause that goes on from the surface's name, with a slot for the type's.
    """
    needed = clearance_needed(shape)
    if needed > surface.clearance:
        why = "which can only be taken from above" if needed > 1 else f"which needs {needed:.2f} m"
        return f"has {surface.clearance:.2f} m of room above it, too low for a {{}}, {why}"
    if shape.extent[2] > surface.headroom:
        return f"does not close over what is higher than {surface.headroom:.2f} m, as a {{}} of {shape.extent[2]:.2f} m"
    if isfinite(surface.headroom) and set(shape.grasps) == {"side"}:
        return "has walls, too high for a {}, which can only be taken from the side"
    if max(shape.extent[:2]) > min(surface.size) and shape.extent[0] == shape.extent[1]:
        return f"is {min(surface.size):.2f} m deep, too little for a {{}} of {shape.extent[0]:.2f} m"
    return ""


def _naming_problems(scene: Scene) -> list[str]:
    names = [piece.name for piece in scene.furniture] + [thing.name for thing in scene.objects]
    names += [drawer.name for piece in scene.furniture if piece.kind == "counter" for drawer in piece.drawers]
    return [f"name {name!r} is used {count} times" for name, count in Counter(names).items() if count > 1]


def _object_problems(scene: Scene, thing: SceneObject) -> list[str]:
    who = f"object {thing.name!r}"
    problems = []
    surfaces = {surface.name: surface for surface in scene.surfaces}
    if thing.at not in surfaces:
        problems.append(f"{who}: at: there is no surface {thing.at!r}; allowed: {', '.join(surfaces) or 'none yet'}")
    if thing.color not in COLORS:
        problems.append(f"{who}: color: {thing.color!r} is not known; allowed: {', '.join(COLORS)}")
    if thing.type not in scene.all_types:
        allowed = ", ".join(scene.all_types)
        return [*problems, f"{who}: type: {thing.type!r} is not known; allowed: {allowed} (add more as [types.NAME])"]
    sizes = scene.all_types[thing.type].sizes
    if thing.size not in sizes:
        return [*problems, f"{who}: size: a {thing.type} cannot be {thing.size!r}; allowed: {', '.join(sizes)}"]
    if thing.at in surfaces:
        why = unfit(surfaces[thing.at], scene.all_types[thing.type].shape(thing.size))
        if why:
            problems.append(f"{who}: at: {thing.at!r} {why.format(thing.type)}")
    return problems


def _position_problems(scene: Scene) -> list[str]:
    problems = []
    surfaces = {surface.name: surface for surface in scene.surfaces}
    poses = lay_out(scene)
    outlines: dict[str, tuple[SceneObject, _Rectangle]] = {}
    for thing in scene.objects:
        surface = surfaces[thing.at]
        if thing.name not in poses:
            problems.append(f"object {thing.name!r}: at: there is no room left on {thing.at!r}; remove an object there")
            continue
        extent = scene.all_types[thing.type].sizes[thing.size].extent
        x, y = surface.from_map(*poses[thing.name][:2])
        outline = _Rectangle(x, y, (extent[0] / 2, extent[1] / 2), thing.yaw)
        if not _inside(outline, surface):
            problems.append(
                f"object {thing.name!r}: position: {list(thing.position or ())} puts it over the edge of {thing.at!r}; "
                f"allowed: its {extent[0]:.2f} x {extent[1]:.2f} m within "
                f"+-{surface.size[0] / 2:.2f}, +-{surface.size[1] / 2:.2f}"
            )
        for other, taken in outlines.values():
            if other.at == thing.at and outline.apart(taken) < GAP:
                problems.append(
                    f"object {thing.name!r}: position: less than {GAP} m from {other.name!r} on {thing.at!r}"
                )
        outlines[thing.name] = (thing, outline)
    return problems


def _furniture_problems(scene: Scene) -> list[str]:
    problems = []
    for surface in scene.surfaces:
        if not LOWEST <= surface.center[2] <= HIGHEST:
            problems.append(
                f"furniture {surface.name!r}: its surface is {surface.center[2]:.2f} m high, which the robot cannot "
                f"reach; allowed: {LOWEST} to {HIGHEST}"
            )
        if min(surface.size) <= 0:
            problems.append(f"furniture {surface.name!r}: size: too small for a usable surface")
    outlines = {piece.name: _outline(piece) for piece in scene.furniture}
    for index, piece in enumerate(scene.furniture):
        rectangle = outlines[piece.name]
        for axis, limit, middle in (((1.0, 0.0), scene.room[0], rectangle.x), ((0.0, 1.0), scene.room[1], rectangle.y)):
            reach = rectangle.reach(axis)
            if middle - reach < -_TOLERANCE or middle + reach > limit + _TOLERANCE:
                problems.append(
                    f"furniture {piece.name!r}: position: it stands outside the room, which is {scene.room}"
                )
                break
        for other in scene.furniture[:index]:
            over = piece.bottom >= other.bottom + other.size[2] or other.bottom >= piece.bottom + piece.size[2]
            if not over and rectangle.apart(outlines[other.name]) < -_TOLERANCE:
                problems.append(f"furniture {piece.name!r}: position: it overlaps {other.name!r}")
        if piece.kind == "counter":
            problems += _drawer_problems(piece)
    return problems


def _start_problems(scene: Scene) -> list[str]:
    problems = []
    for key, (x, y), radius in (("robot_start", scene.robot_start[:2], ROBOT_RADIUS), ("user", scene.user, 0.0)):
        if not (radius <= x <= scene.room[0] - radius and radius <= y <= scene.room[1] - radius):
            problems.append(f"{key}: {x}, {y} is outside the room or too near to its walls; the room is {scene.room}")
        for piece in scene.furniture:
            if _distance(_outline(piece), x, y) < radius + 1e-9:
                problems.append(f"{key}: {x}, {y} is inside or within {radius} m of {piece.name!r}")
    return problems


def _drawer_problems(counter: CounterTop) -> list[str]:
    name = counter.name
    problems = []
    for index, drawer in enumerate(counter.drawers):
        if abs(drawer.x) + drawer.width / 2 > counter.size[0] / 2 - 0.02 or drawer.depth > counter.size[1] - 0.05:
            problems.append(f"furniture {name!r}: drawers: {drawer.name!r} is too wide or too deep for it")
        for other in counter.drawers[:index]:
            if abs(drawer.x - other.x) < (drawer.width + other.width) / 2 + 0.02:
                problems.append(f"furniture {name!r}: drawers: {drawer.name!r} overlaps {other.name!r}")
    return problems


def _outline(piece: Furniture) -> _Rectangle:
    return _Rectangle(*piece.position, (piece.size[0] / 2, piece.size[1] / 2), piece.yaw)


def _inside(outline: _Rectangle, surface: Surface) -> bool:
    return (
        abs(outline.x) + outline.reach((1.0, 0.0)) <= surface.size[0] / 2 + 1e-9
        and abs(outline.y) + outline.reach((0.0, 1.0)) <= surface.size[1] / 2 + 1e-9
    )


def _distance(outline: _Rectangle, x: float, y: float) -> float:
    along, across = outline.axes
    dx, dy = x - outline.x, y - outline.y
    return hypot(
        max(0.0, abs(dx * along[0] + dy * along[1]) - outline.half[0]),
        max(0.0, abs(dx * across[0] + dy * across[1]) - outline.half[1]),
    )


def _spots(surface: Surface) -> Iterator[tuple[float, float]]:
    columns, rows = int(surface.size[0] / 0.05), int(surface.size[1] / 0.05)
    for column in sorted(range(columns), key=lambda i: abs(2 * i - columns + 1)):
        for row in range(rows):
            yield (
                ((column + 0.5) / columns - 0.5) * surface.size[0],
                ((row + 0.5) / rows - 0.5) * surface.size[1],
            )
