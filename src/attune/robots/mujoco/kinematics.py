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
        self, position: Array, orientation: Array, pan: Array, branch: Array, pose: NDArray[np.intp] | None = None
    ) -> tuple[Array, NDArray[np.bool_]]:
        """The configurations that reach poses with given shoulder pans.

        Args:
            position: Of the tool frame, shape (n, 3).
            orientation: Rotation matrices of the tool frame, shape (n, 3, 3).
            pan: Shoulder pan angles, shape (m,).
            branch: Which of the two ways to bend, +1 or -1, shape (m,).
            pose: Which of the poses each pan is for, shape (m,); without it one for each, in their order.

        Returns:
            Configurations, shape (m, 7), and which of them exist and keep the joint limits, shape (m,); the others are
            zero. Continuous joints are within +-pi.
        """
        # This is called most often of all. Most pans cannot reach their pose, mostly because of the first joints: the
        # others are computed only for what is left. Products of matrices are written out where only some of their
        # entries are needed.
        g = self.geometry
        pose = np.arange(len(pan)) if pose is None else pose
        wrist = (position - g.shoulder - g.tool * orientation[:, :, 0])[pose].T
        cosine, sine = np.cos(pan), np.sin(pan)
        ahead = cosine * wrist[0] + sine * wrist[1] - g.offset
        aside = cosine * wrist[1] - sine * wrist[0]
        bend = (ahead**2 + aside**2 + wrist[2] ** 2 - g.upper**2 - g.fore**2) / (2 * g.upper * g.fore)
        # Where the elbow's cosine and the sine of the upper arm's roll exist.
        exists = (np.abs(bend) <= 1.0) & (aside**2 <= g.fore**2 * (1.0 - bend**2))
        left = np.flatnonzero(exists)
        ahead, aside, up, bend, branch = ahead[left], aside[left], wrist[2, left], bend[left], branch[left]
        bent = -np.sqrt(1.0 - bend**2)  # The elbow's sine.
        along, across = g.upper + g.fore * bend, -g.fore * bent
        side = np.minimum(1.0, np.maximum(-1.0, -aside / np.maximum(across, 1e-6)))  # The sine of the upper arm's roll.
        upward = branch * np.sqrt(1.0 - side**2)  # Its cosine.
        rise = across * upward
        lift = np.arctan2(ahead * rise - up * along, ahead * along + up * rise)
        within = np.flatnonzero((lift >= g.low[1]) & (lift <= g.high[1]))
        left, lift = left[within], lift[within]
        bend, bent, side, upward = bend[within], bent[within], side[within], upward[within]
        # The hand's axes, as rows, seen from the shoulder lift's link: x, y, z.
        hand = orientation[pose[left]].transpose(1, 2, 0)
        cosine, sine = cosine[left], sine[left]
        turned_x = cosine * hand[0] + sine * hand[1]
        y = cosine * hand[1] - sine * hand[0]
        cosine, sine = np.cos(lift), np.sin(lift)
        x = cosine * turned_x - sine * hand[2]
        z = sine * turned_x + cosine * hand[2]
        # And the rows of the hand's rotation in the forearm's frame, of which the first entry of the others suffices.
        rolled = side * y - upward * z
        first = bend * x + bent * rolled
        second = upward * y[0] + side * z[0]
        third = bent * x[0] - bend * rolled[0]
        # hand = Rx(fore roll) Ry(flex) Rx(wrist roll), with sin(flex) <= 0
        found = np.empty((len(left), 7))
        found[:, 0], found[:, 1] = pan[left], lift
        found[:, 2], found[:, 3] = np.arctan2(side, upward), np.arctan2(bent, bend)
        found[:, 4] = np.arctan2(-second, third)
        found[:, 5] = -np.arccos(np.minimum(1.0, np.maximum(-1.0, first[0])))
        found[:, 6] = np.arctan2(-first[1], -first[2])
        # The roll's range exceeds +-pi.
        found += 2 * np.pi * ((found < g.low).astype(float) - (found > g.high).astype(float))
        inside = np.logical_and.reduce((found >= g.low) & (found <= g.high), axis=1)
        q, good = np.zeros((len(pan), 7)), np.zeros(len(pan), dtype=bool)
        left = left[inside]
        q[left], good[left] = found[inside], True
        return q, good

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
        branch = np.tile(np.array([1.0, -1.0]), n * k)
        q, good = self.inverse(position, orientation, np.tile(np.repeat(pans, 2), n), branch, index)
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
