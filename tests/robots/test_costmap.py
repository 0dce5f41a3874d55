import numpy as np
import pytest

from attune.robots.interface import BasePose
from attune.robots.mujoco.costmap import Costmap, Footprint, footprint
from attune.robots.mujoco.route import find_route
from attune.robots.mujoco.solids import Solid


def box(x: float, y: float, half_x: float, half_y: float, low: float = 0.0, high: float = 1.5) -> Solid:
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    return Solid(np.array([(x + i * half_x, y + j * half_y) for i, j in corners]), low, high)


ROOM = [box(0, 3, 3, 0.05), box(0, -3, 3, 0.05), box(3, 0, 0.05, 3), box(-3, 0, 0.05, 3)]
BODY: Footprint = footprint([box(0, 0, 0.33, 0.33, 0.0, 0.3), box(-0.1, 0, 0.2, 0.2, 0.3, 1.4)])


def clearance(costmap: Costmap, *poses: tuple[float, float, float]) -> np.ndarray:
    return costmap.clearance(np.array(poses), BODY)


def test_clearance_is_the_distance_from_the_outline_to_the_nearest_obstacle() -> None:
    costmap = Costmap([*ROOM, box(1.0, 0, 0.1, 1.0)])
    measured = clearance(costmap, (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.7, 0.0, 0.0))
    assert measured[:2] == pytest.approx([0.57, 0.27], abs=0.06)
    assert measured[2] < 0


def test_a_turned_square_reaches_farther() -> None:
    costmap = Costmap([*ROOM, box(1.0, 0, 0.1, 1.0)])
    straight, turned = clearance(costmap, (0.4, 0.0, 0.0), (0.4, 0.0, np.pi / 4))
    assert turned < straight - 0.08


def test_the_base_fits_under_a_top_that_is_higher_than_it_but_the_torso_does_not() -> None:
    costmap = Costmap([*ROOM, box(1.0, 0, 0.5, 1.0, 0.7, 0.75)])
    under, too_far = clearance(costmap, (0.3, 0.0, 0.0), (0.6, 0.0, 0.0))
    assert under > 0.02
    assert too_far < 0


def test_a_route_goes_round_an_obstacle_without_touching_it() -> None:
    costmap = Costmap([*ROOM, box(0.0, 0.6, 0.1, 1.8)])
    route = find_route(costmap, BODY, BasePose(-1.5, 1.0, 0.0), BasePose(1.5, 1.0, 1.57))
    assert route is not None
    line = np.concatenate([np.linspace(a, b, 50) for a, b in zip(route, route[1:], strict=False)])
    assert clearance(costmap, *map(tuple, line)).min() > -0.01
    assert route[0] == pytest.approx([-1.5, 1.0, 0.0])
    assert route[-1] == pytest.approx([1.5, 1.0, 1.57], abs=1e-6)


def test_there_is_no_route_through_a_wall() -> None:
    costmap = Costmap([*ROOM, box(0.0, 0.0, 0.1, 3.0)])
    assert find_route(costmap, BODY, BasePose(-1.5, 0.0, 0.0), BasePose(1.5, 0.0, 0.0)) is None


def test_the_robot_looks_where_it_drives_on_a_long_way() -> None:
    costmap = Costmap(ROOM)
    route = find_route(costmap, BODY, BasePose(0.0, -2.2, 0.0), BasePose(0.0, 2.2, 0.0))
    assert route is not None
    middle = route[np.argmin(np.abs(route[:, 1]))]
    assert middle[2] == pytest.approx(np.pi / 2, abs=0.2)
