"""Closed-form inverse kinematics of the PR2's arms.

The arm is a shoulder (pan, lift and roll, the pan axis 0.1 m behind the others), an elbow and a wrist whose three axes
meet in a point. Once the shoulder's pan is chosen, the other six joints follow: the elbow from the distance between
shoulder and wrist, shoulder lift and roll from the wrist's position, the wrist's joints from the hand's orientation.
So the whole set of solutions of a pose is a curve over the pan angle (two branches), and it is computed for many poses
at once. Nothing is searched, stored or iterated.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm

Array = NDArray[np.float64]

ARM_JOINTS = (
    "shoulder_pan_joint", "shoulder_lift_joint", "upper_arm_roll_joint", "elbow_flex_joint", "forearm_roll_joint",
    "wrist_flex_joint", "wrist_roll_joint",
)  # fmt: skip


def arm_joints(arm: Arm) -> tuple[str, ...]:
    """Names of the arm's joints from the shoulder to the wrist."""
    return tuple(f"{arm[0]}_{joint}" for joint in ARM_JOINTS)


@dataclass(frozen=True, slots=True)
class ArmGeometry:
    """One arm's measures.

    Attributes:
        shoulder: Origin of the shoulder pan joint in the frame of the torso's link, shape (3,) [m].
        offset: From the pan axis to the lift axis [m].
        upper: From the lift axis to the elbow [m].
        fore: From the elbow to the wrist [m].
        tool: From the wrist to the tool frame between the fingertips [m].
        low, high: Joint limits, shape (7,); infinite where the joint is continuous.
    """

    shoulder: Array
    offset: float
    upper: float
    fore: float
    tool: float
    low: Array
    high: Array


def rotation(axis: int, angle: Array | float) -> Array:
    """Rotation matrices about the x (0), y (1) or z (2) axis, shape (..., 3, 3)."""
    angle = np.asarray(angle, dtype=float)
    cosine, sine = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., axis, axis] = 1.0
    matrix[..., i, i] = matrix[..., j, j] = cosine
    matrix[..., i, j], matrix[..., j, i] = -sine, sine
    return matrix


def _about_z_and_y(first: Array, second: Array) -> Array:
    """`rotation(2, first) @ rotation(1, second)`, written out because it is needed most often, shape (n, 3, 3)."""
    c, s, cy, sy = np.cos(first), np.sin(first), np.cos(second), np.sin(second)
    rows = ((c * cy, -s, c * sy), (s * cy, c, s * sy), (-sy, np.zeros_like(c), cy))
    return np.moveaxis(np.array(rows), 2, 0)


def _about_x_and_y(first: Array, second: Array) -> Array:
    """`rotation(0, first) @ rotation(1, second)`, shape (n, 3, 3)."""
    c, s, cy, sy = np.cos(first), np.sin(first), np.cos(second), np.sin(second)
    rows = ((cy, np.zeros_like(c), sy), (s * sy, c, -s * cy), (-c * sy, s, c * cy))
    return np.moveaxis(np.array(rows), 2, 0)


