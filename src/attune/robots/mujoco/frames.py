"""Rigid transforms."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import BasePose, Pose
from attune.robots.mujoco import pr2

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Frame:
    """A rigid transform: position (3,) and rotation matrix (3, 3)."""

    position: Array
    rotation: Array

    def __matmul__(self, other: "Frame") -> "Frame":
        return Frame(self.position + self.rotation @ other.position, self.rotation @ other.rotation)

    def inverse(self) -> "Frame":
        """The transform back."""
        return Frame(-self.rotation.T @ self.position, self.rotation.T)


def frame_of(pose: Pose) -> Frame:
    """A pose as a transform."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.array(pose.orientation))
    return Frame(np.array(pose.position), matrix.reshape(3, 3))


def pose_of(frame: Frame) -> Pose:
    """A transform as a pose."""
    x, y, z = (float(v) for v in frame.position)
    a, b, c, d = (float(v) for v in quaternion(frame.rotation))
    return Pose((x, y, z), (a, b, c, d))


def quaternion(rotation: Array) -> Array:
    """Unit quaternion w, x, y, z of a rotation matrix."""
    result = np.zeros(4)
    mujoco.mju_mat2Quat(result, rotation.flatten())
    return result


def torso_frame(base: BasePose, lift: float) -> Frame:
    """Frame of the torso's link for a base pose and a height of the torso above its lowest [m]."""
    cosine, sine = np.cos(base.yaw), np.sin(base.yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    offset = turn @ np.array([pr2.SHOULDER_OFFSETS["right"][0], 0.0, pr2.SHOULDER_HEIGHT + lift])
    return Frame(np.array([base.x, base.y, 0.0]) + offset, turn)
