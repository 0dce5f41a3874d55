"""Free paths of an arm that carries something, which stays as upright as it was grasped.

The hand moves through the space of upright hands: its place around the shoulder (distance, direction, height) and its
turn about the vertical. It goes around the shoulder as it comes towards it or draws away from it, for on a straight
line past the shoulder no arm can hold it. On each edge the shoulder's pan is chosen so that the arm moves smoothly.
"""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import free_between
from attune.robots.mujoco.tracking import Tracks
from attune.robots.mujoco.trees import connect, sparse_first

Array = NDArray[np.float64]

_SAME_TILT = 0.06
"""Hands that lean by less than this differently are equally upright [rad]."""
_WITHIN = 0.002
"""From the joint limits [rad]."""
_STEPS = np.array([0.025, 0.04, 0.025, 0.08])
"""Between two points: distance from the shoulder [m], direction from it [rad], height [m], turn of the hand [rad]."""
_SPREAD = np.array([0.15, 0.25, 0.15, 0.6])
"""Around start and goal, for the random points of the search."""
_TURN = 0.1
"""Largest change of a joint between two points of a path, so that checks of the points are enough [rad]."""
_WAYS_OUT = (0.15, 0.3)
"""How far the hand moves back from where it is, to turn in the open [m]."""
_TREE = 16
"""Steps of the tree search."""
_REACH = 12.0
"""Longest edge of a tree, in steps."""
_PAN_STEP = 0.04
"""Between two shoulder pans that are tried [rad]."""
_PAN_ROOM = 12
"""So many steps the pan may go beyond those at both ends of an edge."""


def upright_path(world: Imagination, arm: Arm, start: Array, goal: Array, rng: np.random.Generator) -> Array | None:
    """A free path that turns the hand about the vertical only, shape (n, 7), or None.

    Start and goal must hold the hand equally upright, and bend the arm in the same of the two ways.
    """
    kinematics = world.kinematics[arm]
    # A joint that leans on its limit is measured a little beyond it, where no inverse exists.
    within = np.clip(start, kinematics.geometry.low + _WITHIN, kinematics.geometry.high - _WITHIN)
    ends = np.stack((within, goal))
    position, orientation = kinematics.forward(ends)
    branch, other_branch = kinematics.branch(ends)
    turned = orientation[1] @ orientation[0].T
    yaw = float(np.arctan2(turned[1, 0], turned[0, 0]))
    residual = turned @ rotation(2, -yaw)
    if branch != other_branch or np.trace(residual) < 1 + 2 * np.cos(_SAME_TILT):
        return None
    space = _UprightHands(world, arm, orientation[0], float(branch))
    places = space.places(position)
    # The hand may turn either way round.
    first, *goals = (
        np.array([*places[end], turn, *q])
        for end, turn, q in ((0, 0.0, start), (1, yaw, goal), (1, yaw - np.copysign(2 * np.pi, yaw), goal))
    )
    low = np.min((first, *goals), axis=0)[:4] - _SPREAD
    high = np.max((first, *goals), axis=0)[:4] + _SPREAD

    def sample() -> Array:
        return np.concatenate((rng.uniform(low, high), np.zeros(7)))

    def joints(line: Array) -> Array:
        q = line[:, 4:].copy()
        for i in range(1, len(q)):
            q[i] = kinematics.unwrap(q[i], q[i - 1])
        return q

    def is_exact(line: Array) -> bool:
        return free_between(world, arm, joints(line))

    scale = np.concatenate((1 / _STEPS, np.zeros(7)))
    line = connect(space.edge, first, goals, sample, scale, _REACH, rng, _TREE, space.ways_out, is_exact)
    return None if line is None else joints(line)


