"""Base poses from which a target can be reached: sampled, filtered by the floor, proved by a whole arm motion.

The searches are iterators: each step is one short piece of work, so that a caller can run them off the event loop and
stop between any two steps. A step yields a proven base pose, or None when its candidate was no good.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Percept, Point
from attune.robots.mujoco.arcs import ROOMS, find_arcs, handle_ways
from attune.robots.mujoco.beliefs import Held
from attune.robots.mujoco.costmap import Costmap, Footprint, footprint
from attune.robots.mujoco.crowding import is_compact
from attune.robots.mujoco.driving import find_way
from attune.robots.mujoco.hand_ways import HandWay
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.imagined_view import own_shadow, sees
from attune.robots.mujoco.stances import stances
from attune.robots.mujoco.thorough import promising
from attune.robots.mujoco.whole_motions import PLACING, THOROUGH, Manner, Pick, find_picks, find_places, manners, radius

Array = NDArray[np.float64]

_COMPLETIONS = 3
"""Candidates of an arm motion that are tried to the end from one base pose."""
_WIDE = 0.5
"""Value of a base pose from which what is taken could only be carried far from the body."""
_SLENDER = 0.55
"""Radius of a robot that carries something and leaves wherever it has come to [m]; with folded arms it has 0.47."""
_SECOND_BEST = 4
"""Base poses of less than full value after which no more are tried."""
_MOST_WORK = 180_000
"""Collision checks after which a thorough search is given up: some twelve seconds of processor time."""
_IN_VAIN = 8
"""Base poses from which all of these were tried in vain, before a manner of grasping is given up: it takes long."""
_POSES = 60
"""Base poses that are tried."""
_HANDLE_POSES = 500
"""The same for handles."""
NEIGHBOURHOOD = 0.1
"""Around a place that should be seen before something is put down there [m]."""
SHADOW = 0.2
"""Largest share of a place that the robot's own arms may hide."""


def pick_poses(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    percept: Percept,
    rng: np.random.Generator,
    pitch: float | None = None,
    thorough: bool = False,
    proofs: dict[BasePose, Pick] | None = None,
) -> Iterator[BasePose | None]:
    """Base poses for picking an object up with one of the arms for which there are worlds.

    Args:
        worlds: For each arm, with the object where it was seen, and in the gripper.
        costmap: The floor.
        body: The robot's outline.
        percept: The object.
        rng: For the searches.
        pitch: How steeply the hand should come down, if that matters [rad].
        thorough: Whether to search on, for some seconds, if nothing is found quickly.
        proofs: To be filled: what was found for base poses that only a thorough search has found.
    """
    hopeless: set[bytes] = set()
    postures = {arm: world.arm(arm) for arm, (world, _) in worlds.items()}
    now = next(iter(worlds.values()))[0].base

    in_vain: Counter[Manner] = Counter()

    ways: list[HandWay] = []

    def prove(arm: Arm, manner: Manner) -> float:
        if in_vain[manner] == _IN_VAIN and not manner.thorough:
            return 0.0
        world, carrying = worlds[arm]
        search = find_picks(
            world, carrying, percept, arm, postures[arm], rng, _COMPLETIONS, pitch, hopeless, manner,
            ways,
        )  # fmt: skip
        steps = 0
        plan = None
        for plan in search:
            steps += 1
            if plan is not None:
                break
        if plan is None:
            in_vain[manner] += steps >= _COMPLETIONS
            return 0.0
        if manner.thorough and proofs is not None:
            proofs[world.base] = plan
        compact, outline = is_compact(carrying, plan), footprint(carrying.body_solids())
        if compact and outline.radius < _SLENDER:
            return 1.0
        if find_way(carrying, costmap, outline, carrying.base, now) is None:
            return 0.0  # With the elbow out there might be no way out of where folded arms have led in.
        return 1.0 if compact else _WIDE

    view = next(iter(worlds.values()))[0]
    x, y, z = percept.pose.position
    middle = (x, y, z + percept.extent[2] / 2)

    def sees_it(pose: BasePose) -> bool:
        view.base = pose
        return own_shadow(view, middle, radius(percept)) < SHADOW and sees(view, middle)

    point, found = percept.pose.position, False
    for pose in _in_any_manner(worlds, costmap, body, point, prove, rng, sees_it, manners(pitch)):
        found = found or pose is not None
        yield pose
    if found or not thorough:
        return
    candidates: list[tuple[Arm, BasePose]] = []
    for candidate in promising(worlds, costmap, body, percept, rng, ways):
        if candidate is not None:
            candidates.append(candidate)
        yield None
    candidates.sort(key=lambda candidate: not sees_it(candidate[1]))
    began = _work(worlds)
    for pose in _tried(worlds, candidates, partial(prove, manner=THOROUGH)):
        yield pose
        if _work(worlds) - began > _MOST_WORK:
            return


