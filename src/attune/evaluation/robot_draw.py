"""Random fetch-and-place tasks: a fresh kitchen each time, with clutter where the object is and where it goes."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from pydantic import ValidationError

from attune.core.furniture import Surface
from attune.core.layout import unfit
from attune.core.scene import Scene, load_scene
from attune.core.shapes import COLORS, Shape

THING = "wanted_thing"
"""Name of the object to be fetched."""
APART = 0.05
"""Between two objects' outlines, for the fingers [m]."""
AT_MOST = 5
"""Objects of clutter on one open surface, at most; half of that inside a container."""
TRIES = 60
"""Random spots tried before a surface counts as full."""
BEFORE_SURFACE = 0.75
"""From a surface's front edge to the person who waits there [m]."""


@dataclass(frozen=True, slots=True)
class Draw:
    """One task.

    Attributes:
        source: Name of the surface the object is on.
        goal: Name of the surface it should be put on.
        why_not: Why it is not possible, "" if it is.
        scene: The kitchen, None when it is not possible.
    """

    number: int
    type: str
    size: str
    source: str
    goal: str
    why_not: str = ""
    scene: Scene | None = None

    @property
    def place(self) -> str:
        """The kind of place of the goal."""
        return _kitchen().surface(self.goal).place


@cache
def _kitchen() -> Scene:
    return load_scene()


def draws(seed: int) -> Iterator[Draw]:
    """Tasks without end: each type in turn, between each pair of surfaces in turn; all else is random."""
    number = 0
    while True:
        yield draw(seed, number)
        number += 1


def draw(seed: int, number: int) -> Draw:
    """The task of this number; the same seed and number give the same task."""
    rng = np.random.default_rng((seed, number))
    kitchen = _kitchen()
    types, surfaces = kitchen.vocabulary.types, kitchen.surfaces
    type_ = types[number % len(types)]
    # Each round of types goes on by one source, so that all pairs of type and source come in turn.
    source = surfaces[(number + number // len(types)) % len(surfaces)]
    goal = surfaces[int(rng.choice([index for index, surface in enumerate(surfaces) if surface != source]))]
    size = str(rng.choice(list(kitchen.all_types[type_].sizes)))
    shape = kitchen.all_types[type_].shape(size)  # type: ignore[arg-type]
    for surface in (source, goal):
        if why := unfit(surface, shape):
            return Draw(number, type_, size, source.name, goal.name, f"{surface.name} {why.format(type_)}")
    for _ in range(TRIES):
        try:
            scene = _fresh(kitchen, rng, (type_, size, shape), source, goal)
        except (ValidationError, _Full):
            continue
        return Draw(number, type_, size, source.name, goal.name, scene=scene)
    return Draw(number, type_, size, source.name, goal.name, f"{source.name} has no free spot for a {size} {type_}")


class _Full(Exception):
    """There is no room for the object."""


def _fresh(
    kitchen: Scene, rng: np.random.Generator, thing: tuple[str, str, Shape], source: Surface, goal: Surface
) -> Scene:
    """The kitchen with this object on its surface, and clutter there and at the goal."""
    taken: dict[str, list[tuple[float, float, float]]] = {source.name: [], goal.name: []}
    objects: list[dict[str, Any]] = []

    def put(name: str, type_: str, size: str, surface: Surface) -> bool:
        extent = kitchen.all_types[type_].shape(size).extent  # type: ignore[arg-type]
        radius = math.hypot(*extent[:2]) / 2
        half = np.maximum(0.0, np.array(surface.size) / 2 - radius)
        for _ in range(TRIES):
            x, y = (float(value) for value in rng.uniform(-half, half))
            if all(math.hypot(x - u, y - v) > radius + r + APART for u, v, r in taken[surface.name]):
                taken[surface.name].append((x, y, radius))
                yaw = float(rng.uniform(-math.pi, math.pi))
                color = str(rng.choice(list(COLORS)))
                objects.append(
                    {"name": name, "type": type_, "size": size, "color": color, "at": surface.name,
                     "position": (x, y), "yaw": yaw}
                )  # fmt: skip
                return True
        return False

    if not put(THING, thing[0], thing[1], source):
        raise _Full
    for surface in (source, goal):
        for index in range(int(rng.integers(0, (AT_MOST // 2 if surface.container else AT_MOST) + 1))):
            type_ = str(rng.choice(list(kitchen.all_types)))
            size = str(rng.choice(list(kitchen.all_types[type_].sizes)))
            if not unfit(surface, kitchen.all_types[type_].shape(size)):  # type: ignore[arg-type]
                put(f"{surface.name}_clutter_{index}", type_, size, surface)
    ahead = -goal.size[1] / 2 - BEFORE_SURFACE
    person = goal.to_map(float(rng.uniform(-0.4, 0.4)) * goal.size[0], ahead)[:2]
    return Scene.model_validate(kitchen.model_dump(exclude_unset=True) | {"objects": objects, "user": person})
