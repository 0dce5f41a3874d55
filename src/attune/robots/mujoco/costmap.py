"""Where the robot's body fits: a grid over the floor, in slabs of height.

Obstacles and robot are cut into the same slabs, so that hands carried above a table top do not keep the base away from
the table, while the base keeps away from its legs. A slab's map holds the distance to its nearest obstacle; the robot
fits where every point of its outline in every slab is farther away than the margin.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
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
_SLABS = tuple(zip(_HEIGHTS[:-1], _HEIGHTS[1:], strict=True))
_OPEN = 2.0
"""Distance where there is no obstacle [m]."""
_LARGE = 1 << 20
"""More than any number of centimetres."""
_FAR = 0.6
"""Border added around the obstacles so that the robot fits around them [m]."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """Sample points of the robot's outline in its base frame, grouped by the slabs that they lie in.

    Attributes:
        points: Of each group, shape (k, 2) [m].
        slabs: Of each group: numbers of the slabs.
    """

    points: tuple[Array, ...]
    slabs: tuple[tuple[int, ...], ...]

    @property
    def all_points(self) -> tuple[Array, NDArray[np.intp]]:
        """The points of all groups, shape (k, 2), and the group of each, shape (k,)."""
        counts = [len(points) for points in self.points]
        return np.concatenate(self.points), np.repeat(np.arange(len(counts), dtype=np.intp), counts)

    @property
    def radius(self) -> float:
        """Of the circle around the base's origin that holds all points [m]."""
        return max((float(np.linalg.norm(p, axis=1).max()) for p in self.points), default=0.0)


