"""What the head's camera would see in the imagined kitchen."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Point
from attune.robots.mujoco import contact, pr2
from attune.robots.mujoco.frames import gaze
from attune.robots.mujoco.imagination import Imagination

Array = NDArray[np.float64]

_AROUND = np.array([(0, 0, 0), *((np.cos(a), np.sin(a), 0.0) for a in np.arange(8) * np.pi / 4)])
"""A point and eight around it."""


def sees(world: Imagination, point: Point) -> bool:
    """Whether furniture leaves the line from the head's camera to a point free."""
    mujoco.mj_kinematics(world.model, world.data)
    mujoco.mj_camlight(world.model, world.data)
    eye = world.data.cam_xpos[world.model.camera(pr2.HEAD_CAMERA).id]
    way = np.array(point) - eye
    length = float(np.linalg.norm(way))
    m, d = world.model, world.data
    for geom in np.flatnonzero(m.geom_contype == contact.FURNITURE):
        distance = mujoco.mju_rayGeom(
            d.geom_xpos[geom], d.geom_xmat[geom], m.geom_size[geom], eye, way / length, m.geom_type[geom]
        )
        if 0.0 <= distance < length - 0.05:
            return False
    return True


def own_shadow(world: Imagination, point: Point, radius: float) -> float:
    """Share of the surroundings of a point that the robot, or what it carries, hides from its own camera, 0 to 1.

    Args:
        world: The robot stands where it would look from.
        point: That it looks at; on a surface.
        radius: How far around it [m].
    """
    m = world.model
    hit, before = _look(world, point, np.array(point) + radius * _AROUND + (0.0, 0.0, 0.03))
    own = [m.body(name).id for name, _ in world.carried.values()]
    body = m.geom_bodyid[hit]
    return float(np.mean(before & ((m.body_rootid[body] == world.robot_root) | np.isin(body, own))))


def visible(world: Imagination, point: Point, others: Array) -> NDArray[np.bool_]:
    """Which points (n, 3) nothing known hides when the robot looks at a point near them."""
    return ~_look(world, point, others)[1]


def _look(world: Imagination, point: Point, points: Array) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """What the camera, looking at a point, sees in the direction of points (n, 3): geoms; whether before them."""
    m, d = world.model, world.data
    d.qpos[world.addresses(pr2.HEAD_JOINTS)] = gaze(world.torso_frame(), point)
    mujoco.mj_kinematics(m, d)
    mujoco.mj_camlight(m, d)
    camera = m.camera(pr2.HEAD_CAMERA).id
    eye = d.cam_xpos[camera]
    length = np.linalg.norm(points - eye, axis=1)
    hit, reach = np.full(len(points), -1, dtype=np.int32), np.zeros(len(points))
    solid = np.array([group != contact.VISUAL_GROUP for group in range(6)], dtype=np.uint8)
    rays = ((points - eye) / length[:, None]).flatten()
    head = m.cam_bodyid[camera]
    mujoco.mj_multiRay(m, d, eye, rays, solid, True, head, hit, reach, None, len(hit), float(length.max()))
    return hit, (hit >= 0) & (reach < length)
