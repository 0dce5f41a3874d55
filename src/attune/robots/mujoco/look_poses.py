"""Base poses from which something can be seen: sampled, filtered by the floor, proved by lines of sight.

The searches are iterators with short steps, like those of `reach`.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import BasePose, Point
from attune.robots.mujoco.costmap import Costmap, Footprint
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.imagined_view import own_shadow, sees, visible
from attune.robots.mujoco.reach import NEIGHBOURHOOD, SHADOW
from attune.robots.mujoco.stances import CLEARANCE

Array = NDArray[np.float64]

_SAMPLES = 250
"""Base poses drawn at once."""
_NEAREST, _FARTHEST = 0.6, 1.3
"""Of the robot from what it looks at, over the floor [m]."""
_THING = 0.045
"""Half the size of a small thing [m]."""
_ROUNDS = 24
"""Times that base poses are drawn to see what was hidden: often only one of a hundred shows it."""
_REVEALED = 0.1
"""Least share of what was hidden that a view must show."""


def look_poses(
    world: Imagination,
    costmap: Costmap,
    body: Footprint,
    point: Point,
    rng: np.random.Generator,
    hidden: Sequence[Point] = (),
) -> Iterator[BasePose | None]:
    """Base poses from which a point can be seen from near, the robot facing it.

    The best one comes first, then those from the farthest other sides.

    Args:
        world: What is known; the robot stands where it is.
        costmap: Of the floor.
        body: The robot's.
        point: What is to be seen.
        rng: For the search.
        hidden: What was hidden: poses from which most of this is seen; few are, so it is searched longer.
    """
    now = world.base
    if hidden:
        yield from _revealing_poses(world, costmap, body, point, hidden, rng)
        return
    poses, towards, costs = _views(costmap, body, point, now, rng)
    shadowed: list[BasePose] = []
    ranked = [int(index) for index in np.argsort(costs, kind="stable")]
    found = False
    while ranked:
        index = ranked.pop(0)
        pose = BasePose(*(float(v) for v in poses[index]))
        world.base = pose
        seen = sees(world, point)
        if seen and own_shadow(world, point, NEIGHBOURHOOD) >= SHADOW:
            shadowed.append(pose)
            seen = False
        yield pose if seen else None
        if seen and not found:
            found = True
            aside = np.abs(np.remainder(towards - towards[index] + np.pi, 2 * np.pi) - np.pi)
            ranked.sort(key=(-aside).__getitem__)
    yield from shadowed


def _revealing_poses(
    world: Imagination,
    costmap: Costmap,
    body: Footprint,
    point: Point,
    hidden: Sequence[Point],
    rng: np.random.Generator,
) -> Iterator[BasePose | None]:
    """Poses from which a good part of what was hidden is seen, most of it first; of equals the one farthest aside.

    What should have been seen from here and was not has something unknown before it.
    """
    now, points = world.base, np.array(hidden)
    # A thing is recognised only if a good part of it is seen: a point counts together with those around it.
    around = np.linalg.norm(points[:, None] - points, axis=2) < _THING
    found: list[tuple[float, float, BasePose]] = []
    for _ in range(_ROUNDS):
        poses, towards, _ = _views(costmap, body, point, now, rng)
        from_here = np.arctan2(point[1] - now.y, point[0] - now.x)
        aside = np.abs(np.remainder(towards - from_here + np.pi, 2 * np.pi) - np.pi)
        for values, away in zip(poses, aside, strict=True):
            world.base = pose = BasePose(*(float(value) for value in values))
            seen = visible(world, point, points)
            share = float(np.mean(~(around & ~seen).any(axis=1)))
            found.append((-round(share, 1), -float(away), pose))
        yield None
    found.sort(key=lambda view: view[:2])
    yield from (pose for less, _, pose in found if -less > _REVEALED)


def _views(
    costmap: Costmap, body: Footprint, point: Point, now: BasePose, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Free base poses around a point, shape (n, 3), in which direction the point is from each, and their costs."""
    distance = rng.uniform(_NEAREST, _FARTHEST, _SAMPLES)
    towards = rng.uniform(-np.pi, np.pi, _SAMPLES)
    poses = np.column_stack(
        (
            point[0] - distance * np.cos(towards),
            point[1] - distance * np.sin(towards),
            towards + rng.uniform(-0.4, 0.4, _SAMPLES),
        )
    )
    clearance = costmap.clearance(poses, body)
    cost = 0.3 * np.hypot(poses[:, 0] - now.x, poses[:, 1] - now.y) + np.abs(distance - 0.8)
    free = clearance > CLEARANCE
    return poses[free], towards[free], cost[free]