def footprint(robot: Sequence[Solid]) -> Footprint:
    """Sample the robot's solids (in the base frame), about one point per cell."""
    # The arms are in the same few postures again and again, to less than a tenth of a millimetre.
    filled = [_filled(np.round(solid.outline, 4).tobytes()) for solid in robot]
    here = [
        sum(1 << i for i, (low, high) in enumerate(_SLABS) if solid.low < high and solid.high > low) for solid in robot
    ]
    centimetres = np.round(100 * np.concatenate(filled)).astype(np.int64)
    points, index = np.unique(centimetres[:, 0] * _LARGE + centimetres[:, 1], return_inverse=True)
    slabs = np.zeros(len(points), dtype=np.int64)
    np.bitwise_or.at(slabs, index, np.repeat(here, [len(part) for part in filled]))
    across = (points + _LARGE // 2) % _LARGE - _LARGE // 2
    positions = np.column_stack(((points - across) // _LARGE, across)) / 100
    groups = [int(group) for group in np.unique(slabs) if group]
    return Footprint(
        tuple(positions[slabs == group] for group in groups),
        tuple(tuple(i for i in range(len(_SLABS)) if group >> i & 1) for group in groups),
    )


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
        cells = [self._inside(solid.outline) for solid in obstacles]
        self._distance = []
        for low, high in _SLABS:
            occupied = np.zeros(self.shape, dtype=bool)
            for solid, inside in zip(obstacles, cells, strict=True):
                if solid.low < high and solid.high > low:
                    occupied.flat[inside] = True
            self._distance.append(_distances(occupied.tobytes(), self.shape))
        # Maps of several slabs together, made when a robot needs them.
        self._together: dict[tuple[int, ...], Array] = {}
        self._stacks: dict[tuple[tuple[int, ...], ...], Array] = {}
        self._near: dict[tuple[tuple[int, ...], float, int], int] = {}

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
        if not body.points:
            return np.full(len(poses), _OPEN)
        points, group = body.all_points
        # In cells, so that truncation is the floor: the map begins at its origin, and what lies before it is clipped.
        # Single precision is exact to a hundredth of a millimetre here, and twice as fast.
        x, y = (points / RESOLUTION).T.astype(np.float32)
        cosine, sine = (turn(poses[:, 2])[:, None].astype(np.float32) for turn in (np.cos, np.sin))
        origin = ((poses[:, :2] - self.origin) / RESOLUTION).astype(np.float32)
        columns = (origin[:, 0, None] + cosine * x - sine * y).clip(0, self.shape[0] - 1).astype(np.int32)
        rows = (origin[:, 1, None] + sine * x + cosine * y).clip(0, self.shape[1] - 1).astype(np.int32)
        columns += (group * self.shape[0]).astype(np.int32)
        columns *= self.shape[1]
        columns += rows
        return cast("Array", self._stack(body.slabs).take(columns).min(axis=1))

    def _stack(self, groups: tuple[tuple[int, ...], ...]) -> Array:
        """Distance to the nearest obstacle of each group of slabs."""
        if groups not in self._stacks:
            self._stacks[groups] = np.stack([self._nearest(slabs) for slabs in groups])
        return self._stacks[groups]

    def _nearest(self, slabs: tuple[int, ...]) -> Array:
        if slabs not in self._together:
            self._together[slabs] = np.min([self._distance[slab] for slab in slabs], axis=0)
        return self._together[slabs]

    def free_at(self, yaw: float, body: Footprint, margin: float) -> Mask:
        """Cells on which the robot can stand at this yaw, shape of the map."""
        cosine, sine = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cosine, sine], [-sine, cosine]])
        # The map is one long number with a bit for each cell, row after row: shifting it shifts the map. Between the
        # rows there is room for the longest shift, so that none reaches another row.
        width = self.shape[1] + int(body.radius / RESOLUTION) + 2
        blocked = 0
        for slabs, points in zip(body.slabs, body.points, strict=True):
            near = self._bits(slabs, margin, width)
            if near:
                cells = np.round(points @ turn / RESOLUTION).astype(int)
                for shift in np.unique(cells[:, 0] * width + cells[:, 1]).tolist():
                    blocked |= near >> shift if shift >= 0 else near << -shift
        size = self.shape[0] * width
        bits = (blocked & ((1 << size) - 1)).to_bytes(size // 8 + 1, "little")
        free = np.unpackbits(np.frombuffer(bits, np.uint8), count=size, bitorder="little") == 0
        return cast("Mask", free.reshape(self.shape[0], width)[:, : self.shape[1]].copy())

    def _bits(self, slabs: tuple[int, ...], margin: float, width: int) -> int:
        """Which cells are within `margin` of an obstacle, as a number with so many bits for each row."""
        key = (slabs, margin, width)
        if key not in self._near:
            near = np.zeros((self.shape[0], width), dtype=bool)
            near[:, : self.shape[1]] = self._nearest(slabs) <= margin
            self._near[key] = int.from_bytes(np.packbits(near, bitorder="little").tobytes(), "little")
        return self._near[key]

    def free_turning(self, body: Footprint, margin: float) -> Mask:
        """Cells on which the robot can stand at every yaw, shape of the map."""
        free = np.ones(self.shape, dtype=bool)
        for points, slabs in zip(body.points, body.slabs, strict=True):
            free &= self._nearest(slabs) > np.linalg.norm(points, axis=1).max() + margin
        return free

    def nearness(self) -> Array:
        """1 at an obstacle, falling to 0 at half a metre from it, shape of the map: what a path should avoid."""
        return cast("Array", np.clip(1.0 - np.min(self._distance, axis=0) / 0.8, 0.0, 1.0))

    def _inside(self, outline: Array) -> NDArray[np.intp]:
        """Numbers of the cells that an outline covers."""
        origin = (float(self.origin[0]), float(self.origin[1]))
        return _covered(outline.tobytes(), origin, self.shape)


# Most furniture never moves, so its cells need not be found again for each map.
@lru_cache(maxsize=2048)
def _covered(outline: bytes, origin: tuple[float, float], shape: tuple[int, int]) -> NDArray[np.intp]:
    corners = np.frombuffer(outline).reshape(-1, 2)

    def cell(point: Array) -> NDArray[np.intp]:
        return np.clip(np.floor((point - origin) / RESOLUTION).astype(np.intp), 0, np.array(shape) - 1)

    low, high = cell(corners.min(axis=0) - RESOLUTION / 2), cell(corners.max(axis=0) + RESOLUTION / 2)
    grid = np.stack(np.meshgrid(*(np.arange(low[i], high[i] + 1) for i in (0, 1)), indexing="ij"), axis=-1)
    cells = grid.reshape(-1, 2)
    cells = cells[_inside(corners, origin + (cells + 0.5) * RESOLUTION, RESOLUTION / 2)]
    return cast("NDArray[np.intp]", cells[:, 0] * shape[1] + cells[:, 1])


@lru_cache(maxsize=256)
def _distances(occupied: bytes, shape: tuple[int, int]) -> Array:
    """Distance of each cell to the nearest occupied one [m]."""
    cells = np.frombuffer(occupied, dtype=bool).reshape(shape)
    if not cells.any():
        return np.full(shape, _OPEN)
    return cast("Array", distance_transform_edt(~cells) * RESOLUTION - RESOLUTION / 2)


def _inside(outline: Array, points: Array, margin: float) -> Mask:
    """Whether points (n, 2) lie in a convex outline grown by `margin`."""
    edge = np.roll(outline, -1, axis=0) - outline
    length = np.linalg.norm(edge, axis=1)
    edge, start = edge[length > 1e-9] / length[length > 1e-9, None], outline[length > 1e-9]
    offset = points[:, None, :] - start
    left = edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0]
    return cast("Mask", np.all(left >= -margin, axis=1))


@lru_cache(maxsize=1024)
def _filled(corners: bytes) -> Array:
    """Points on the border and inside of a convex outline, at most a cell apart."""
    outline = np.frombuffer(corners).reshape(-1, 2)
    edges = np.roll(outline, -1, axis=0) - outline
    counts = np.maximum(2, np.ceil(np.linalg.norm(edges, axis=1) / RESOLUTION).astype(int) + 1)
    edge = np.repeat(np.arange(len(edges)), counts)
    along = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    border = outline[edge] + (along / (counts[edge] - 1))[:, None] * edges[edge]
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(
        np.meshgrid(np.arange(low[0], high[0], RESOLUTION), np.arange(low[1], high[1], RESOLUTION)), axis=-1
    ).reshape(-1, 2)
    return np.concatenate((border, grid[_inside(outline, grid, 0.0)]))
