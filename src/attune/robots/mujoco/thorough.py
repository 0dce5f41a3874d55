"""A thorough search where no usual grasp is possible: from what the hand alone can do to base poses that allow it."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from attune.robots.interface import Arm, BasePose, Percept
from attune.robots.mujoco.costmap import Costmap, Footprint
from attune.robots.mujoco.grasps import more_grasps
from attune.robots.mujoco.hand_ways import HandWay, hand_ways
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.pick_place import starts_along
from attune.robots.mujoco.skeleton import through_things
from attune.robots.mujoco.stances import stances

_STANCES = 300
"""Base poses that are looked at for each arm."""
_COARSE = 0.3
"""Between two shoulder pans that are tried for a first look at a base pose [rad]."""
_ALIKE = 8
"""Ways with the same rotation of the hand that are kept."""


def different_ways(world: Imagination, carrying: Imagination, percept: Percept, arm: Arm) -> Iterator[HandWay | None]:
    """Ways of the hand to grasp an object and lift it, few of each kind; None after each short piece of work."""
    kinds: Counter[bytes] = Counter()
    for way in hand_ways(world, carrying, percept, arm, more_grasps(percept)):
        if way is None:
            yield None
            continue
        kind = np.round(way.grasp.rotation, 3).tobytes()
        kinds[kind] += 1
        if kinds[kind] <= _ALIKE:
            yield way


def promising(
    worlds: Mapping[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    percept: Percept,
    rng: np.random.Generator,
    ways: list[HandWay],
) -> Iterator[tuple[Arm, BasePose] | None]:
    """Base poses from which an arm reaches something that the hand can do, without its bones going through things.

    None after each short piece of work.

    Args:
        worlds: For each arm, with the object where it was seen, and in the gripper.
        costmap: The floor.
        body: The robot's outline.
        percept: The object.
        rng: For the samples.
        ways: To be filled: what the hand can do.
    """
    first = next(iter(worlds))  # The hands are alike.
    for way in different_ways(*worlds[first], percept, first):
        if way is not None:
            ways.append(way)
        yield None
    now = worlds[first][0].base
    poses: Iterable[tuple[Arm, BasePose]] = (
        (arm, BasePose(*(float(value) for value in stance)))
        for arm in worlds
        for stance in (stances(costmap, body, percept.pose.position, arm, now, rng, _STANCES) if ways else ())
    )
    for arm, pose in poses:
        world = worlds[arm][0]
        world.base = pose
        starts = starts_along(world, arm, ways, _COARSE)
        if starts:
            q = np.stack([start.keys[0] for start in starts])
            if not through_things(world, arm, q, percept.name).all():
                yield arm, pose
                continue
        yield None
