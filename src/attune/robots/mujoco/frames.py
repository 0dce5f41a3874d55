"""Rigid transforms."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import BasePose, Point, Pose
from attune.robots.mujoco import pr2

Array = NDArray[np.float64]

_EYE = (0.0732, 0.0845)
"""The camera in the frame of the head's tilt: ahead, up [m]."""
_NECK = (-0.01707, 0.38145, 0.068)
"""The pan axis in the torso's frame (ahead, up), and the tilt axis ahead of it [m]."""


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


def gaze(torso: Frame, point: Point) -> tuple[float, float]:
    """The head's pan and tilt with which the camera looks at a point, as far as it turns [rad].

    Args:
        torso: As `torso_frame` gives it.
        point: In the map frame.
    """
    x, y, z = torso.rotation.T @ (np.array(point) - torso.position)
    pan = np.arctan2(y, x - _NECK[0])
    ahead, up = np.hypot(y, x - _NECK[0]) - _NECK[2], z - _NECK[1]
    tilt = np.arcsin(np.clip(_EYE[1] / max(np.hypot(ahead, up), 0.1), -1.0, 1.0)) - np.arctan2(up, ahead)
    limits = (pr2.SERVOS[joint] for joint in pr2.HEAD_JOINTS)
    clipped = (float(np.clip(angle, s.low, s.high)) for angle, s in zip((pan, tilt), limits, strict=True))
    return next(clipped), next(clipped)


def torso_frame(base: BasePose, lift: float) -> Frame:
    """Frame of the torso's link for a base pose and a height of the torso above its lowest [m]."""
    cosine, sine = np.cos(base.yaw), np.sin(base.yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    offset = turn @ np.array([pr2.SHOULDER_OFFSETS["right"][0], 0.0, pr2.SHOULDER_HEIGHT + lift])
    return Frame(np.array([base.x, base.y, 0.0]) + offset, turn)
