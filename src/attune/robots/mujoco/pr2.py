"""The PR2's facts: names of joints and frames, their limits, and the postures it rests in.

Figures are those of the published robot description (package `pr2_description`); `pr2_body` builds the model from
them. Lengths in metres, angles in radians.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, pi
from types import MappingProxyType

from attune.robots.interface import Arm, BasePose

SIDE: Mapping[Arm, str] = MappingProxyType({"right": "r", "left": "l"})
"""Prefix of the names of an arm's parts."""

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
TORSO = "torso_lift_joint"
HEAD_JOINTS = ("head_pan_joint", "head_tilt_joint")
ARM_JOINT_KINDS = (
    "shoulder_pan", "shoulder_lift", "upper_arm_roll", "elbow_flex", "forearm_roll", "wrist_flex", "wrist_roll",
)  # fmt: skip
ARM_JOINTS: Mapping[Arm, tuple[str, ...]] = MappingProxyType(
    {arm: tuple(f"{side}_{kind}_joint" for kind in ARM_JOINT_KINDS) for arm, side in SIDE.items()}
)
"""The seven joints of each arm, shoulder to wrist. Each actuator is named after its joint."""
GRIPPER: Mapping[Arm, str] = MappingProxyType({arm: f"{side}_gripper_joint" for arm, side in SIDE.items()})
"""Actuator (and tendon) of each gripper; its position is the gap between the pads [m]."""
FINGER_JOINTS: Mapping[Arm, tuple[str, str]] = MappingProxyType(
    {arm: (f"{side}_gripper_l_finger_joint", f"{side}_gripper_r_finger_joint") for arm, side in SIDE.items()}
)
"""Each slides by half the gap."""
PADS: Mapping[Arm, tuple[str, str]] = MappingProxyType(
    {arm: (f"{side}_l_pad", f"{side}_r_pad") for arm, side in SIDE.items()}
)
"""Geoms that touch what is grasped."""
PALM: Mapping[Arm, str] = MappingProxyType({arm: f"{side}_gripper_palm_link" for arm, side in SIDE.items()})
"""Body that a grasped object is fixed to."""
TOOL_FRAME: Mapping[Arm, str] = MappingProxyType({arm: f"{side}_gripper_tool_frame" for arm, side in SIDE.items()})
"""Site between the pads: x points out of the gripper, y from the right pad to the left one, z is the hand's top."""
HEAD_CAMERA = "head_camera"
"""Camera on the head plate: looks along the plate's x."""
BASE_FOOTPRINT = "base_footprint"
"""Site on the floor under the base's middle."""

GRIPPER_OPEN = 0.085
GRIPPER_CLOSED = -0.01
"""Commanded to less than nothing, so that the servo presses whatever is between the pads."""
GRIPPER_SPEED = 0.1
"""Of the gap [m/s]."""
GRIPPER_FORCE = 25.0
"""At the pads [N]."""
TOOL_OFFSET = 0.18
"""From the wrist's axes to the tool frame."""
PAD_LENGTH = 0.036
"""Along the tool frame's x, half of it to each side of the tool frame."""
PAD_HEIGHT = 0.024
"""Along the tool frame's z."""
FINGER_THICKNESS = 0.018
"""Of one finger, along the tool frame's y."""

BASE_HALF_WIDTH = 0.334
"""Half of the square base's side."""
SHOULDER_OFFSETS: Mapping[Arm, tuple[float, float]] = MappingProxyType(
    {"right": (-0.05, -0.188), "left": (-0.05, 0.188)}
)
"""Axis of the shoulder's pan in the base's frame (x, y)."""
SHOULDER_HEIGHT = 0.790675
"""Of the shoulder above the floor, torso down."""


@dataclass(frozen=True, slots=True)
class Servo:
    """A joint and what drives it.

    Attributes:
        low: Lower limit [rad or m]; minus infinity when the joint has none.
        high: Upper limit.
        speed: Highest speed [rad/s or m/s].
        stiffness: Torque per error [Nm/rad or N/m].
        damping: Torque per speed error [Nm s/rad or N s/m].
        force: Highest torque or force [Nm or N].
        armature: Inertia of the motor, seen at the joint [kg m² or kg].
    """

    low: float
    high: float
    speed: float
    stiffness: float
    damping: float
    force: float
    armature: float = 0.0


def _servos() -> dict[str, Servo]:
    # Stiff and critically damped for the heaviest load, so that a stop takes a fraction of a second.
    servos = {
        "base_x": Servo(-inf, inf, 0.55, 6e5, 2.5e4, 2000.0),
        "base_y": Servo(-inf, inf, 0.55, 6e5, 2.5e4, 2000.0),
        "base_yaw": Servo(-inf, inf, 1.0, 6e4, 2.4e3, 800.0),
        TORSO: Servo(0.0, 0.31, 0.013, 1e5, 8e3, 5000.0),
        "head_pan_joint": Servo(-3.007, 3.007, 6.0, 500.0, 20.0, 20.0, 0.1),
        "head_tilt_joint": Servo(-0.471238, 1.39626, 5.0, 500.0, 20.0, 20.0, 0.1),
    }
    for arm, mirror in (("right", -1.0), ("left", 1.0)):
        limits_and_drives = (
            Servo(mirror * pi / 4 - 1.5, mirror * pi / 4 + 1.5, 2.088, 11000.0, 450.0, 150.0, 0.5),
            Servo(-0.5236, 1.3963, 2.082, 11000.0, 450.0, 150.0, 0.5),
            Servo(mirror * 1.55 - 2.35, mirror * 1.55 + 2.35, 3.27, 3200.0, 110.0, 80.0, 0.2),
            Servo(-2.3213, 0.0, 3.3, 3600.0, 120.0, 80.0, 0.2),
            Servo(-inf, inf, 3.6, 800.0, 22.0, 30.0, 0.1),
            Servo(-2.094, 0.0, 3.078, 800.0, 22.0, 30.0, 0.1),
            Servo(-inf, inf, 3.6, 300.0, 9.0, 20.0, 0.05),
        )
        side = "r" if arm == "right" else "l"
        servos |= {
            f"{side}_{kind}_joint": servo for kind, servo in zip(ARM_JOINT_KINDS, limits_and_drives, strict=True)
        }
    return servos


SERVOS: Mapping[str, Servo] = MappingProxyType(_servos())
"""Of every joint but the fingers'."""

TORSO_HEIGHT = 0.3
"""The torso's usual height above its lowest [m]; it lifts so slowly that it is best left there."""
PARKED: Mapping[Arm, tuple[float, ...]] = MappingProxyType(
    {
        "right": (-1.22, 1.19, -1.58, -2.19, 2.85, -0.71, -2.54),
        "left": (1.22, 1.19, 1.58, -2.19, -2.85, -0.71, 2.54),
    }
)
"""Arm postures for driving: close to the base's outline, the hands level and in front, their tops up."""


def start_posture(start: BasePose) -> dict[str, float]:
    """Joint positions of the robot at rest: arms parked, grippers closed, head level."""
    posture = dict.fromkeys(SERVOS, 0.0)
    posture |= dict(zip(BASE_JOINTS, (start.x, start.y, start.yaw), strict=True))
    posture[TORSO] = TORSO_HEIGHT
    for arm, joints in ARM_JOINTS.items():
        posture |= dict(zip(joints, PARKED[arm], strict=True))
        posture |= dict.fromkeys(FINGER_JOINTS[arm], 0.0)
    return posture
