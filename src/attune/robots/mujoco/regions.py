"""Which surface something rests on or in, as furniture really is: whole tops, and drawers where they are now."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin

from attune.core.scene import Scene, Surface
from attune.robots.interface import Point

_HIGHEST = 0.30
"""Highest that the middle of an object can be above what it rests on [m]."""


@dataclass(frozen=True, slots=True)
class _Region:
    surface: Surface
    center: tuple[float, float]
    half: tuple[float, float]
    travel: float

    def holds(self, point: Point, opened: float) -> bool:
        share = opened / self.travel if self.travel else 0.0
        dx = point[0] - self.center[0] - share * self.surface.shift[0]
        dy = point[1] - self.center[1] - share * self.surface.shift[1]
        along = dx * cos(self.surface.yaw) + dy * sin(self.surface.yaw)
        across = dy * cos(self.surface.yaw) - dx * sin(self.surface.yaw)
        over = point[2] - self.surface.center[2]
        return abs(along) <= self.half[0] and abs(across) <= self.half[1] and 0.0 <= over <= _HIGHEST


class Regions:
    """The spaces over the scene's surfaces."""

    def __init__(self, scene: Scene) -> None:
        travels = {box.name: box.opened for box in scene.containers if box.kind == "drawer"}
        self._regions = []
        for piece in scene.furniture:
            for surface in piece.surfaces:
                whole = surface.name == piece.name
                center = piece.position if whole else surface.center[:2]
                size = piece.size[:2] if whole else tuple(side + 0.04 for side in surface.size)
                half = (size[0] / 2, size[1] / 2)
                self._regions.append(_Region(surface, center, half, travels.get(surface.name, 0.0)))

    def at(self, point: Point, opened: Callable[[str], float]) -> str:
        """The surface under a point [m, map frame], the middle of an object; "" when there is none.

        Args:
            point: The middle of an object.
            opened: How far a container is open.
        """
        under = [
            region.surface
            for region in self._regions
            if region.holds(point, opened(region.surface.container) if region.travel else 0.0)
        ]
        return max(under, key=lambda surface: surface.center[2]).name if under else ""
