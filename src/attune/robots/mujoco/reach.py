"""Base poses from which a target can be reached: sampled, filtered by the floor, proved by a whole arm motion.

The searches are iterators: each step is one short piece of work, so that a caller can run them off the event loop and
stop between any two steps. A step yields a proven base pose, or None when its candidate was no good.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Percept, Point
from attune.robots.mujoco import pr2
from attune.robots.mujoco.arcs import ROOMS, find_arcs, handle_ways
from attune.robots.mujoco.beliefs import Held
from attune.robots.mujoco.costmap import Costmap, Footprint
from attune.robots.mujoco.imagination import Imagination
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
_CLEARANCE = 0.045
"""Kept from obstacles where the robot stops [m]."""
_COMPLETIONS = 3
"""Candidates of an arm motion that are tried to the end from one base pose."""
_POSES = 60
"""Base poses that are tried."""
_HANDLE_POSES = 500
"""The same for handles."""
_NEIGHBOURHOOD = 0.1
"""Around a place that should be seen before something is put down there [m]."""
_THING = 0.045
"""Half the size of a small thing [m]."""
_REVEALING_ROUNDS = 24
"""Times that base poses are drawn to see what was hidden: often only one of a hundred shows it."""
_REVEALED = 0.1
"""Least share of what was hidden that a view must show."""
_SHADOW = 0.2
"""Largest share of a place that the robot's own arms may hide."""
_LOOK_NEAREST, _LOOK_FARTHEST = 0.6, 1.3


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
        free = clearance > _CLEARANCE
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

    def prove(arm: Arm, manner: Manner) -> bool:
        world, carrying = worlds[arm]
        search = find_picks(world, carrying, percept, arm, postures[arm], rng, _COMPLETIONS, pitch, hopeless, manner)
        return any(plan is not None for plan in search)

    view = next(iter(worlds.values()))[0]
    x, y, z = percept.pose.position
    middle = (x, y, z + percept.extent[2] / 2)

    def sees_it(pose: BasePose) -> bool:
        view.base = pose
        return view.own_shadow(middle, radius(percept)) < _SHADOW and view.sees(middle)

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
        return carrying.own_shadow(position, radius(held.percept) + _NEIGHBOURHOOD) < _SHADOW and carrying.sees(
            position
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
        sees = world.sees(point)
        if sees and world.own_shadow(point, _NEIGHBOURHOOD) >= _SHADOW:
            shadowed.append(pose)
            sees = False
        yield pose if sees else None
        if sees and not found:
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
    for _ in range(_REVEALING_ROUNDS):
        poses, towards, _ = _views(costmap, body, point, now, rng)
        from_here = np.arctan2(point[1] - now.y, point[0] - now.x)
        aside = np.abs(np.remainder(towards - from_here + np.pi, 2 * np.pi) - np.pi)
        for values, away in zip(poses, aside, strict=True):
            world.base = pose = BasePose(*(float(value) for value in values))
            seen = world.visible(point, points)
            share = float(np.mean(~(around & ~seen).any(axis=1)))
            found.append((-round(share, 1), -float(away), pose))
        yield None
    found.sort(key=lambda view: view[:2])
    yield from (pose for less, _, pose in found if -less > _REVEALED)


def _views(
    costmap: Costmap, body: Footprint, point: Point, now: BasePose, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Free base poses around a point, shape (n, 3), in which direction the point is from each, and their costs."""
    distance = rng.uniform(_LOOK_NEAREST, _LOOK_FARTHEST, _SAMPLES)
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
    free = clearance > _CLEARANCE
    return poses[free], towards[free], cost[free]


def _in_any_manner(
    worlds: dict[Arm, tuple[Imagination, Imagination]],
    costmap: Costmap,
    body: Footprint,
    point: Point,
    prove: Callable[..., bool],
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
    prove: Callable[[Arm], bool],
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
    for arm, pose in candidates:
        for world in worlds[arm]:
            world.base = pose
        yield pose if prove(arm) else None