def _work(worlds: dict[Arm, tuple[Imagination, Imagination]]) -> int:
    """Collision checks made so far."""
    return sum(world.checks for pair in worlds.values() for world in pair)


def place_poses(
    worlds: tuple[Imagination, Imagination],
    costmap: Costmap,
    body: Footprint,
    arm: Arm,
    held: Held,
    position: Point,
    rng: np.random.Generator,
) -> Iterator[BasePose | None]:
    """Base poses for putting down what an arm holds."""
    world, carrying = worlds
    posture = carrying.arm(arm)
    hopeless: dict[Manner, set[bytes]] = {manner: set() for manner in PLACING}

    def prove(_: Arm, manner: Manner) -> bool:
        carrying.set_arm(arm, posture)
        search = find_places(world, carrying, held, arm, position, posture, rng, _COMPLETIONS, hopeless[manner], manner)
        return any(plan is not None for plan in search)

    def sees_where(pose: BasePose) -> bool:
        carrying.base = pose
        return own_shadow(carrying, position, radius(held.percept) + NEIGHBOURHOOD) < SHADOW and sees(
            carrying, position
        )

    yield from _in_any_manner({arm: worlds}, costmap, body, position, prove, rng, sees_where, PLACING)


def handle_poses(
    worlds: dict[Arm, Imagination],
    costmap: Costmap,
    body: Footprint,
    container: str,
    span: tuple[float, float],
    rng: np.random.Generator,
) -> Iterator[BasePose | None]:
    """Base poses for moving a container from one position to another with one of the arms."""
    ways = handle_ways(next(iter(worlds.values())), container, *span)
    x, y, z = np.mean([ways[0][0].position, ways[0][-1].position], axis=0)

    postures = {arm: world.arm(arm) for arm, world in worlds.items()}
    pairs = {arm: (world, world) for arm, world in worlds.items()}
    for room in ROOMS:

        def prove(arm: Arm, room: float = room) -> bool:
            search = find_arcs(worlds[arm], arm, container, ways, span, postures[arm], rng, room, _COMPLETIONS)
            return any(arc is not None for arc in search)

        found = False
        # Few poses let an arm go along the whole way of a handle, but most others are ruled out at once.
        for pose in _proven(pairs, costmap, body, (float(x), float(y), float(z)), prove, rng, _HANDLE_POSES):
            found = found or pose is not None
            yield pose
        if found:
            return


def _in_any_manner(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    point: Point,
    prove: Callable[..., float],
    rng: np.random.Generator,
    preferred: Callable[[BasePose], bool],
    ways: tuple[Manner, ...],
) -> Iterator[BasePose | None]:
    """Base poses for the best manner for which there are any."""
    for manner in ways:
        found = False
        way = partial(prove, manner=manner)
        for pose in _proven(worlds, costmap, body, point, way, rng, preferred=preferred):
            found = found or pose is not None
            yield pose
        if found:
            return


def _proven(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    point: Point,
    prove: Callable[[Arm], float],
    rng: np.random.Generator,
    limit: int = _POSES,
    preferred: Callable[[BasePose], bool] = lambda pose: True,
) -> Iterator[BasePose | None]:
    now = next(iter(worlds.values()))[0].base
    candidates: list[tuple[Arm, BasePose]] = []
    ranked = {arm: stances(costmap, body, point, arm, now, rng) for arm in worlds}
    yield None
    for place in range(limit):
        candidates += [
            (arm, BasePose(*(float(value) for value in poses[place])))
            for arm, poses in ranked.items()
            if place < len(poses)
        ]
    del candidates[limit:]
    candidates.sort(key=lambda candidate: not preferred(candidate[1]))
    yield None
    yield from _tried(worlds, candidates, prove)


def _tried(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    candidates: Sequence[tuple[Arm, BasePose]],
    prove: Callable[[Arm], float],
) -> Iterator[BasePose | None]:
    """Those candidates that are proven, the second best last."""
    second_best: list[BasePose] = []
    for arm, pose in candidates:
        for world in worlds[arm]:
            world.base = pose
        value = prove(arm)
        if 0.0 < value < 1.0:
            second_best.append(pose)
        yield pose if value == 1.0 else None
        if len(second_best) == _SECOND_BEST:
            break
    yield from second_best
