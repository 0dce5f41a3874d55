import numpy as np
import pytest

from attune.robots.mujoco.trajectory import Limits, plan_trajectory

LIMITS = Limits(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.5]])


def samples(path: np.ndarray, blend: float = 0.1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    trajectory = plan_trajectory(path, LIMITS, blend)
    times = np.arange(0.0, trajectory.duration + 0.01, 0.005)
    pairs = [trajectory.sample(float(time)) for time in times]
    return times, np.array([q for q, _ in pairs]), np.array([qd for _, qd in pairs])


def test_it_starts_and_ends_at_rest_where_the_path_does() -> None:
    _, q, qd = samples(CORNER)
    assert q[0] == pytest.approx(CORNER[0])
    assert q[-1] == pytest.approx(CORNER[-1])
    assert qd[0] == pytest.approx([0, 0], abs=1e-9)
    assert qd[-1] == pytest.approx([0, 0], abs=1e-9)


def test_no_joint_exceeds_its_velocity() -> None:
    _, _, qd = samples(CORNER)
    assert (np.abs(qd).max(axis=0) <= LIMITS.velocity * 1.01).all()


def test_velocity_is_the_change_of_position() -> None:
    times, q, qd = samples(CORNER)
    measured = np.gradient(q, times, axis=0)
    assert np.abs(measured - qd)[5:-5].max() < 0.1


def test_a_corner_is_rounded_by_no_more_than_its_blend() -> None:
    _, q, _ = samples(CORNER, blend=0.2)
    on_path = np.minimum(np.abs(q[:, 1]) + np.maximum(0, q[:, 0] - 1), np.abs(q[:, 0] - 1) + np.maximum(0, -q[:, 1]))
    assert on_path.max() < 0.2 / 8 * 2.0 * 1.5


def test_where_it_must_stay_near_the_corner_it_is_rounded_less() -> None:
    path = plan_trajectory(CORNER, LIMITS, blend=0.2, tolerance=0.002).points
    off = np.minimum(np.abs(path[:, 1]) + np.maximum(0, path[:, 0] - 1), np.abs(path[:, 0] - 1))
    assert 0.0 < off.max() <= 0.002 * 2  # Both joints may be off by so much.
    assert (np.diff(path, axis=0) >= -1e-9).all()


def test_a_straight_path_is_never_left() -> None:
    _, q, _ = samples(np.array([[0.0, 0.0], [1.0, 2.0]]))
    assert np.abs(q[:, 1] - 2 * q[:, 0]).max() < 1e-9


def test_a_path_that_goes_nowhere_takes_no_time() -> None:
    trajectory = plan_trajectory(np.array([[1.0, 2.0], [1.0, 2.0]]), LIMITS)
    assert trajectory.duration < 1e-6
    assert trajectory.sample(1.0)[0] == pytest.approx([1.0, 2.0])
