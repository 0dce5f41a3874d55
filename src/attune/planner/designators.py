"""Designators: descriptions of objects and places that are resolved to real ones when they are needed.

No pose is written down for any object: everything is computed from the scene's surfaces, from what is believed, and
by asking the robot for base poses.
"""

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from attune.core.layout import unfit
from attune.core.messages import ObjectSpec
from attune.core.scene import Scene, Surface
from attune.planner.belief import DEFAULT_EXTENT, VANISHED, Belief, Individual
from attune.robots.interface import Point

EDGE = 0.1
"""From the middle of a thing that is put down to the edge of the surface, at least [m]."""
MARGIN = 0.02
"""From the outline of a thing that is put down to the edge of the surface, at least [m]."""
GRID = 0.06
"""Between two candidate spots [m]."""
GAP = 0.05
"""Between the footprints of two objects, for the fingers [m]."""

UPRIGHT = 0.94
"""Least upward part of the axis of what stands."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A free spot on a surface; `position` in the map frame [m]. In a `tight` one neighbours or the edge are close."""

    surface: Surface
    position: Point
    tight: bool = False


def candidates(belief: Belief, spec: ObjectSpec, excluded: Collection[str] = ()) -> tuple[Individual, ...]:
    """The objects that a description may mean, likeliest first.

    What was seen goes before what is only expected, what stands where it belongs before what was brought somewhere,
    and the normal size before others when none was asked for.
    """
    fitting = [
        item
        for item in belief.objects
        if item.is_a(spec)
        and item.name not in excluded
        and (not spec.location or item.confidence <= VANISHED or belief.place_of(item) == spec.location)
    ]
    return tuple(
        sorted(fitting, key=lambda item: (item.confidence <= VANISHED, item.displaced, item.size not in {"normal", ""}))
    )


def alternative(belief: Belief, spec: ObjectSpec, excluded: Collection[str] = ()) -> ObjectSpec | None:
    """The nearest thing that exists: the same type with as many of the wanted properties as possible, or None."""
    alike = [
        item
        for item in belief.objects
        if item.type == spec.type and item.confidence > VANISHED and item.name not in excluded and not item.held_by
    ]
    if not alike:
        return None
    best = min(
        alike,
        key=lambda item: (bool(spec.color) and item.color != spec.color, bool(spec.size) and item.size != spec.size),
    )
    return belief.describe(best)


def delivery_surfaces(scene: Scene, place: str, item: Individual | None = None) -> tuple[Surface, ...]:
    """The surfaces of a kind of place on which an object can be, nearest to the user first."""
    fitting = (surface for surface in scene.surfaces_at(place) if item is None or fits(scene, item, surface))
    return tuple(sorted(fitting, key=lambda surface: _distance_to(surface, scene.user)))


def fits(scene: Scene, item: Individual, surface: Surface) -> bool:
    """Whether an object of this type and size can be put there at all."""
    sizes = scene.all_types[item.type].sizes if item.type in scene.all_types else {}
    size = next((known for known in sizes if known == (item.size or "normal")), None)
    return size is None or not unfit(surface, scene.all_types[item.type].shape(size))


def is_delivered(scene: Scene, item: Individual, place: str) -> bool:
    """Whether an object stands where a delivery to this kind of place would put it, or has put it."""
    surfaces = delivery_surfaces(scene, place, item)
    if item.confidence <= VANISHED or item.held_by or not surfaces:
        return False
    brought = item.displaced and item.surface in {surface.name for surface in surfaces}
    return brought or item.surface == surfaces[0].name


def stands(item: Individual) -> bool:
    """Whether an object was seen upright, within about 20 degrees, when it was last seen."""
    if item.percept is None:
        return False
    _, x, y, _ = item.percept.pose.orientation
    return 1 - 2 * (x * x + y * y) > UPRIGHT


def search_order(scene: Scene, belief: Belief, spec: ObjectSpec, excluded: Collection[str]) -> tuple[Surface, ...]:
    """The surfaces on which an object may be: where it is believed, where its like belongs, then all others."""
    believed = [item.surface for item in candidates(belief, spec, excluded)]
    alike = [item.home.surface for item in belief.objects if item.type == spec.type]
    if spec.location:
        order = [surface.name for surface in scene.surfaces_at(spec.location)]
    else:
        # What stands open is quicker to look over than what must be opened.
        rest = sorted(scene.surfaces, key=lambda surface: bool(surface.container))
        order = [*believed, *alike, *(surface.name for surface in rest)]
    return tuple(scene.surface(name) for name in dict.fromkeys(order) if name)


def free_spots(scene: Scene, belief: Belief, place: str, item: Individual | None = None) -> Iterator[Spot]:
    """Free spots for an object at a kind of place, nearest to the user first.

    After those that are free however things are turned come those where it may fit if it is turned well or that are
    near the edge, the one with the most room first; after all these, under a board, those behind something else, for
    there the hand comes from the front.
    """
    surfaces = delivery_surfaces(scene, place, item)
    behind: list[Spot] = []

    def in_front(spots: Iterable[Spot]) -> Iterator[Spot]:
        for spot in spots:
            if math.isfinite(spot.surface.clearance) and _is_behind_something(belief, spot, item):
                behind.append(spot)
            else:
                yield spot

    for surface in surfaces:
        near = sorted(_grid(surface, item), key=lambda point: math.dist(point[:2], scene.user))
        yield from in_front(Spot(surface, point) for point in near if _is_free(belief, surface, point, item))
    if item is not None:
        between = [
            Spot(surface, point, tight=True) for surface in surfaces for point in _grid(surface, item, fine=True)
        ]
        clear = [spot for spot in between if is_clear(belief, spot, item)]
        yield from in_front(sorted(clear, key=lambda spot: -_clearance(belief, spot)))
    yield from behind


