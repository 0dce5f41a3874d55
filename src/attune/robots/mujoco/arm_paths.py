"""Free paths of an empty arm between two postures, through joint space.

A few straight ways are tried first, then two trees grow towards each other for a limited number of steps.
"""

from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.reaching import follow, free_between, straight
from attune.robots.mujoco.trees import connect, sparse_first

Array = NDArray[np.float64]

_STEPS = 80
"""Of the tree search."""
_MANY_STEPS = 800
"""The same where it is hard to get in or out."""
_JOINT_STEP = 0.03
"""Between two collision checks [rad]."""
_WILD = 0.4
"""Share of the samples that are drawn from everywhere; the others come from around the straight line."""
_RAISES = (0.08, 0.16, 0.25)
"""Heights by which the hand is lifted before it moves on [m]."""


def joint_path(
    world: Imagination, arm: Arm, start: Array, goal: Array, rng: np.random.Generator, *, thorough: bool = False
) -> Array | None:
    """A free path through joint space, shape (n, 7), or None. Continuous joints take the short way round.

    A thorough search takes some tenths of a second where it finds nothing.
    """
    kinematics = world.kinematics[arm]

    def edge(a: Array, b: Array, _: bool = False) -> Array | None:
        count = max(2, int(np.max(np.abs(b - a)) / _JOINT_STEP) + 2)
        line = np.linspace(a, b, count)
        return line if world.all_free(arm, line[sparse_first(count)]) else None

    def is_exact(line: Array) -> bool:
        return free_between(world, arm, line)

    nearly: Array | None = None
    leaving, coming = _raised(world, arm, start), _raised(world, arm, goal)
    for out, back in sorted(product(leaving, coming), key=lambda pair: len(pair[0]) + len(pair[1])):
        shift = kinematics.unwrap(back[-1], out[-1]) - back[-1]
        middle = edge(out[-1], back[-1] + shift)
        if middle is not None:
            line = np.concatenate((out, middle[1:], (back + shift)[-2::-1]))
            if is_exact(line):
                return line
            nearly = line if nearly is None else nearly
    goal = kinematics.unwrap(goal, start)
    low = np.where(kinematics.continuous, np.minimum(start, goal) - 1.0, kinematics.geometry.low)
    high = np.where(kinematics.continuous, np.maximum(start, goal) + 1.0, kinematics.geometry.high)

    def sample() -> Array:
        if rng.random() < _WILD:
            return rng.uniform(low, high)
        between = start + rng.random() * (goal - start)
        return cast("Array", np.clip(between + rng.normal(0.0, 0.5, 7), low, high))

    steps = _MANY_STEPS if thorough and nearly is None else _STEPS
    found = connect(edge, start, (goal,), sample, np.ones(7), 0.7, rng, steps, is_exact=is_exact)
    if found is None or (nearly is not None and not is_exact(found)):
        return nearly
    return found


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
