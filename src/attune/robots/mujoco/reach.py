"""Base poses from which a target can be reached: sampled, filtered by the floor, proved by a whole arm motion.

The searches are iterators: each step is one short piece of work, so that a caller can run them off the event loop and
stop between any two steps. A step yields a proven base pose, or None when its candidate was no good.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Percept, Point
from attune.robots.mujoco import pr2
from attune.robots.mujoco.arcs import ROOMS, find_arcs, handle_ways
from attune.robots.mujoco.beliefs import Held
from attune.robots.mujoco.costmap import Costmap, Footprint, footprint
from attune.robots.mujoco.crowding import is_compact
from attune.robots.mujoco.driving import find_way
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.imagined_view import own_shadow, sees
from attune.robots.mujoco.whole_motions import PLACING, Manner, find_picks, find_places, manners, radius

Array = NDArray[np.float64]

_SAMPLES = 250
"""Base poses drawn at once."""
_ROUNDS = 6
"""Times that so many are drawn, at most."""
_ENOUGH = 40
"""Free ones after which no more are drawn."""
_NEAREST, _FARTHEST = 0.35, 0.85
"""Of the shoulder from the target, over the floor [m]."""
_OUTWARD, _INWARD = 2.0, 0.5
"""How far the target may be to the arm's own side and to the other [rad]."""
CLEARANCE = 0.045
"""Kept from obstacles where the robot stops [m]."""
_COMPLETIONS = 3
"""Candidates of an arm motion that are tried to the end from one base pose."""
_WIDE = 0.5
"""Value of a base pose from which what is taken could only be carried far from the body."""
_SLENDER = 0.55
"""Radius of a robot that carries something and leaves wherever it has come to [m]; with folded arms it has 0.47."""
_SECOND_BEST = 4
"""Base poses of less than full value after which no more are tried."""
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


def stances(
    costmap: Costmap, body: Footprint, point: Point, arm: Arm, now: BasePose, rng: np.random.Generator
) -> Array:
    """Base poses that bring a shoulder near a point and are free, most promising first, shape (n, 3)."""
    side = 1.0 if arm == "left" else -1.0
    found: list[Array] = []
    costs: list[Array] = []
    # In the open most samples are free, between an open door and a wall one of a hundred.
    for _ in range(_ROUNDS):
        distance = rng.uniform(_NEAREST, _FARTHEST, _SAMPLES)
        bearing = side * rng.uniform(-_INWARD, _OUTWARD, _SAMPLES)
        yaw = rng.uniform(-np.pi, np.pi, _SAMPLES)
        towards = yaw + bearing
        x, y = pr2.SHOULDER_OFFSETS[arm]
        poses = np.column_stack(
            (
                point[0] - distance * np.cos(towards) - np.cos(yaw) * x + np.sin(yaw) * y,
                point[1] - distance * np.sin(towards) - np.sin(yaw) * x - np.cos(yaw) * y,
                yaw,
            )
        )
        clearance = costmap.clearance(poses, body)
        turn = np.abs((poses[:, 2] - now.yaw + np.pi) % (2 * np.pi) - np.pi)
        way = np.hypot(poses[:, 0] - now.x, poses[:, 1] - now.y)
        cost = (
            2.0 * np.abs(distance - 0.6)
            + 0.3 * np.abs(bearing - side * 0.3)
            + 0.15 * way
            + 0.1 * turn
            - 1.0 * np.minimum(clearance, 0.15)
        )
        free = clearance > CLEARANCE
        found.append(poses[free])
        costs.append(cost[free])
        if sum(map(len, found)) >= _ENOUGH:
            break
    return np.asarray(np.concatenate(found)[np.argsort(np.concatenate(costs), kind="stable")])


def pick_poses(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    percept: Percept,
    rng: np.random.Generator,
    pitch: float | None = None,
) -> Iterator[BasePose | None]:
    """Base poses for picking an object up with one of the arms for which there are worlds."""
    hopeless: set[bytes] = set()
    postures = {arm: world.arm(arm) for arm, (world, _) in worlds.items()}
    now = next(iter(worlds.values()))[0].base

    in_vain: Counter[Manner] = Counter()

    def prove(arm: Arm, manner: Manner) -> float:
        if in_vain[manner] == _IN_VAIN:
            return 0.0
        world, carrying = worlds[arm]
        search = find_picks(world, carrying, percept, arm, postures[arm], rng, _COMPLETIONS, pitch, hopeless, manner)
        steps = 0
        plan = None
        for plan in search:
            steps += 1
            if plan is not None:
                break
        if plan is None:
            in_vain[manner] += steps >= _COMPLETIONS
            return 0.0
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

    yield from _in_any_manner(worlds, costmap, body, percept.pose.position, prove, rng, sees_it, manners(pitch))


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
