"""The measures of the PR2's arms, as their kinematics need them."""

import numpy as np

from attune.robots.interface import Arm
from attune.robots.mujoco import pr2
from attune.robots.mujoco.kinematics import ArmGeometry


def arm_geometry(arm: Arm) -> ArmGeometry:
    """The PR2's measures, for the closed-form kinematics; limits are kept by a little."""
    servos = [pr2.SERVOS[joint] for joint in pr2.ARM_JOINTS[arm]]
    return ArmGeometry(
        shoulder=np.array([0.0, pr2.SHOULDER_OFFSETS[arm][1], 0.0]),
        offset=0.1,
        upper=0.4,
        fore=0.321,
        tool=pr2.TOOL_OFFSET,
        low=np.array([servo.low + 0.02 for servo in servos]),
        high=np.array([servo.high - 0.02 for servo in servos]),
    )
