"""Whether the bones of an arm go through something: a quick test of many configurations at once.

Near a compartment most configurations reach through its walls or through what stands in it. Those are sorted out here,
so that the exact tests, of which there can be few, are spent on the others.
"""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco import pr2
from attune.robots.mujoco.imagination import Imagination

Array = NDArray[np.float64]

_FLESH = 0.03
"""Less than the bones are thick all round [m]: what is sorted out could not be free."""
_LONGEST = 1.1
"""Farther from the shoulder nothing is reached [m]."""


def through_things(world: Imagination, arm: Arm, q: Array, handled: str) -> NDArray[np.bool_]:
    """Whether upper arm or forearm would go through furniture or objects, for configurations (n, 7), shape (n,).

    Args:
        world: Where everything is.
        arm: The arm.
        q: Its configurations.
        handled: The object that it is about, which does not count.
    """
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    geometry = kinematics.geometry
    position, orientation = kinematics.forward(q)
    pan = q[:, 0]
    shoulder = geometry.shoulder + geometry.offset * np.column_stack((np.cos(pan), np.sin(pan), np.zeros(len(q))))
    elbow, wrist = kinematics.elbow(q), position - pr2.TOOL_OFFSET * orientation[:, :, 0]
    joints = np.stack((shoulder, elbow, wrist)) @ torso.rotation.T + torso.position
    centres, rotations, halves = world.obstacle_boxes(handled)
    near = np.linalg.norm(centres - joints[0, 0], axis=1) < _LONGEST + np.linalg.norm(halves, axis=1)
    centres, rotations, halves = centres[near], rotations[near], halves[near] + _FLESH
    # In the frames of the boxes, shape (3, n, boxes, 3).
    local = np.einsum("jnbk,bkl->jnbl", joints[:, :, None] - centres, rotations)
    return np.asarray(_cross(local[0], local[1], halves) | _cross(local[1], local[2], halves))


def _cross(start: Array, end: Array, halves: Array) -> NDArray[np.bool_]:
    """Whether segments cross any of the boxes around the origins of their frames, shape (n,)."""
    way = end - start
    way = np.where(np.abs(way) < 1e-9, 1e-9, way)
    first, second = (-halves - start) / way, (halves - start) / way
    enters = np.minimum(first, second).max(axis=-1)
    leaves = np.maximum(first, second).min(axis=-1)
    return np.asarray(((leaves >= np.maximum(enters, 0.0)) & (enters <= 1.0)).any(axis=-1))
