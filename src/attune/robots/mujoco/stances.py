"""Base poses from which a shoulder is near a point, and that are free: sampled, and filtered by the floor."""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Point
from attune.robots.mujoco import pr2
from attune.robots.mujoco.costmap import Costmap, Footprint

Array = NDArray[np.float64]

_SAMPLES = 250
"""Base poses drawn at once."""
_ROUNDS = 6
"""Times that so many are drawn, at most, for as many as usual."""
ENOUGH = 40
"""Free ones after which no more are drawn, usually."""
_NEAREST, _FARTHEST = 0.35, 0.85
"""Of the shoulder from the target, over the floor [m]."""
_OUTWARD, _INWARD = 2.0, 0.5
"""How far the target may be to the arm's own side and to the other [rad]."""
CLEARANCE = 0.045
"""Kept from obstacles where the robot stops [m]."""


def stances(
    costmap: Costmap,
    body: Footprint,
    point: Point,
    arm: Arm,
    now: BasePose,
    rng: np.random.Generator,
    enough: int = ENOUGH,
) -> Array:
    """Base poses that bring a shoulder near a point and are free, most promising first, shape (n, 3)."""
    side = 1.0 if arm == "left" else -1.0
    found: list[Array] = []
    costs: list[Array] = []
    # In the open most samples are free, between an open door and a wall one of a hundred.
    for _ in range(_ROUNDS * enough // ENOUGH):
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
        if sum(map(len, found)) >= enough:
            break
    return np.asarray(np.concatenate(found)[np.argsort(np.concatenate(costs), kind="stable")])
