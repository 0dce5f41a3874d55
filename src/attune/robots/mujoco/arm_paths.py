"""Free paths of an arm between two postures.

An empty hand moves through joint space. A hand that carries something moves through the space of upright hands
(position, turn about the vertical, shoulder pan), in which every point keeps the object as upright as it was grasped.
Both try the straight line first, then grow two trees towards each other for a limited number of steps.
"""

from collections.abc import Callable
from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import follow, straight

Array = NDArray[np.float64]

_STEPS = 80
"""Of the tree search."""
_JOINT_STEP = 0.03
"""Between two collision checks [rad]."""
_WILD = 0.4
"""Share of the samples that are drawn from everywhere; the others come from around the straight line."""
_RAISES = (0.08, 0.16, 0.25)
"""Heights by which the hand is lifted before it moves on [m]."""
_JUMP = 0.6
"""Largest change of a joint between two neighbouring points of an upright path [rad]."""

Edge = Callable[[Array, Array], Array | None]
"""The points from one point to another, both included, shape (n, d), or None when that way is not free."""


def joint_path(world: Imagination, arm: Arm, start: Array, goal: Array, rng: np.random.Generator) -> Array | None:
    """A free path through joint space, shape (n, 7), or None. Continuous joints take the short way round."""
    kinematics = world.kinematics[arm]

    def edge(a: Array, b: Array) -> Array | None:
        count = max(2, int(np.max(np.abs(b - a)) / _JOINT_STEP) + 2)
        line = np.linspace(a, b, count)
        return line if world.all_free(arm, line[sparse_first(count)]) else None

    leaving, coming = _raised(world, arm, start), _raised(world, arm, goal)
    for out, back in sorted(product(leaving, coming), key=lambda pair: len(pair[0]) + len(pair[1])):
        shift = kinematics.unwrap(back[-1], out[-1]) - back[-1]
        middle = edge(out[-1], back[-1] + shift)
        if middle is not None:
            return np.concatenate((out, middle[1:], (back + shift)[-2::-1]))
    goal = kinematics.unwrap(goal, start)
    low = np.where(kinematics.continuous, np.minimum(start, goal) - 1.0, kinematics.geometry.low)
    high = np.where(kinematics.continuous, np.maximum(start, goal) + 1.0, kinematics.geometry.high)

    def sample() -> Array:
        if rng.random() < _WILD:
            return rng.uniform(low, high)
        between = start + rng.random() * (goal - start)
        return cast("Array", np.clip(between + rng.normal(0.0, 0.5, 7), low, high))

    return _connect(edge, start, goal, sample, np.ones(7), 0.7, rng)


def _raised(world: Imagination, arm: Arm, q: Array) -> list[Array]:
    """Free paths from a configuration with the hand going straight up by different heights, the first by nothing."""
    hand, torso = world.tool(arm, q), world.torso_frame()
    paths = [q[None]]
    for height in _RAISES:
        end = Frame(hand.position + (0.0, 0.0, height), hand.rotation)
        path = follow(world.kinematics[arm], torso, q, straight(hand, end, 0.03))
        if path is None or not world.all_free(arm, path[1:]):
            break
        paths.append(path)
    return paths


def upright_path(world: Imagination, arm: Arm, start: Array, goal: Array, rng: np.random.Generator) -> Array | None:
    """A free path that turns the hand about the vertical only, shape (n, 7), or None.

    Start and goal must hold the hand equally upright.
    """
    kinematics = world.kinematics[arm]
    # A joint that leans on its limit is measured a little beyond it, where no inverse exists.
    within = np.clip(start, kinematics.geometry.low + _WITHIN, kinematics.geometry.high - _WITHIN)
    position, orientation = kinematics.forward(np.stack((within, goal)))
    branches = kinematics.branch(np.stack((within, goal)))
    turned = orientation[1] @ orientation[0].T
    yaw = float(np.arctan2(turned[1, 0], turned[0, 0]))
    residual = turned @ rotation(2, -yaw)
    if branches[0] != branches[1] or np.trace(residual) < 1 + 2 * np.cos(_SAME_TILT):
        return None
    first = np.array([*position[0], 0.0, within[0]])
    last = np.array([*position[1], yaw, goal[0]])

    def configurations(points: Array) -> Array | None:
        q, good = kinematics.inverse(
            points[:, :3], rotation(2, points[:, 3]) @ orientation[0], points[:, 4], np.full(len(points), branches[0])
        )
        return q if good.all() else None

    def edge(a: Array, b: Array) -> Array | None:
        count = max(2, int(np.max(np.abs(b - a) / _UPRIGHT_STEPS)) + 2)
        points = np.linspace(a, b, count)
        q = configurations(points)
        if q is None:
            return None
        change = np.abs(q[1:] - kinematics.unwrap(q[:-1], q[1:]))
        if change.max() > _JUMP:
            return None
        return points if world.all_free(arm, q[sparse_first(count)]) else None

    low = np.minimum(first, last) - _UPRIGHT_SPREAD
    high = np.maximum(first, last) + _UPRIGHT_SPREAD
    points = _connect(edge, first, last, lambda: rng.uniform(low, high), 1 / _UPRIGHT_STEPS, 12.0, rng)
    if points is None:
        return None
    q = configurations(points)
    if q is None:
        return None
    q[0] = start
    for i in range(1, len(q)):
        q[i] = kinematics.unwrap(q[i], q[i - 1])
    return q


