"""Ways for the base across the floor.

The robot leaves its place without turning, drives where it can turn freely, and comes to its goal at the goal's yaw.
So a way leads through three layers of the costmap: free at the yaw of the start, free at every yaw, free at the yaw of
the goal. One shortest-path search runs over all three at once.
"""

from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from attune.robots.interface import BasePose
from attune.robots.mujoco.costmap import RESOLUTION, Costmap, Footprint, Mask

Array = NDArray[np.float64]

MARGINS = (0.05, 0.035, 0.02, 0.0, -0.02, 0.08)
"""Kept from obstacles on the way [m]: the usual one, those for narrow places, and one for where cells deceive."""
_TIGHT = 0.01
"""Around a start or goal that is itself nearer to obstacles than the margin, this much nearer is allowed [m]."""
_NEARNESS_COST = 2.0
"""Price of driving along an obstacle, relative to driving in the open."""
_LAYER_COST = np.array([1.5, 1.0, 1.5])
"""Price of driving in each layer: the robot should turn as soon and as long as it can."""
_LOOK_FORWARD = 1.2
"""A way longer than this is driven looking forward [m]."""
_NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1))


def find_route(
    costmap: Costmap, body: Footprint, start: BasePose, goal: BasePose, margin: float = MARGINS[0]
) -> Array | None:
    """Waypoints (x, y and unwrapped yaw) from start to goal, both included, shape (n, 3); None if there is no way."""
    direct = np.array([[start.x, start.y, start.yaw], [goal.x, goal.y, start.yaw + _turn(start.yaw, goal.yaw)]])
    if np.linalg.norm(direct[1, :2] - direct[0, :2]) < _LOOK_FORWARD:
        line = np.linspace(direct[0], direct[1], 30)
        if costmap.clearance(line, body).min() >= min(margin, max(0.0, costmap.clearance(direct, body).min())):
            return direct
    turning = costmap.free_turning(body, margin)
    layers = np.stack((_free_from(costmap, body, start, margin), turning, _free_from(costmap, body, goal, margin)))
    cells = _search(costmap, layers, start, goal)
    if cells is None:
        return None
    pieces: list[Array] = []
    for layer in range(3):
        points = costmap.centre(cells[cells[:, 0] == layer, 1:])
        if layer == 0:
            points = np.concatenate(([[start.x, start.y]], points[1:]))
        if layer == 2:
            points = np.concatenate((points[:-1], [[goal.x, goal.y]]))
        if pieces and len(points) and len(pieces[-1]):
            points = np.concatenate((pieces[-1][-1:], points))
        pieces.append(_shortened(costmap, layers[layer], points) if len(points) else points)
    return _with_yaw(pieces, start.yaw, goal.yaw)


def _free_from(costmap: Costmap, body: Footprint, pose: BasePose, margin: float) -> Mask:
    """Cells where the robot fits at the pose's yaw; around the pose itself without margin."""
    free = costmap.free_at(pose.yaw, body, margin)
    row, column = costmap.cell(np.array([pose.x, pose.y]))
    reach = int(0.3 / RESOLUTION)
    i, j = np.meshgrid(
        np.arange(max(0, row - reach), min(costmap.shape[0], row + reach + 1)),
        np.arange(max(0, column - reach), min(costmap.shape[1], column + reach + 1)),
        indexing="ij",
    )
    centres = costmap.centre(np.stack((i, j), axis=-1).reshape(-1, 2))
    poses = np.column_stack((centres, np.full(len(centres), pose.yaw)))
    here = float(costmap.clearance(np.array([[pose.x, pose.y, pose.yaw]]), body)[0])
    free[i.ravel(), j.ravel()] |= costmap.clearance(poses, body) > min(0.0, here - _TIGHT)
    free[row, column] = True
    return free


def _search(costmap: Costmap, layers: NDArray[np.bool_], start: BasePose, goal: BasePose) -> NDArray[np.intp] | None:
    """The cheapest chain of cells (layer, row, column) from start to goal, shape (n, 3)."""
    number = np.arange(layers.size).reshape(layers.shape)
    price = 1.0 + _NEARNESS_COST * costmap.nearness()
    froms, tos, costs = [], [], []

    def connect(a: NDArray[np.intp], b: NDArray[np.intp], cost: Array) -> None:
        froms.append(a)
        tos.append(b)
        costs.append(cost)

    for i, j in _NEIGHBOURS:
        here, there = _shifted(i, j)
        both = layers[:, here[0], here[1]] & layers[:, there[0], there[1]]
        mean = (price[here] + price[there]) / 2 * np.hypot(i, j) * RESOLUTION
        cost = mean * _LAYER_COST[:, None, None]
        connect(number[:, here[0], here[1]][both], number[:, there[0], there[1]][both], cost[both])
        connect(number[:, there[0], there[1]][both], number[:, here[0], here[1]][both], cost[both])
    for lower in (0, 1):
        both = layers[lower] & layers[lower + 1]
        connect(number[lower][both], number[lower + 1][both], np.full(int(both.sum()), 0.02))
    graph = coo_matrix(
        (np.concatenate(costs), (np.concatenate(froms), np.concatenate(tos))), shape=(layers.size, layers.size)
    ).tocsr()
    first = int(number[(0, *costmap.cell(np.array([start.x, start.y])))])
    last = int(number[(2, *costmap.cell(np.array([goal.x, goal.y])))])
    cost, before = dijkstra(graph, indices=first, return_predecessors=True)
    if not np.isfinite(cost[last]):
        return None
    chain = [last]
    while chain[-1] != first:
        chain.append(int(before[chain[-1]]))
    return np.stack(np.unravel_index(chain[::-1], layers.shape), axis=1)


