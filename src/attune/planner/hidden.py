"""Where on a surface something may stand that no look has shown yet, and what it may be hidden by."""

import math
from collections.abc import Iterable

from attune.core.scene import Surface
from attune.planner.belief import Individual
from attune.planner.designators import points_on, radius, steps
from attune.robots.interface import Point, Robot

Cell = tuple[int, int]

SPACING = 0.04
"""Between two points that are watched [m]."""
HEIGHT = 0.04
"""Of these points over the surface [m]."""
NARROW = 0.03
"""Nothing that is looked for stands nearer to the edge, or to something else, than this [m]."""
AROUND = 0.12
"""Points so near to each other can be looked at together [m]."""
BEHIND = 0.25
"""Something may be hidden behind an object that is so near [m]."""


class Hidden:
    """What of a surface has not been seen since the search of it began.

    A thing is recognised when a good part of it is seen at once. So a point counts as seen when the robot has seen it
    and its neighbours in the same look.

    Args:
        robot: Knows which points it sees.
        surface: As it is used: a drawer is open.
    """

    def __init__(self, robot: Robot, surface: Surface) -> None:
        self._robot = robot
        points = [(x, y, z + HEIGHT) for x, y, z in points_on(surface, SPACING, NARROW)]
        row = len(steps(surface.size[1], SPACING, NARROW))
        self._points = {divmod(index, row): point for index, point in enumerate(points)}
        self._unseen = set(self._points)

    def looked(self, known: Iterable[Individual]) -> None:
        """Something was looked at: what the robot sees now is known to be empty.

        Args:
            known: The objects that are known to stand there.
        """
        free = self._free(self._points, known)
        seen = dict(zip(free, self._robot.sees([self._points[cell] for cell in free]), strict=True))
        self._unseen -= {
            (i, j)
            for i, j in self._unseen
            if all(seen.get(cell, True) for cell in ((i, j), (i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)))
        }

    def points(self, known: Iterable[Individual]) -> tuple[Point, ...]:
        """Points near each other where something may be hidden, the middle one first; none when nothing can be.

        Args:
            known: The objects that are known to stand there.
        """
        free = [self._points[cell] for cell in self._free(self._unseen, known)]
        groups = ([other for other in free if math.dist(point, other) < AROUND] for point in free)
        best = max(groups, key=len, default=[])
        middle = [sum(values) / len(best) for values in zip(*best, strict=True)]
        return tuple(sorted(best, key=lambda point: math.dist(point, middle)))

    def behind(self, known: Iterable[Individual]) -> Individual | None:
        """The object behind which something may be hidden, if there is one."""
        known = tuple(known)
        for point in self.points(known)[:1]:
            near = [(math.dist(item.position[:2], point[:2]), item) for item in known if item.position]
            return min((pair for pair in near if pair[0] < BEHIND), key=lambda pair: pair[0], default=(0.0, None))[1]
        return None

    def _free(self, cells: Iterable[Cell], known: Iterable[Individual]) -> list[Cell]:
        """Those of some cells in which nothing known stands, and to which it leaves room."""
        stand = [(item.position, radius(item.extent) + NARROW) for item in known if item.position]
        return sorted(
            cell for cell in cells if all(math.dist(at[:2], self._points[cell][:2]) > room for at, room in stand)
        )
