"""Geoms as upright prisms: their outline from above and their range of heights."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]

_CIRCLE = np.stack((np.cos(np.arange(12) * np.pi / 6), np.sin(np.arange(12) * np.pi / 6)), axis=1) / np.cos(np.pi / 12)

_SIGNS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T


@dataclass(frozen=True, slots=True)
class Solid:
    """A convex thing seen from above.

    Attributes:
        outline: Corners of its outline, counter-clockwise, shape (k, 2) [m].
        low, high: Its range of heights [m].
    """

    outline: Array
    low: float
    high: float


def hull(points: Array) -> Array:
    """The convex hull of points in the plane, counter-clockwise, shape (k, 2)."""
    return _hull(np.ascontiguousarray(points).tobytes())


# Most furniture never moves.
@lru_cache(maxsize=2048)
def _hull(points: bytes) -> Array:
    flat = np.frombuffer(points).reshape(-1, 2)
    return np.ascontiguousarray(flat[ConvexHull(flat, qhull_options="QJ").vertices])


def corners(model: Any, geom: int) -> Array:
    """Points whose convex hull encloses a geom, in the geom's frame, shape (k, 3)."""
    size = model.geom_size[geom]
    kind = model.geom_type[geom]
    if kind in (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE):
        half = size[1] + (size[0] if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0)
        ring = _CIRCLE * size[0]
        return np.concatenate([np.column_stack((ring, np.full(len(ring), z))) for z in (-half, half)])
    box = model.geom_aabb[geom]
    return np.asarray(box[:3] + _SIGNS * box[3:])


def solids(
    model: Any, data: Any, geoms: Iterable[int], origin: tuple[float, float, float] | None = None
) -> list[Solid]:
    """The geoms as solids.

    Args:
        model: The MuJoCo model.
        data: Its state, with geom poses computed.
        geoms: Ids; planes are left out.
        origin: x, y, yaw of the frame the outlines are wanted in; None takes the map frame.
    """
    x, y, yaw = origin or (0.0, 0.0, 0.0)
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    result = []
    for geom in geoms:
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            continue
        points = corners(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        flat = (points[:, :2] - (x, y)) @ turn.T
        result.append(Solid(hull(flat), float(points[:, 2].min()), float(points[:, 2].max())))
    return result