_SAME_TILT = 0.06
"""Hands that lean by less than this differently are equally upright [rad]."""
_WITHIN = 0.002
"""From the joint limits [rad]."""
_UPRIGHT_STEPS = np.array([0.02, 0.02, 0.02, 0.05, 0.05])
_UPRIGHT_SPREAD = np.array([0.15, 0.15, 0.15, 0.6, 0.5])


def sparse_first(count: int) -> NDArray[np.intp]:
    """1 to `count` - 1, the last and then every eighth first: so a way that is not free is soon found out."""
    index = np.arange(count - 1, 0, -1)
    return np.concatenate([index[start::8] for start in (0, 4, 2, 6, 1, 3, 5, 7)])


def _connect(
    edge: Edge,
    start: Array,
    goal: Array,
    sample: Callable[[], Array],
    scale: Array,
    reach: float,
    rng: np.random.Generator,
) -> Array | None:
    """Join two points by free edges: straight, or by two trees that grow towards each other."""
    line = edge(start, goal)
    if line is not None:
        return line
    nodes: list[list[Array]] = [[start], [goal]]
    parents: list[list[int]] = [[-1], [-1]]
    for step in range(_STEPS):
        near, far = step % 2, 1 - step % 2
        grown = _grow(edge, nodes[near], parents[near], sample(), scale, reach)
        if grown is None:
            continue
        tip = nodes[near][grown]
        bridge = int(np.argmin(np.linalg.norm((np.stack(nodes[far]) - tip) * scale, axis=1)))
        if edge(tip, nodes[far][bridge]) is None:
            continue
        meeting = (grown, bridge) if near == 0 else (bridge, grown)
        there, back = (_chain(nodes[tree], parents[tree], meeting[tree]) for tree in (0, 1))
        return _shortcut(edge, [*there[::-1], *back], rng)
    return None


def _grow(edge: Edge, nodes: list[Array], parents: list[int], target: Array, scale: Array, reach: float) -> int | None:
    """Add a node on the way from the nearest node towards `target`; its index, or None when the way is not free."""
    offsets = (np.stack(nodes) - target) * scale
    distances = np.linalg.norm(offsets, axis=1)
    nearest = int(np.argmin(distances))
    share = min(1.0, reach / max(float(distances[nearest]), 1e-9))
    tip = nodes[nearest] + share * (target - nodes[nearest])
    if edge(nodes[nearest], tip) is None:
        return None
    nodes.append(tip)
    parents.append(nearest)
    return len(nodes) - 1


def _chain(nodes: list[Array], parents: list[int], index: int) -> list[Array]:
    """From a node back to the root of its tree."""
    chain = []
    while index >= 0:
        chain.append(nodes[index])
        index = parents[index]
    return chain


def _shortcut(edge: Edge, points: list[Array], rng: np.random.Generator) -> Array | None:
    """Leave out corners that are not needed, and return the path in small steps."""
    for _ in range(30):
        if len(points) < 3:
            break
        i, j = sorted(rng.choice(len(points), size=2, replace=False))
        if j - i > 1 and edge(points[i], points[j]) is not None:
            points = points[: i + 1] + points[j:]
    pieces: list[Array] = []
    for a, b in zip(points[:-1], points[1:], strict=True):
        line = edge(a, b)
        if line is None:
            return None
        pieces.append(line if not pieces else line[1:])
    return cast("Array", np.concatenate(pieces))
