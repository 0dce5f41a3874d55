"""Two trees that grow towards each other until an edge joins them: a search for a way, whatever its points are."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Edge = Callable[[Array, Array, bool], Array | None]
"""The points from one point to another, both included, shape (n, d), or None when that way is not free.

With True for the third argument it may end at another point that serves as well.
"""

_LOOKS = 2
"""Paths that are looked at closely, at most."""


def sparse_first(count: int) -> NDArray[np.intp]:
    """1 to `count` - 1, the last and then every eighth first: so a way that is not free is soon found out."""
    index = np.arange(count - 1, 0, -1)
    return np.concatenate([index[start::8] for start in (0, 4, 2, 6, 1, 3, 5, 7)])


def connect(
    edge: Edge,
    start: Array,
    goals: Sequence[Array],
    sample: Callable[[], Array],
    scale: Array,
    reach: float,
    rng: np.random.Generator,
    steps: int,
    ways_out: Callable[[Array], Sequence[Sequence[Array]]] = lambda node: (),
    is_exact: Callable[[Array], bool] = lambda line: True,
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
        is_exact: Looks closely at a whole path. If none withstands that, the first that was found is returned.
    """
    nearly: Array | None = None
    lines = _found(_remembering(edge), start, goals, sample, scale, reach, rng, steps, ways_out)
    for line in islice(lines, _LOOKS):
        if is_exact(line):
            return line
        nearly = line if nearly is None else nearly
    return nearly


def _found(
    edge: Edge,
    start: Array,
    goals: Sequence[Array],
    sample: Callable[[], Array],
    scale: Array,
    reach: float,
    rng: np.random.Generator,
    steps: int,
    ways_out: Callable[[Array], Sequence[Sequence[Array]]],
) -> Iterator[Array]:
    """Paths as they are found; see `connect`."""
    for goal in goals:
        line = edge(start, goal, False)
        if line is not None:
            yield line
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
            yield from _joined(edge, nodes, parents, (i, j), rng)
    for step in range(steps):
        near, far = step % 2, 1 - step % 2
        grown = _grow(edge, nodes[near], parents[near], sample(), scale, reach)
        if grown is None:
            continue
        tip = nodes[near][grown]
        bridge = int(np.argmin(np.linalg.norm((np.stack(nodes[far]) - tip) * scale, axis=1)))
        if edge(tip, nodes[far][bridge], False) is not None:
            yield from _joined(edge, nodes, parents, (grown, bridge) if near == 0 else (bridge, grown), rng)


def _remembering(edge: Edge) -> Edge:
    """The same edges, each tried only once: trees meet and corners are left out at the same points again and again."""
    known: dict[tuple[bytes, bytes, bool], Array | None] = {}

    def remembered(a: Array, b: Array, loose: bool) -> Array | None:
        key = a.tobytes(), b.tobytes(), loose
        if key not in known:
            known[key] = edge(a, b, loose)
        return known[key]

    return remembered


def _joined(
    edge: Edge,
    nodes: list[list[Array]],
    parents: list[list[int]],
    meeting: tuple[int, int],
    rng: np.random.Generator,
) -> Iterator[Array]:
    """The whole path through the nodes of two trees that an edge joins, if there is one."""
    there, back = (_chain(nodes[tree], parents[tree], meeting[tree]) for tree in (0, 1))
    line = _shortcut(edge, [*there[::-1], *back], rng)
    if line is not None:
        yield line


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