def _shifted(i: int, j: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    rows = (slice(0, -i), slice(i, None)) if i else (slice(None), slice(None))
    if j == 0:
        return (rows[0], slice(None)), (rows[1], slice(None))
    if j > 0:
        return (rows[0], slice(0, -j)), (rows[1], slice(j, None))
    return (rows[0], slice(-j, None)), (rows[1], slice(0, j))


def _shortened(costmap: Costmap, free: Mask, points: Array) -> Array:
    """Leave out what a straight line can replace."""
    if len(points) < 3:
        return points
    price = costmap.nearness()

    def straight(a: Array, b: Array) -> bool:
        line = np.linspace(a, b, max(2, int(np.linalg.norm(b - a) / (RESOLUTION / 2)) + 1))[1:-1]
        cells = costmap.cell(line)
        # The line must not pass nearer to obstacles than the way it replaces, beyond a little.
        return bool(np.all(free[cells[:, 0], cells[:, 1]])) and (
            not len(cells) or float(price[cells[:, 0], cells[:, 1]].max()) <= limit + 0.15
        )

    kept = [points[0]]
    i = 0
    while i < len(points) - 1:
        j = len(points) - 1
        while j > i + 1:
            between = costmap.cell(points[i : j + 1])
            limit = float(price[between[:, 0], between[:, 1]].max())
            if straight(points[i], points[j]):
                break
            j = max(i + 1, j - max(1, (j - i) // 8))
        kept.append(points[j])
        i = j
    return np.stack(kept)


def _with_yaw(pieces: list[Array], start_yaw: float, goal_yaw: float) -> Array:
    """Give each point its yaw: constant in the outer layers, in the middle one forward or straight to the goal's."""
    leaving, middle, coming = pieces
    goal_yaw = start_yaw + _turn(start_yaw, goal_yaw)
    way = [np.column_stack((leaving, np.full(len(leaving), start_yaw)))]
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1) if len(middle) > 1 else np.zeros(0)
    length = float(steps.sum())
    if length > _LOOK_FORWARD:
        way.append(_looking_forward(middle, length, start_yaw, goal_yaw))
        goal_yaw = float(way[-1][-1, 2])
    elif len(middle):
        share = np.concatenate(([0.0], np.cumsum(steps))) / max(length, 1e-9)
        if length < 1e-6:
            share[-1] = 1.0
        turned = np.column_stack((middle, start_yaw + share * (goal_yaw - start_yaw)))
        way.append(turned if length > 1e-6 else np.vstack((turned, [*middle[-1], goal_yaw])))
    way.append(np.column_stack((coming, np.full(len(coming), goal_yaw))))
    joined = np.concatenate(way)
    keep = np.concatenate(([True], np.abs(np.diff(joined, axis=0)).max(axis=1) > 1e-9))
    return cast("Array", joined[keep])


def _looking_forward(points: Array, length: float, start_yaw: float, goal_yaw: float) -> Array:
    dense = [points[:1]]
    for a, b in zip(points[:-1], points[1:], strict=True):
        dense.append(np.linspace(a, b, max(2, int(np.linalg.norm(b - a) / 0.1) + 1))[1:])
    line = np.concatenate(dense)
    steps = np.diff(line, axis=0)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(steps, axis=1))))
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    heading += 2 * np.pi * np.round((start_yaw - heading[0]) / (2 * np.pi))
    heading = np.append(heading, heading[-1])
    # Turn over the first and the last part of the way, while driving.
    ramp = min(0.6, length / 2.5)
    begin = np.clip(along / ramp, 0.0, 1.0)
    end = np.clip((length - along) / ramp, 0.0, 1.0)
    final = heading[-1] + _turn(float(heading[-1]), goal_yaw)
    yaw = start_yaw * (1 - begin) + heading * begin
    yaw = yaw * end + final * (1 - end)
    return np.column_stack((line, yaw))


def _turn(from_yaw: float, to_yaw: float) -> float:
    return float((to_yaw - from_yaw + np.pi) % (2 * np.pi) - np.pi)