def home_spots(scene: Scene, belief: Belief, item: Individual) -> Iterator[Spot]:
    """Free spots to return an object to: where it stood, else near that, else anywhere on a surface like it."""
    open_surfaces = [surface for surface in scene.surfaces if not surface.container and fits(scene, item, surface)]
    surface = scene.surface(item.home.surface) if item.home.surface else open_surfaces[0]
    origin = item.home.position or middle(surface)
    if item.home.position and is_clear(belief, Spot(surface, origin), item):
        yield Spot(surface, origin)
    others = [other for other in delivery_surfaces(scene, surface.place, item) if other.name != surface.name]
    elsewhere = [other for other in open_surfaces if other not in (surface, *others)]
    for option in (surface, *others, *elsewhere):
        near = sorted(_grid(option, item), key=lambda point: math.dist(point, origin))
        yield from (Spot(option, point) for point in near if _is_free(belief, option, point, item))


def spots_on(belief: Belief, surface: Surface, item: Individual) -> Iterator[Spot]:
    """Spots of one surface that are free for an object however things are turned."""
    return (Spot(surface, point) for point in _grid(surface, item) if _is_free(belief, surface, point, item))


def is_clear(belief: Belief, spot: Spot, item: Individual) -> bool:
    """Whether nothing stands in a spot that was chosen, or where the object stood before; neighbours may be close."""
    return all(
        other.position is None
        or other.name == item.name
        or math.dist(other.position[:2], spot.position[:2]) >= (min(item.extent[:2]) + min(other.extent[:2])) / 2 + 0.02
        for other in belief.on(spot.surface.name)
    )


def is_crowded(belief: Belief, spot: Spot, item: Individual) -> bool:
    """Whether neighbours are close to a chosen spot while there is more room elsewhere on its surface."""
    return not _is_free(belief, spot.surface, spot.position, item) and any(
        _is_free(belief, spot.surface, point, item) for point in _grid(spot.surface, item)
    )


def middle(surface: Surface) -> Point:
    """The middle of a surface as it is used, map frame [m]."""
    return _on(surface, 0.0, 0.0)


def look_points(surface: Surface) -> tuple[Point, ...]:
    """Points that together let the camera see a whole surface, map frame [m]."""
    count = max(1, math.ceil(surface.size[0] / 0.8))
    return tuple(_on(surface, ((index + 0.5) / count - 0.5) * surface.size[0], 0.0) for index in range(count))


def _grid(surface: Surface, item: Individual | None = None, *, fine: bool = False) -> Iterator[Point]:
    """Points of a surface on which an object, however it is turned, does not stand over the edge or in a wall."""
    needed = radius(item.extent) + MARGIN if item else 0.0
    if fine:
        return points_on(surface, GRID / 2, needed)
    return points_on(surface, GRID, max(EDGE, needed))


def points_on(surface: Surface, spacing: float, edge: float) -> Iterator[Point]:
    """Points of a surface as it is used, so far apart and from its edge at least, map frame [m]."""
    for along in steps(surface.size[0], spacing, edge):
        for across in steps(surface.size[1], spacing, edge):
            yield _on(surface, along, across)


def steps(length: float, spacing: float, edge: float) -> tuple[float, ...]:
    """Places along a length, so far apart, as far as `edge` from its ends, the middle being 0 [m]."""
    half = max(0.0, length / 2 - edge)
    count = int(2 * half / spacing) + 1
    return tuple((index - (count - 1) / 2) * spacing for index in range(count))


def _on(surface: Surface, along: float, across: float) -> Point:
    """A point of a surface as it is used (a drawer's when it is open), map frame."""
    x, y, z = surface.to_map(along, across)
    return (x + surface.shift[0], y + surface.shift[1], z + surface.shift[2])


def _is_free(belief: Belief, surface: Surface, point: Point, item: Individual | None) -> bool:
    """Whether an object fits there, however it and its neighbours are turned."""
    own = radius(item.extent if item else DEFAULT_EXTENT)
    return all(
        other.position is None
        or (item is not None and other.name == item.name)
        or math.dist(other.position[:2], point[:2]) >= own + radius(other.extent) + GAP
        for other in belief.on(surface.name)
    )


def _is_behind_something(belief: Belief, spot: Spot, item: Individual | None) -> bool:
    """Whether something stands between a spot and the front of its surface."""
    x, y = spot.surface.from_map(*spot.position[:2])
    own = radius(item.extent if item else DEFAULT_EXTENT)
    for other in belief.on(spot.surface.name):
        if other.position is not None and (item is None or other.name != item.name):
            aside, before = spot.surface.from_map(*other.position[:2])
            if before < y and abs(aside - x) < own + radius(other.extent) + MARGIN:
                return True
    return False


def _clearance(belief: Belief, spot: Spot) -> float:
    """From a spot to the nearest neighbour's outline, however that is turned [m]."""
    return min(
        (
            math.dist(other.position[:2], spot.position[:2]) - radius(other.extent)
            for other in belief.on(spot.surface.name)
            if other.position is not None
        ),
        default=math.inf,
    )


def radius(extent: Point) -> float:
    """Of what stands somewhere, however it is turned [m]; roughly."""
    return max(extent[0], extent[1]) / 2


def _distance_to(surface: Surface, user: tuple[float, float]) -> float:
    x, y = surface.from_map(*user)
    return math.hypot(max(0.0, abs(x) - surface.size[0] / 2), max(0.0, abs(y) - surface.size[1] / 2))
