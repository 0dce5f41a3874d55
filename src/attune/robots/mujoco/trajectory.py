"""Joint paths with a time law: how fast a path may be followed within velocity and acceleration limits.

The path is the polyline through the given points with its corners rounded; the time law is the fastest one that
starts and ends at rest and respects the limits. Following it at a lower speed (`scale` of the controller) never leaves
the path, which is how a halt stops the robot on its way without overshoot.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_CURVE_SHARE = 0.6
"""Share of the acceleration that bends may use; the rest is left for speeding up and braking."""
_STEP = 0.01
"""Between two points of a trajectory's path, as the time it takes at full speed [s]."""
_NARROWINGS = 8
"""Times that the rounding of corners is made sharper, at most."""
_NARROWING = 0.5
"""How fast the window over which a corner is rounded narrows along the path."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the joints of one group can do, shape (n,) each: velocity [rad/s or m/s], acceleration [.../s^2]."""

    velocity: Array
    acceleration: Array

    def scaled(self, share: float) -> "Limits":
        """A share of the speed, in as many times the time."""
        return Limits(share * self.velocity, share * self.acceleration)


class Trajectory:
    """A timed path of n joints, at rest at both ends.

    Args:
        path: Points at equal steps of the path coordinate, shape (m, n), m >= 2.
        speed: The path coordinate's speed at each point, shape (m,); its unit of length is one step.
    """

    def __init__(self, path: Array, speed: Array) -> None:
        self._path = path
        steps = 2.0 / np.maximum(speed[1:] + speed[:-1], 1e-9)
        # Looked up one by one at every tick, where lists are faster than arrays.
        self._speed: list[float] = speed.tolist()
        self._times: list[float] = [0.0, *np.cumsum(steps).tolist()]

    @property
    def duration(self) -> float:
        """How long it takes at full speed [s]."""
        return self._times[-1]

    @property
    def start(self) -> Array:
        """Joint positions at the beginning, shape (n,)."""
        return cast("Array", self._path[0].copy())

    @property
    def end(self) -> Array:
        """Joint positions at the end, shape (n,)."""
        return cast("Array", self._path[-1].copy())

    @property
    def points(self) -> Array:
        """The path in small steps, shape (m, n): what a collision check looks at."""
        return self._path.copy()

    def sample(self, time: float) -> tuple[Array, Array]:
        """Positions and velocities at `time` [s], held at the ends; shape (n,) each."""
        if time <= 0.0:
            return self.start, np.zeros(self._path.shape[1])
        if time >= self.duration:
            return self.end, np.zeros(self._path.shape[1])
        i = bisect_right(self._times, time) - 1
        elapsed = time - self._times[i]
        span = self._times[i + 1] - self._times[i]
        acceleration = (self._speed[i + 1] - self._speed[i]) / span
        along = self._speed[i] * elapsed + 0.5 * acceleration * elapsed**2
        step = self._path[i + 1] - self._path[i]
        return self._path[i] + along * step, (self._speed[i] + acceleration * elapsed) * step


def plan_trajectory(waypoints: Array, limits: Limits, blend: float = 0.1, tolerance: float = math.inf) -> Trajectory:
    """The fastest trajectory along a polyline.

    Args:
        waypoints: Shape (m, n). Continuous joints must be unwrapped. All points equal gives a path of no duration.
        limits: Of the n joints.
        blend: How much of the path a corner is rounded over, as the time [s] it takes at full speed. The rounded
            path leaves the polyline by at most blend/8 times the change of velocity at the corner.
        tolerance: How far a joint of the rounded path may be from the polyline [rad or m]: corners are sharper for it.
    """
    waypoints = np.asarray(waypoints, dtype=float)
    lengths = np.linalg.norm(np.diff(waypoints, axis=0) / limits.velocity, axis=1)
    keep = np.concatenate(([True], lengths > 1e-9))
    knots = np.concatenate(([0.0], np.cumsum(lengths[lengths > 1e-9])))
    points = waypoints[keep]
    if len(points) == 1:
        return Trajectory(np.repeat(points, 2, axis=0), np.array([1e9, 1e9]))
    count = max(8, int(np.ceil(knots[-1] / (_STEP if math.isinf(tolerance) else _STEP / 2))))
    at = np.linspace(0.0, knots[-1], count + 1)
    path = _rounded(at, knots, points, blend, tolerance)
    return Trajectory(path, _fastest(path, limits))


