"""Configurations with which an arm reaches a series of poses of its hand."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco import tracking
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import ArmKinematics

Array = NDArray[np.float64]

STEP = 0.02
"""Between two poses of a straight motion of the hand [m]."""
_TURN = 0.1
"""Largest change of a joint between two points of a path, so that collision checks of the points are enough [rad]."""

_BETWEEN = 0.012
"""Between two configurations of a finished path at which its way is looked at once more [rad]."""


def stacked(torso: Frame, frames: Sequence[Frame]) -> tuple[Array, Array]:
    """Map frames as positions (n, 3) and rotations (n, 3, 3) in the torso's frame."""
    position = np.stack([frame.position for frame in frames]) - torso.position
    rotation = np.stack([frame.rotation for frame in frames])
    return position @ torso.rotation, torso.rotation.T @ rotation


def reach_all(
    kinematics: ArmKinematics, torso: Frame, series: Sequence[Sequence[Frame]], pans: Array
) -> tuple[Array, NDArray[np.intp]]:
    """Configurations that reach all key poses of one motion with one shoulder pan, for many motions at once.

    Args:
        kinematics: Of the arm.
        torso: The torso's frame in the map.
        series: Key poses of the hand in the map frame; each motion has k of them.
        pans: Shoulder pans to try.

    Returns:
        Configurations, shape (m, k, 7), continuous from pose to pose, and the motion each belongs to, shape (m,).
    """
    count = len(series[0])
    position, orientation = stacked(torso, [frame for motion in series for frame in motion])
    position = position.reshape(len(series), count, 3)
    orientation = orientation.reshape(len(series), count, 3, 3)
    first, index = kinematics.solutions(position[:, 0], orientation[:, 0], pans)
    result = [first]
    good = np.ones(len(first), dtype=bool)
    branch = kinematics.branch(first)
    for key in range(1, count):
        q, reached = kinematics.inverse(position[index, key], orientation[index, key], first[:, 0], branch)
        q = kinematics.unwrap(q, result[-1])
        good &= reached & (np.max(np.abs(q - result[-1]), axis=1) < 1.5)
        result.append(q)
    return np.stack(result, axis=1)[good], index[good]


def straight(start: Frame, end: Frame, step: float = STEP) -> list[Frame]:
    """Poses from start to end on a line, orientation of the start; both ends included."""
    count = max(2, int(np.ceil(np.linalg.norm(end.position - start.position) / step)) + 1)
    return [Frame(p, start.rotation) for p in np.linspace(start.position, end.position, count)]


def follow(kinematics: ArmKinematics, torso: Frame, start: Array, frames: Sequence[Frame]) -> Array | None:
    """A joint path of the hand along poses, from configuration `start` at the first one; None where there is none."""
    position, orientation = stacked(torso, frames)
    path = tracking.follow(kinematics, start, position, orientation)
    return None if path is None else finer(path, _TURN)


def finer(path: Array, step: float) -> Array:
    """A polyline, shape (n, d), with points added so that no coordinate changes by more than `step` between two."""
    counts = np.maximum(1.0, np.ceil(np.abs(np.diff(path, axis=0)).max(axis=1) / step))
    at = np.interp(np.arange(counts.sum() + 1), np.concatenate(([0.0], np.cumsum(counts))), np.arange(len(path)))
    return np.stack([np.interp(at, np.arange(len(path)), column) for column in path.T], axis=1)


def free_between(world: Imagination, arm: Arm, path: Array) -> bool:
    """Whether an arm can also move on straight lines between the points of a path, shape (n, 7), which are free.

    Past a corner even short steps may cut it. The first point need not be free; then the first step is not looked at.
    """
    first = 0 if world.all_free(arm, path[:1]) else 1
    rest = path[first:]
    return len(rest) < 2 or world.all_free(arm, finer(rest, _BETWEEN))


def comfort(kinematics: ArmKinematics, q: Array) -> Array:
    """How near each configuration (n, 7) comes to a joint limit: 0 in the middle, 1 at a limit."""
    low, high = kinematics.geometry.low, kinematics.geometry.high
    limited = ~kinematics.continuous
    middle = (low[limited] + high[limited]) / 2
    return np.asarray(np.max(np.abs(q[:, limited] - middle) / ((high - low)[limited] / 2), axis=1))
