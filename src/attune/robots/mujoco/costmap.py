"""Where the robot's body fits: a grid over the floor, in slabs of height.

Obstacles and robot are cut into the same slabs, so that hands carried above a table top do not keep the base away from
the table, while the base keeps away from its legs. A slab's map holds the distance to its nearest obstacle; the robot
fits where every point of its outline in every slab is farther away than the margin.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from attune.robots.mujoco.solids import Solid

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

RESOLUTION = 0.05
"""Edge of a cell [m]."""
_HEIGHTS = (0.03, 0.34, 0.6, 0.73, 0.86, 0.95, 1.03, 1.12, 1.3, 1.8)
"""Borders of the slabs [m]."""
_OPEN = 2.0
"""Distance where there is no obstacle [m]."""
_FAR = 0.6
"""Border added around the obstacles so that the robot fits around them [m]."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """Sample points of the robot's outline in its base frame, for each slab, shape (k, 2) each."""

    points: tuple[Array, ...]

    @property
    def all_points(self) -> tuple[Array, NDArray[np.intp]]:
        """The points of all slabs, shape (k, 2), and the slab of each, shape (k,)."""
        counts = [len(points) for points in self.points]
        return np.concatenate(self.points), np.repeat(np.arange(len(counts), dtype=np.intp), counts)

    @property
    def radius(self) -> float:
        """Of the circle around the base's origin that holds all points [m]."""
        return max((float(np.linalg.norm(p, axis=1).max()) for p in self.points if len(p)), default=0.0)


def footprint(robot: Sequence[Solid]) -> Footprint:
    """Sample the robot's solids (in the base frame), about one point per cell."""
    filled = [(solid, _filled(solid.outline)) for solid in robot]
    slabs = []
    for low, high in zip(_HEIGHTS[:-1], _HEIGHTS[1:], strict=True):
        here = [points for solid, points in filled if solid.low < high and solid.high > low]
        points = np.concatenate(here) if here else np.zeros((0, 2))
        slabs.append(np.unique(np.round(points, 2), axis=0))
    return Footprint(tuple(slabs))


