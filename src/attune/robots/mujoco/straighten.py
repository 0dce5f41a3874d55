"""Turning the hand so that what lies askew in it is upright again."""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.arm_paths import joint_path
from attune.robots.mujoco.beliefs import Held
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import comfort, follow, stacked

Array = NDArray[np.float64]

ASKEW = np.radians(2.0)
"""What is tilted by less counts as upright [rad]."""
_STEP = 0.04
"""Between two poses of the turn [rad]."""
_RAISES = (0.0, 0.05, 0.1)
"""By which the hand is lifted meanwhile [m]."""
_TRIES = 10
"""Other postures of the arm that are tried."""


def tilt(world: Imagination, arm: Arm, held: Held) -> tuple[float, Array]:
    """How far what an arm holds is from upright: angle [rad], and the axis to turn it back about, map frame."""
    now = world.carried_frame(arm).rotation
    # The object's own direction that pointed up when it stood.
    is_up, should_be = now @ held.upright.T[:, 2], np.array([0.0, 0.0, 1.0])
    axis = np.cross(is_up, should_be)
    sine = float(np.linalg.norm(axis))
    angle = float(np.arctan2(sine, is_up @ should_be))
    return angle, axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])


def straightening_path(world: Imagination, arm: Arm, held: Held, rng: np.random.Generator) -> Array | None:
    """A free path of an arm, shape (n, 7), at whose end what it holds is upright; None if there is none.

    The object turns about its middle; if the arm cannot do that, it takes another posture.

    Args:
        world: Made with the object in the gripper, the arm as it is.
        arm: The arm.
        held: The object as it lies in the hand.
        rng: For the search.
    """
    angle, axis = tilt(world, arm, held)
    start, hand = world.arm(arm), world.tool(arm)
    carried = world.carried_frame(arm)
    pivot = carried.position + carried.rotation @ np.array([0.0, 0.0, held.percept.extent[2] / 2])
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    count = max(2, int(np.ceil(angle / _STEP)) + 1)
    ends: list[Frame] = []
    for lift in _RAISES:
        frames = []
        for share in np.linspace(0.0, 1.0, count):
            turn = _about(axis, share * angle)
            position = pivot + turn @ (hand.position - pivot) + np.array([0.0, 0.0, share * lift])
            frames.append(Frame(position, turn @ hand.rotation))
        path = follow(kinematics, torso, start, frames)
        if path is not None and world.all_free(arm, path[1:]):
            return path
        ends.append(frames[-1])
    q, _ = kinematics.solutions(*stacked(torso, ends), kinematics.pan_grid())
    for goal in q[np.argsort(comfort(kinematics, q), kind="stable")][:_TRIES]:
        path = joint_path(world, arm, start, goal, rng) if world.all_free(arm, goal[None]) else None
        if path is not None:
            return path
    return None


def _about(axis: Array, angle: float) -> Array:
    """The rotation about a unit axis, shape (3, 3)."""
    # A frame whose z is the axis, in which the rotation is one about z.
    other = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    basis = np.stack((x, np.cross(axis, x), axis), axis=1)
    return np.asarray(basis @ rotation(2, angle) @ basis.T)
