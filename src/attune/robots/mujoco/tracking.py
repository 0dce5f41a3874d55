"""Joint paths of a hand along a series of poses.

Over a grid of shoulder pans the arm's configurations at all poses are known at once. A path is a choice of one pan for
each pose; dynamic programming finds the smoothest from each pan at the beginning.
"""

import numpy as np
from numpy.typing import NDArray

from attune.robots.mujoco.kinematics import ArmKinematics

Array = NDArray[np.float64]

_STEP = 0.02
"""Between two pans of the grid around where a path begins [rad]."""
_SPREAD = 1.2
"""Farthest that the pan goes from there [rad]."""
_NEIGHBOURS = 3
"""Largest change of the pan from one pose to the next, in steps of the grid."""
_JUMP = 0.5
"""Largest change of any joint between two poses [rad]."""
_NEAR_LIMIT = 0.9
"""Share of a joint's range from its middle from which on it counts as near its limit."""
_LIMIT_COST = 4.0


class Tracks:
    """The smoothest paths along poses, on one branch of the kinematics, from each shoulder pan of a grid.

    Args:
        kinematics: Of the arm.
        position: Of the hand, in the torso's frame, shape (n, 3).
        orientation: Of the hand, shape (n, 3, 3).
        pans: The grid, in equal steps, shape (k,) [rad].
        branch: Which of the two ways to bend, +1 or -1.
        start: If given, the configuration at the first pose, at the pan nearest to its own.
        end: The same at the last pose.

    Attributes:
        costs: Of the path from each pan: how far its joints turn and how near they come to their limits; infinite
            where there is none, shape (k,).
    """

    def __init__(
        self,
        kinematics: ArmKinematics,
        position: Array,
        orientation: Array,
        pans: Array,
        branch: float,
        start: Array | None = None,
        end: Array | None = None,
    ) -> None:
        n, k = len(position), len(pans)
        of_pose = np.repeat(np.arange(n), k)
        q, good = kinematics.inverse(position, orientation, np.tile(pans, n), np.full(n * k, branch), of_pose)
        self._kinematics = kinematics
        self._q, good = q.reshape(n, k, 7), good.reshape(n, k)
        for pose, fixed in ((0, start), (-1, end)):
            if fixed is not None:
                self._q[pose], good[pose] = fixed, np.arange(k) == np.argmin(np.abs(pans - fixed[0]))
        if not good.any(axis=1).all():
            self.costs = np.full(k, np.inf)
            return
        price = np.where(good, self._near_limits(), np.inf)
        self._changes = self._turns()
        # Of the rest of the path from each pose and pan; beyond the grid there is none.
        self._to_go = np.full((n, k + 2 * _NEIGHBOURS), np.inf)
        here = self._to_go[:, _NEIGHBOURS:-_NEIGHBOURS]
        # A view: it follows what is written into the middle.
        around = np.lib.stride_tricks.sliding_window_view(self._to_go, k, axis=1)
        here[-1] = price[-1]
        for pose in range(n - 2, -1, -1):
            here[pose] = price[pose] + np.minimum.reduce(self._changes[pose] + around[pose + 1])
        self.costs = here[0].copy()

    def path(self, column: int) -> Array:
        """The path from a pan whose cost is finite, shape (n, 7), its continuous joints unwrapped."""
        columns = [column]
        for changes, to_go in zip(self._changes, self._to_go[1:], strict=True):
            at = columns[-1]
            best = np.argmin(changes[:, at] + to_go[at : at + 2 * _NEIGHBOURS + 1])
            columns.append(at + int(best) - _NEIGHBOURS)
        q = self._q[np.arange(len(columns)), columns]
        turns = np.round(np.diff(q, axis=0) / (2 * np.pi)) * self._kinematics.continuous
        q[1:] -= 2 * np.pi * np.cumsum(turns, axis=0)
        return q

    def _near_limits(self) -> Array:
        limited = ~self._kinematics.continuous
        low, high = self._kinematics.geometry.low[limited], self._kinematics.geometry.high[limited]
        share = np.abs(self._q[..., limited] - (low + high) / 2) / ((high - low) / 2)
        return np.asarray(_LIMIT_COST * np.maximum(0.0, share.max(axis=-1) - _NEAR_LIMIT))

    def _turns(self) -> Array:
        """Largest turn of a joint from each pose and pan to the next pose and each neighbouring pan.

        Infinite when it is a jump; shape (n - 1, 2 * _NEIGHBOURS + 1, k).
        """
        # Joint by joint: reducing over a short last axis is several times slower.
        joints = np.ascontiguousarray(np.moveaxis(self._q, -1, 0))
        count, n, k = joints.shape
        following = np.full((count, n - 1, k + 2 * _NEIGHBOURS), np.nan)
        following[..., _NEIGHBOURS:-_NEIGHBOURS] = joints[:, 1:]
        turns = np.lib.stride_tricks.sliding_window_view(following, k, axis=2) - joints[:, :-1, None]
        for joint in np.flatnonzero(self._kinematics.continuous):
            turns[joint] -= 2 * np.pi * np.round(turns[joint] / (2 * np.pi))
        largest = np.maximum.reduce(np.abs(turns, out=turns))
        return np.where(largest <= _JUMP, largest, np.inf)


def follow(kinematics: ArmKinematics, start: Array, position: Array, orientation: Array) -> Array | None:
    """The smoothest joint path along poses from a configuration at the first one.

    The shoulder's pan may wander a little from one pose to the next where that keeps the joints within limits.

    Args:
        kinematics: Of the arm.
        start: Configuration at the first pose, shape (7,).
        position: In the torso's frame, shape (n, 3), the first being where `start` is.
        orientation: Shape (n, 3, 3).

    Returns:
        Configurations, shape (n, 7), the first being `start`; None when the poses cannot be followed.
    """
    reach = min(_NEIGHBOURS * (len(position) - 1), int(_SPREAD / _STEP))
    pans = start[0] + _STEP * np.arange(-reach, reach + 1)
    inside = (pans >= kinematics.geometry.low[0]) & (pans <= kinematics.geometry.high[0])
    inside[reach] = True
    tracks = Tracks(kinematics, position, orientation, pans[inside], float(kinematics.branch(start[None])[0]), start)
    middle = int(np.count_nonzero(inside[:reach]))
    return tracks.path(middle) if np.isfinite(tracks.costs[middle]) else None