class Costmap:
    """The floor with its obstacles.

    Args:
        obstacles: Everything the robot must not drive into, in the map frame.
    """

    def __init__(self, obstacles: Sequence[Solid]) -> None:
        everything = np.concatenate([s.outline for s in obstacles])
        self.origin: Array = np.floor((everything.min(axis=0) - _FAR) / RESOLUTION) * RESOLUTION
        size = np.ceil((everything.max(axis=0) + _FAR - self.origin) / RESOLUTION).astype(int)
        self.shape = (int(size[0]), int(size[1]))
        self._distance = []
        for low, high in zip(_HEIGHTS[:-1], _HEIGHTS[1:], strict=True):
            occupied = np.zeros(self.shape, dtype=bool)
            for solid in obstacles:
                if solid.low < high and solid.high > low:
                    self._fill(occupied, solid.outline)
            if occupied.any():
                self._distance.append(distance_transform_edt(~occupied) * RESOLUTION - RESOLUTION / 2)
            else:
                self._distance.append(np.full(self.shape, _OPEN))
        self._all_distances: Array = np.stack(self._distance)

    def cell(self, points: Array) -> NDArray[np.intp]:
        """Cells of points (..., 2), clipped to the map."""
        cells = np.floor((points - self.origin) / RESOLUTION).astype(np.intp)
        return cast("NDArray[np.intp]", np.clip(cells, 0, np.array(self.shape) - 1))

    def centre(self, cells: NDArray[np.intp]) -> Array:
        """Centres of cells (..., 2) in the map frame [m]."""
        return cast("Array", self.origin + (cells + 0.5) * RESOLUTION)

    def clearance(self, poses: Array, body: Footprint) -> Array:
        """Distance from the robot's outline to the nearest obstacle at base poses (n, 3) [m], shape (n,).

        Exact to about half a cell.
        """
        points, slab = body.all_points
        if not len(points):
            return np.full(len(poses), _OPEN)
        # In cells, so that truncation is the floor: the map begins at its origin, and what lies before it is clipped.
        # Single precision is exact to a hundredth of a millimetre here, and twice as fast.
        x, y = (points / RESOLUTION).T.astype(np.float32)
        cosine, sine = (turn(poses[:, 2])[:, None].astype(np.float32) for turn in (np.cos, np.sin))
        origin = ((poses[:, :2] - self.origin) / RESOLUTION).astype(np.float32)
        columns = (origin[:, 0, None] + cosine * x - sine * y).clip(0, self.shape[0] - 1).astype(np.int32)
        rows = (origin[:, 1, None] + sine * x + cosine * y).clip(0, self.shape[1] - 1).astype(np.int32)
        columns += (slab * self.shape[0]).astype(np.int32)
        columns *= self.shape[1]
        columns += rows
        return cast("Array", self._all_distances.take(columns).min(axis=1))

    def free_at(self, yaw: float, body: Footprint, margin: float) -> Mask:
        """Cells on which the robot can stand at this yaw, shape of the map."""
        cosine, sine = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cosine, sine], [-sine, cosine]])
        free = np.ones(self.shape, dtype=bool)
        for points, distance in zip(body.points, self._distance, strict=True):
            near = distance <= margin
            if not near.any() or not len(points):
                continue
            shifts = np.unique(np.round(points @ turn / RESOLUTION).astype(int), axis=0)
            reach = int(np.abs(shifts).max())
            padded = np.pad(near, reach, constant_values=False)
            for i, j in shifts:
                free &= ~padded[reach + i : reach + i + self.shape[0], reach + j : reach + j + self.shape[1]]
        return free

    def free_turning(self, body: Footprint, margin: float) -> Mask:
        """Cells on which the robot can stand at every yaw, shape of the map."""
        free = np.ones(self.shape, dtype=bool)
        for points, distance in zip(body.points, self._distance, strict=True):
            if len(points):
                free &= distance > np.linalg.norm(points, axis=1).max() + margin
        return free

    def nearness(self) -> Array:
        """1 at an obstacle, falling to 0 at half a metre from it, shape of the map: what a path should avoid."""
        return cast("Array", np.clip(1.0 - np.min(self._distance, axis=0) / 0.8, 0.0, 1.0))

    def _fill(self, occupied: Mask, outline: Array) -> None:
        low = self.cell(outline.min(axis=0) - RESOLUTION / 2)
        high = self.cell(outline.max(axis=0) + RESOLUTION / 2)
        grid = np.stack(
            np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij"), axis=-1
        )
        inside = _inside(outline, self.centre(grid).reshape(-1, 2), RESOLUTION / 2)
        cells = grid.reshape(-1, 2)[inside]
        occupied[cells[:, 0], cells[:, 1]] = True


def _inside(outline: Array, points: Array, margin: float) -> Mask:
    """Whether points (n, 2) lie in a convex outline grown by `margin`."""
    edge = np.roll(outline, -1, axis=0) - outline
    length = np.linalg.norm(edge, axis=1)
    edge, start = edge[length > 1e-9] / length[length > 1e-9, None], outline[length > 1e-9]
    offset = points[:, None, :] - start
    left = edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0]
    return cast("Mask", np.all(left >= -margin, axis=1))


def _filled(outline: Array) -> Array:
    """Points on the border and inside of a convex outline, at most a cell apart."""
    following = np.roll(outline, -1, axis=0)
    border = [
        np.linspace(a, b, max(2, int(np.ceil(np.linalg.norm(b - a) / RESOLUTION)) + 1))
        for a, b in zip(outline, following, strict=True)
    ]
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(
        np.meshgrid(np.arange(low[0], high[0], RESOLUTION), np.arange(low[1], high[1], RESOLUTION)), axis=-1
    ).reshape(-1, 2)
    return np.concatenate((*border, grid[_inside(outline, grid, 0.0)]))
