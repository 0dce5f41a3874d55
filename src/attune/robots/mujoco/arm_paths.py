"""Free paths of an arm between two postures.

An empty hand moves through joint space. A hand that carries something moves through the space of upright hands
(position, turn about the vertical, shoulder pan), in which every point keeps the object as upright as it was grasped.
Both try the straight line first, then grow two trees towards each other for a limited number of steps.
"""

from collections.abc import Callable, Sequence
from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import follow, straight
from attune.robots.mujoco.tracking import Tracks

Array = NDArray[np.float64]

_STEPS = 80
"""Of the tree search."""
_JOINT_STEP = 0.03
"""Between two collision checks [rad]."""
_WILD = 0.4
"""Share of the samples that are drawn from everywhere; the others come from around the straight line."""
_RAISES = (0.08, 0.16, 0.25)
"""Heights by which the hand is lifted before it moves on [m]."""
_TURN = 0.1
"""Largest change of a joint between two points of an upright path, so that checks of the points are enough [rad]."""

Edge = Callable[[Array, Array, bool], Array | None]
"""The points from one point to another, both included, shape (n, d), or None when that way is not free.

With True for the third argument it may end at another point that serves as well.
"""


def joint_path(world: Imagination, arm: Arm, start: Array, goal: Array, rng: np.random.Generator) -> Array | None:
    """A free path through joint space, shape (n, 7), or None. Continuous joints take the short way round."""
    kinematics = world.kinematics[arm]

    def edge(a: Array, b: Array, _: bool = False) -> Array | None:
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

    return _connect(edge, start, (goal,), sample, np.ones(7), 0.7, rng, _STEPS)


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

    Start and goal must hold the hand equally upright. The hand moves around the shoulder as it moves towards it or away
    from it, for on a straight line past the shoulder no arm can hold it; the shoulder's pan is chosen so that the arm
    moves smoothly.
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
    shoulder = kinematics.geometry.shoulder
    # A node is the hand's place around the shoulder (distance, direction, height), its turn about the vertical, and the
    # arm's configuration there.
    aside = position[:, :2] - shoulder[:2]
    around = np.unwrap(np.arctan2(aside[:, 1], aside[:, 0]))
    other_way_round = yaw - np.copysign(2 * np.pi, yaw)
    first, *goals = (
        np.array([np.hypot(*aside[i]), around[i], position[i, 2], turn, *q])
        for i, turn, q in ((0, 0.0, start), (1, yaw, goal), (1, other_way_round, goal))
    )

    def poses(points: Array) -> tuple[Array, Array]:
        out, direction, height, turn = points.T
        x, y = shoulder[0] + out * np.cos(direction), shoulder[1] + out * np.sin(direction)
        return np.column_stack((x, y, height)), rotation(2, turn) @ orientation[0]
    low_pan, high_pan = kinematics.geometry.low[0], kinematics.geometry.high[0]

    def edge(a: Array, b: Array, loose: bool = False) -> Array | None:
        """With `loose`, only the hand's pose at the end is as in `b`."""
        columns = np.round(np.array([a[4], a[4] if loose else b[4]]) / _PAN_STEP)
        pans = _PAN_STEP * np.arange(columns.min() - _PAN_ROOM, columns.max() + _PAN_ROOM + 1)
        pans = pans[(pans > low_pan - _PAN_STEP / 2) & (pans < high_pan + _PAN_STEP / 2)]
        count = 2 + int(max(np.max(np.abs(b - a)[:4] / _UPRIGHT_STEPS), np.ptp(columns) / 2))
        points = np.linspace(a[:4], b[:4], count)
        tracks = Tracks(kinematics, *poses(points), pans, branches[0], a[4:], None if loose else b[4:])
        column = int(np.argmin(np.abs(pans - a[4])))
        if not np.isfinite(tracks.costs[column]):
            return None
        line = finer_line(np.column_stack((points, tracks.path(column))))
        return line if line is not None and world.all_free(arm, line[sparse_first(len(line)), 4:]) else None

    def finer_line(line: Array) -> Array | None:
        """Between two points the joints move on straight lines, the hand does not where they turn far."""
        change = np.abs(np.diff(line[:, 4:], axis=0)).max(axis=1)
        if change.max() <= _TURN:
            return line
        counts = np.ceil(change / _TURN).astype(int)
        at = np.concatenate(([0.0], *(i + np.linspace(0.0, 1.0, n + 1)[1:] for i, n in enumerate(counts))))
        between = np.stack([np.interp(at, np.arange(len(line)), column) for column in line.T], axis=1)
        fresh = np.flatnonzero(np.abs(at - np.round(at)) > 1e-9)
        branch = np.full(len(fresh), branches[0])
        q, good = kinematics.inverse(*poses(between[fresh, :4]), between[fresh, 4], branch)
        between[fresh, 4:] = kinematics.unwrap(q, between[fresh, 4:])
        steps = np.abs(np.diff(between[:, 4:], axis=0)).max(axis=1)
        return between if good.all() and steps.max() <= 2 * _TURN else None

    low = np.min((first, *goals), axis=0)[:4] - _UPRIGHT_SPREAD
    high = np.max((first, *goals), axis=0)[:4] + _UPRIGHT_SPREAD

    def sample() -> Array:
        return np.concatenate((rng.uniform(low, high), np.zeros(7)))

    def ways_out(node: Array) -> list[list[Array]]:
        """Back along the hand, and towards the shoulder."""
        heading = (rotation(2, node[3]) @ orientation[0])[:2, 0]
        towards = np.array([np.cos(node[1]), np.sin(node[1])])
        place = shoulder[:2] + node[0] * towards
        ways = []
        for along in (heading, towards):
            points = []
            for length in _WAYS_OUT:
                aside = place - length * along - shoulder[:2]
                turned = node[1] + np.remainder(np.arctan2(aside[1], aside[0]) - node[1] + np.pi, 2 * np.pi) - np.pi
                points.append(np.array([np.hypot(*aside), turned, *node[2:]]))
            ways.append(points)
        return ways

    scale = np.array([*(1 / _UPRIGHT_STEPS), *np.zeros(7)])
    line = _connect(edge, first, goals, sample, scale, 12.0, rng, _UPRIGHT_TREE, ways_out)
    if line is None:
        return None
    q = line[:, 4:]
    for i in range(1, len(q)):
        q[i] = kinematics.unwrap(q[i], q[i - 1])
    return q