class _UprightHands:
    """The space in which a carrying arm moves.

    A point of it, shape (11,), is the hand's distance from the shoulder, direction, height and turn about the vertical,
    and the arm's configuration.

    Args:
        world: Made with the object in the gripper.
        arm: The arm.
        orientation: Of the hand before it turns, in the torso's frame, shape (3, 3).
        branch: Which of the two ways the arm is bent.
    """

    def __init__(self, world: Imagination, arm: Arm, orientation: Array, branch: float) -> None:
        self._world = world
        self._arm: Arm = arm
        self._kinematics = world.kinematics[arm]
        self._shoulder = self._kinematics.geometry.shoulder
        self._orientation = orientation
        self._branch = branch

    def places(self, position: Array) -> Array:
        """Distance, direction (unwrapped) and height around the shoulder of positions (n, 3), the same shape."""
        aside = position[:, :2] - self._shoulder[:2]
        direction = np.unwrap(np.arctan2(aside[:, 1], aside[:, 0]))
        return np.column_stack((np.linalg.norm(aside, axis=1), direction, position[:, 2]))

    def _poses(self, points: Array) -> tuple[Array, Array]:
        """The hand's positions and rotations in the torso's frame."""
        distance, direction, height, turn = points[:, :4].T
        x = self._shoulder[0] + distance * np.cos(direction)
        y = self._shoulder[1] + distance * np.sin(direction)
        return np.column_stack((x, y, height)), rotation(2, turn) @ self._orientation

    def edge(self, a: Array, b: Array, loose: bool = False) -> Array | None:
        """The points from `a` to `b`, or with `loose` to where only the hand is as in `b`; None if not free."""
        low, high = self._kinematics.geometry.low[0], self._kinematics.geometry.high[0]
        columns = np.round(np.array([a[4], a[4] if loose else b[4]]) / _PAN_STEP)
        # The same grid for each edge, so that a way is found in both directions.
        pans = _PAN_STEP * np.arange(columns.min() - _PAN_ROOM, columns.max() + _PAN_ROOM + 1)
        pans = pans[(pans > low - _PAN_STEP / 2) & (pans < high + _PAN_STEP / 2)]
        count = 2 + int(max(np.max(np.abs(b - a)[:4] / _STEPS), np.ptp(columns) / 2))
        points = np.linspace(a[:4], b[:4], count)
        end = None if loose else b[4:]
        tracks = Tracks(self._kinematics, *self._poses(points), pans, self._branch, a[4:], end)
        column = int(np.argmin(np.abs(pans - a[4])))
        if not np.isfinite(tracks.costs[column]):
            return None
        line = self._finer(np.column_stack((points, tracks.path(column))))
        if line is None or not self._world.all_free(self._arm, line[sparse_first(len(line)), 4:]):
            return None
        return line

    def _finer(self, line: Array) -> Array | None:
        """Points added where joints turn far: between two points they move on straight lines, but the hand does not."""
        change = np.abs(np.diff(line[:, 4:], axis=0)).max(axis=1)
        if change.max() <= _TURN:
            return line
        counts = np.ceil(change / _TURN).astype(int)
        at = np.concatenate(([0.0], *(i + np.linspace(0.0, 1.0, n + 1)[1:] for i, n in enumerate(counts))))
        finer = np.stack([np.interp(at, np.arange(len(line)), column) for column in line.T], axis=1)
        new = np.flatnonzero(np.abs(at - np.round(at)) > 1e-9)
        q, good = self._kinematics.inverse(*self._poses(finer[new]), finer[new, 4], np.full(len(new), self._branch))
        finer[new, 4:] = self._kinematics.unwrap(q, finer[new, 4:])
        steps = np.abs(np.diff(finer[:, 4:], axis=0)).max(axis=1)
        return finer if good.all() and steps.max() <= 2 * _TURN else None

    def ways_out(self, point: Array) -> list[list[Array]]:
        """Points to move back to: along the hand, and towards the shoulder."""
        position, rotations = self._poses(point[None])
        towards = np.array([np.cos(point[1]), np.sin(point[1]), 0.0])
        ways = []
        for along in (rotations[0, :, 0] * (1.0, 1.0, 0.0), towards):
            back = np.stack([position[0], *(position[0] - length * along for length in _WAYS_OUT)])
            ways.append([np.concatenate((place, point[3:])) for place in self._unwrapped(self.places(back), point)[1:]])
        return ways

    def _unwrapped(self, places: Array, point: Array) -> Array:
        turns = np.round((point[1] - places[0, 1]) / (2 * np.pi))
        return np.asarray(places + np.array([0.0, 2 * np.pi * turns, 0.0]))