class ArmKinematics:
    """Forward and inverse kinematics of one arm, in the frame of the torso's link."""

    def __init__(self, geometry: ArmGeometry) -> None:
        self.geometry = geometry
        self.continuous = ~np.isfinite(geometry.low)

    def forward(self, q: Array) -> tuple[Array, Array]:
        """Tool positions (n, 3) and rotations (n, 3, 3) of configurations (n, 7)."""
        g = self.geometry
        turned = rotation(2, q[:, 0])
        position = g.shoulder + g.offset * turned[:, :, 0]
        turned = turned @ rotation(1, q[:, 1]) @ rotation(0, q[:, 2])
        position = position + g.upper * turned[:, :, 0]
        turned = turned @ rotation(1, q[:, 3]) @ rotation(0, q[:, 4])
        position = position + g.fore * turned[:, :, 0]
        turned = turned @ rotation(1, q[:, 5]) @ rotation(0, q[:, 6])
        return position + g.tool * turned[:, :, 0], turned

    def elbow(self, q: Array) -> Array:
        """Positions of the elbow (n, 3) in configurations (n, 7)."""
        g = self.geometry
        turned = rotation(2, q[:, 0])
        lifted = turned @ rotation(1, q[:, 1])
        return g.shoulder + g.offset * turned[:, :, 0] + g.upper * lifted[:, :, 0]

    def inverse(
        self, position: Array, orientation: Array, pan: Array, branch: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """The configurations that reach poses with given shoulder pans.

        Args:
            position: Of the tool frame, shape (n, 3).
            orientation: Rotation matrices of the tool frame, shape (n, 3, 3).
            pan: Shoulder pan angles, shape (n,).
            branch: Which of the two ways to bend, +1 or -1, shape (n,).

        Returns:
            Configurations, shape (n, 7), and which of them exist and keep the joint limits, shape (n,). Continuous
            joints are within +-pi.
        """
        g = self.geometry
        wrist = position - g.shoulder - g.tool * orientation[:, :, 0]
        cosine, sine = np.cos(pan), np.sin(pan)
        v = np.stack(
            (
                cosine * wrist[:, 0] + sine * wrist[:, 1] - g.offset,
                cosine * wrist[:, 1] - sine * wrist[:, 0],
                wrist[:, 2],
            ),
            axis=1,
        )
        bend = (np.sum(v**2, axis=1) - g.upper**2 - g.fore**2) / (2 * g.upper * g.fore)
        exists = np.abs(bend) <= 1.0
        elbow = -np.arccos(np.clip(bend, -1.0, 1.0))
        along = g.upper + g.fore * np.cos(elbow)
        across = -g.fore * np.sin(elbow)
        side = np.divide(-v[:, 1], across, out=np.full_like(across, 2.0), where=across > 1e-6)
        exists &= np.abs(side) <= 1.0
        upward = branch * np.sqrt(np.maximum(0.0, 1.0 - np.clip(side, -1.0, 1.0) ** 2))
        roll = np.arctan2(side, upward)
        rise = across * upward
        lift = np.arctan2(v[:, 0] * rise - v[:, 2] * along, v[:, 0] * along + v[:, 2] * rise)
        fore_frame = _about_z_and_y(pan, lift) @ _about_x_and_y(roll, elbow)
        hand = np.swapaxes(fore_frame, 1, 2) @ orientation
        flex = -np.arccos(np.clip(hand[:, 0, 0], -1.0, 1.0))
        # hand = Rx(fore roll) Ry(flex) Rx(wrist roll), with sin(flex) <= 0
        fore_roll = np.arctan2(-hand[:, 1, 0], hand[:, 2, 0])
        wrist_roll = np.arctan2(-hand[:, 0, 1], -hand[:, 0, 2])
        q = np.stack((pan, lift, roll, elbow, fore_roll, flex, wrist_roll), axis=1)
        q += 2 * np.pi * ((q < g.low).astype(float) - (q > g.high).astype(float))  # the roll's range exceeds +-pi
        inside = np.all((q >= g.low) & (q <= g.high), axis=1)
        return q, exists & inside

    def solutions(self, position: Array, orientation: Array, pans: Array) -> tuple[Array, NDArray[np.intp]]:
        """All configurations for each pose over a grid of shoulder pans and both branches.

        Args:
            position: Shape (n, 3).
            orientation: Shape (n, 3, 3).
            pans: Shape (k,).

        Returns:
            Configurations, shape (m, 7), and the index of the pose each belongs to, shape (m,).
        """
        n, k = len(position), len(pans)
        index = np.repeat(np.arange(n), 2 * k)
        q, good = self.inverse(
            position[index], orientation[index], np.tile(np.repeat(pans, 2), n), np.tile(np.array([1.0, -1.0]), n * k)
        )
        return q[good], index[good]

    def pan_grid(self, step: float = 0.12) -> Array:
        """Shoulder pans over the joint's range, `step` [rad] apart."""
        low, high = self.geometry.low[0], self.geometry.high[0]
        return np.linspace(low + 0.01, high - 0.01, max(2, int((high - low) / step)))

    def branch(self, q: Array) -> Array:
        """Which branch each configuration lies on, shape (n,)."""
        return np.where(np.cos(q[:, 2]) >= 0.0, 1.0, -1.0)

    def unwrap(self, q: Array, near: Array) -> Array:
        """`q` with its continuous joints turned by whole turns to be nearest to `near`; shapes broadcast."""
        turns = np.where(self.continuous, np.round((near - q) / (2 * np.pi)), 0.0)
        return q + 2 * np.pi * turns