_SAME_TILT = 0.06
"""Hands that lean by less than this differently are equally upright [rad]."""
_WITHIN = 0.002
"""From the joint limits [rad]."""
_UPRIGHT_STEPS = np.array([0.025, 0.04, 0.025, 0.08])
"""Of an upright path: distance from the shoulder [m], direction from it [rad], height [m], turn of the hand [rad]."""
_UPRIGHT_SPREAD = np.array([0.15, 0.25, 0.15, 0.6])
_WAYS_OUT = (0.15, 0.3)
"""How far the hand moves back from where it is, to turn in the open [m]."""
_UPRIGHT_TREE = 16
"""Steps of the tree search for an upright path."""
_PAN_STEP = 0.04
"""Between two shoulder pans that are tried on an upright path [rad]."""
_PAN_ROOM = 12
"""So many steps the pan may go beyond those at both ends of a line."""


def sparse_first(count: int) -> NDArray[np.intp]:
    """1 to `count` - 1, the last and then every eighth first: so a way that is not free is soon found out."""
    index = np.arange(count - 1, 0, -1)
    return np.concatenate([index[start::8] for start in (0, 4, 2, 6, 1, 3, 5, 7)])


def _connect(
    edge: Edge,
    start: Array,
    goals: Sequence[Array],
    sample: Callable[[], Array],
    scale: Array,
    reach: float,
    rng: np.random.Generator,
    steps: int,
    ways_out: Callable[[Array], Sequence[Sequence[Array]]] = lambda node: (),
) -> Array | None:
    """Join a point with one of several by free edges: straight, by ways out, or by trees that grow towards each other.

    Args:
        edge: Joins two points.
        start: From where.
        goals: To where.
        sample: Gives random points.
        scale: Of each coordinate, for distances.
        reach: Longest edge of a tree, scaled.
        rng: For leaving out corners.
        steps: Of the tree search.
        ways_out: Points one after the other that lead from a point into the open.
    """
    for goal in goals:
        line = edge(start, goal, False)
        if line is not None:
            return line
    nodes: list[list[Array]] = [[start], list(goals)]
    parents: list[list[int]] = [[-1], [-1] * len(goals)]
    for tree, root in ((0, 0), *((1, index) for index in range(len(goals)))):
        for way in ways_out(nodes[tree][root]):
            parent = root
            for point in way:
                line = edge(nodes[tree][parent], point, True)
                if line is None:
                    break
                nodes[tree].append(line[-1])
                parents[tree].append(parent)
                parent = len(nodes[tree]) - 1
    pairs = [(i, j) for i in range(len(nodes[0])) for j in range(len(nodes[1])) if i or j >= len(goals)]
    for i, j in sorted(pairs, key=sum):
        if edge(nodes[0][i], nodes[1][j], False) is not None:
            return _joined(edge, nodes, parents, (i, j), rng)
    for step in range(steps):
        near, far = step % 2, 1 - step % 2
        grown = _grow(edge, nodes[near], parents[near], sample(), scale, reach)
        if grown is None:
            continue
        tip = nodes[near][grown]
        bridge = int(np.argmin(np.linalg.norm((np.stack(nodes[far]) - tip) * scale, axis=1)))
        if edge(tip, nodes[far][bridge], False) is None:
            continue
        return _joined(edge, nodes, parents, (grown, bridge) if near == 0 else (bridge, grown), rng)
    return None


def _joined(
    edge: Edge,
    nodes: list[list[Array]],
    parents: list[list[int]],
    meeting: tuple[int, int],
    rng: np.random.Generator,
) -> Array | None:
    """The whole path through the nodes of two trees that an edge joins."""
    there, back = (_chain(nodes[tree], parents[tree], meeting[tree]) for tree in (0, 1))
    return _shortcut(edge, [*there[::-1], *back], rng)


def _grow(edge: Edge, nodes: list[Array], parents: list[int], target: Array, scale: Array, reach: float) -> int | None:
    """Add a node on the way from the nearest node towards `target`; its index, or None when the way is not free."""
    offsets = (np.stack(nodes) - target) * scale
    distances = np.linalg.norm(offsets, axis=1)
    nearest = int(np.argmin(distances))
    share = min(1.0, reach / max(float(distances[nearest]), 1e-9))
    tip = nodes[nearest] + share * (target - nodes[nearest])
    line = edge(nodes[nearest], tip, True)
    if line is None:
        return None
    nodes.append(line[-1])
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
        if j - i > 1 and edge(points[i], points[j], False) is not None:
            points = points[: i + 1] + points[j:]
    pieces: list[Array] = []
    for a, b in zip(points[:-1], points[1:], strict=True):
        line = edge(a, b, False)
        if line is None:
            return None
        pieces.append(line if not pieces else line[1:])
    return cast("Array", np.concatenate(pieces))