def _rounded(at: Array, knots: Array, points: Array, blend: float, tolerance: float) -> Array:
    """The moving average of the polyline over a window of width `blend` that shrinks towards the ends.

    Where the average is farther than `tolerance` from the polyline, the window is narrower.
    """
    line = _interpolate(at, knots, points)
    if len(points) == 2 or blend <= 0.0:
        return line
    half = np.minimum(blend / 2, np.minimum(at, knots[-1] - at))
    for _ in range(_NARROWINGS):
        path = _averaged(at, knots, points, half)
        excess = np.abs(path - line).max(axis=1) / tolerance
        if excess.max() <= 1.0:
            break
        # A window that narrows faster than it moves on would make the path go backwards.
        wanted = half / np.maximum(1.0, 1.1 * excess)
        steps = _NARROWING * np.arange(len(at)) * (at[1] - at[0])
        half = np.minimum(
            np.minimum.accumulate(wanted - steps) + steps, np.minimum.accumulate((wanted + steps)[::-1])[::-1] - steps
        )
    return path


def _averaged(at: Array, knots: Array, points: Array, half: Array) -> Array:
    """The means of the polyline over windows around `at`, half so wide each; exact, from the polyline's integral."""
    half = np.maximum(half, 1e-6 * knots[-1])
    low, high = np.clip(at - half, 0.0, knots[-1]), np.clip(at + half, 0.0, knots[-1])
    segments = np.diff(knots)[:, None] * (points[1:] + points[:-1]) / 2
    whole = np.concatenate((np.zeros((1, points.shape[1])), np.cumsum(segments, axis=0)))

    def integral(s: Array) -> Array:
        i = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(knots) - 2)
        rest = (s - knots[i])[:, None]
        slope = (points[i + 1] - points[i]) / (knots[i + 1] - knots[i])[:, None]
        return whole[i] + rest * points[i] + slope * rest**2 / 2

    rounded = (integral(high) - integral(low)) / (high - low)[:, None]
    rounded[0], rounded[-1] = points[0], points[-1]
    return np.asarray(rounded)


def _interpolate(at: Array, knots: Array, points: Array) -> Array:
    return np.stack([np.interp(at, knots, column) for column in points.T], axis=1)


def _fastest(path: Array, limits: Limits) -> Array:
    """Speeds at the points of `path` (in steps per second): as fast as the limits allow, at rest at the ends."""
    first = np.gradient(path, axis=0)
    second = np.gradient(first, axis=0)
    with np.errstate(divide="ignore"):
        by_velocity = np.min(limits.velocity / np.abs(first), axis=1)
        by_curve = np.min(np.sqrt(_CURVE_SHARE * limits.acceleration / np.abs(second)), axis=1)
        acceleration = np.min(
            (1 - _CURVE_SHARE * (np.abs(second) > 1e-9)) * limits.acceleration / np.abs(first), axis=1
        )
    squared = np.minimum(by_velocity, by_curve) ** 2
    squared[0] = squared[-1] = 0.0
    gain = np.minimum(acceleration[1:], acceleration[:-1]) * 2
    for i in range(1, len(squared)):
        squared[i] = min(squared[i], squared[i - 1] + gain[i - 1])
    for i in range(len(squared) - 2, -1, -1):
        squared[i] = min(squared[i], squared[i + 1] + gain[i])
    return cast("Array", np.sqrt(squared))
