"""The PR2 as a MuJoCo model of primitive shapes: real kinematics, limits and masses, simplified surfaces.

Three simplifications, each on purpose. The base slides on two joints and turns on a third instead of rolling on
casters. The four-bar fingers slide in parallel. Gravity is compensated on the whole robot, as the real arms'
springs do.
"""

from collections.abc import Sequence
from math import isinf

import mujoco

from attune.robots.interface import ARMS, Arm
from attune.robots.mujoco import pr2
from attune.robots.mujoco.contact import FURNITURE, LEFT_ARM, OBJECT, RIGHT_ARM, TRUNK, VISUAL_GROUP

WHITE = (0.90, 0.90, 0.88, 1.0)
SILVER = (0.66, 0.68, 0.70, 1.0)
GREY = (0.42, 0.44, 0.46, 1.0)
DARK = (0.13, 0.13, 0.15, 1.0)
BLUE = (0.35, 0.50, 0.68, 1.0)
GLASS = (0.05, 0.08, 0.12, 1.0)

Rgba = tuple[float, float, float, float]


class _Builder:
    """Adds bodies and geoms of one contact class."""

    def __init__(self, spec: mujoco.MjSpec, contype: int, conaffinity: int) -> None:
        self._spec = spec
        self._contact = {"contype": contype, "conaffinity": conaffinity}

    def body(
        self,
        parent: mujoco.MjsBody,
        name: str,
        pos: Sequence[float],
        joint: str = "",
        axis: Sequence[float] = (0, 0, 1),
    ) -> mujoco.MjsBody:
        body = parent.add_body(name=name, pos=pos, gravcomp=1.0)
        if joint:
            self.joint(body, joint, axis)
        return body

    def joint(self, body: mujoco.MjsBody, name: str, axis: Sequence[float]) -> None:
        servo = pr2.SERVOS[name]
        slide = name in ("base_x", "base_y", pr2.TORSO)
        limits = {} if isinf(servo.low) else {"range": (servo.low, servo.high)}
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(name=name, type=kind, axis=axis, armature=servo.armature, **limits)
        actuator = self._spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcerange=(-servo.force, servo.force),
            forcelimited=True,
        )
        actuator.set_to_position(kp=servo.stiffness, kv=servo.damping)

    def box(
        self,
        body: mujoco.MjsBody,
        pos: Sequence[float],
        half: Sequence[float],
        color: Rgba,
        mass: float,
        **more: object,
    ) -> None:
        shape = mujoco.mjtGeom.mjGEOM_BOX
        body.add_geom(type=shape, pos=pos, size=half, rgba=color, mass=mass, **(self._contact | more))

    def round(
        self,
        body: mujoco.MjsBody,
        ends: Sequence[float],
        radius: float,
        color: Rgba,
        mass: float,
        shape: mujoco.mjtGeom = mujoco.mjtGeom.mjGEOM_CAPSULE,
        **more: object,
    ) -> None:
        body.add_geom(type=shape, fromto=ends, size=(radius, 0, 0), rgba=color, mass=mass, **(self._contact | more))


_LOOKS: dict[str, object] = {"contype": 0, "conaffinity": 0, "group": VISUAL_GROUP}
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER


def add_pr2(spec: mujoco.MjSpec) -> None:
    """Add the robot at the origin of the world, all joints at zero.

    Names of joints, actuators, sites and the camera are those in `attune.robots.mujoco.pr2`. Bodies are named
    after the PR2's links. `base_x` and `base_y` move a body of their own, which carries the one that `base_yaw`
    turns.

    Args:
        spec: What to add it to; its angles are set to radians.
    """
    spec.compiler.degree = False
    build = _Builder(spec, TRUNK, FURNITURE | OBJECT)
    carrier = build.body(spec.worldbody, "base_carrier", (0, 0, 0))
    build.joint(carrier, "base_x", (1, 0, 0))
    build.joint(carrier, "base_y", (0, 1, 0))
    # Without a mass of its own the carrier could not be simulated on its own in a copy without the rest.
    carrier.mass, carrier.inertia, carrier.explicitinertial = 1.0, (0.01, 0.01, 0.01), True
    base = build.body(carrier, "base_link", (0, 0, 0.051), "base_yaw")
    _add_base(build, base)
    torso = build.body(base, "torso_lift_link", (-0.05, 0, 0.739675), pr2.TORSO)
    _add_torso(build, torso)
    _add_head(build, torso)
    for arm in ARMS:
        _add_arm(spec, torso, arm)


def _add_base(build: _Builder, base: mujoco.MjsBody) -> None:
    base.add_site(name=pr2.BASE_FOOTPRINT, pos=(0, 0, -0.051), group=4)
    half = pr2.BASE_HALF_WIDTH
    build.box(base, (0, 0, 0.09), (half, half, 0.11), WHITE, 100.0)
    build.box(base, (-0.16, 0, 0.42), (0.165, 0.21, 0.22), WHITE, 16.0)
    build.box(base, (-0.16, 0, 0.42), (0.166, 0.15, 0.20), GREY, 0.0, **_LOOKS)
    build.box(base, (0, 0, 0.165), (half - 0.03, half + 0.001, 0.012), GREY, 0.0, **_LOOKS)
    build.box(base, (half - 0.05, 0, 0.225), (0.045, 0.05, 0.03), DARK, 0.0, **_LOOKS)
    for x in (-0.2246, 0.2246):
        for y in (-0.2246, 0.2246):
            ends = (x, y - 0.06, 0.028, x, y + 0.06, 0.028)
            build.round(base, ends, 0.075, DARK, 0.0, _CYLINDER, **_LOOKS)


def _add_torso(build: _Builder, torso: mujoco.MjsBody) -> None:
    # The column telescopes out of the base's rear half; the shoulders' bar sits on it.
    build.box(torso, (-0.15, 0, -0.12), (0.13, 0.16, 0.26), SILVER, 22.0)
    build.box(torso, (-0.10, 0, 0.19), (0.11, 0.22, 0.06), WHITE, 10.0)
    build.box(torso, (-0.03, 0, 0.285), (0.09, 0.09, 0.045), GREY, 4.0)
    build.box(torso, (0.055, 0, 0.227), (0.05, 0.06, 0.045), DARK, 0.0, **_LOOKS)
    build.box(torso, (-0.021, 0, -0.10), (0.002, 0.10, 0.20), DARK, 0.0, **_LOOKS)


def _add_head(build: _Builder, torso: mujoco.MjsBody) -> None:
    pan = build.body(torso, "head_pan_link", (-0.01707, 0, 0.38145), "head_pan_joint")
    build.round(pan, (0, 0, -0.05, 0, 0, 0.03), 0.075, GREY, 6.3, _CYLINDER)
    tilt = build.body(pan, "head_tilt_link", (0.068, 0, 0), "head_tilt_joint", (0, 1, 0))
    build.box(tilt, (0.0, 0, 0.075), (0.055, 0.165, 0.055), WHITE, 4.5)
    build.box(tilt, (0.054, 0, 0.085), (0.006, 0.155, 0.036), GLASS, 0.0, **_LOOKS)
    for y in (-0.115, -0.045, 0.045, 0.115):
        ends = (0.05, y, 0.085, 0.066, y, 0.085)
        build.round(tilt, ends, 0.02, SILVER, 0.0, _CYLINDER, **_LOOKS)
        build.round(tilt, (0.05, y, 0.085, 0.068, y, 0.085), 0.012, DARK, 0.0, _CYLINDER, **_LOOKS)
    build.box(tilt, (0.01, 0, 0.148), (0.03, 0.13, 0.018), DARK, 0.0, **_LOOKS)
    tilt.add_site(name="head_plate_frame", pos=(0.0232, 0, 0.0645), group=4)
    # A MuJoCo camera looks along its -z, with y up.
    tilt.add_camera(
        name=pr2.HEAD_CAMERA, pos=(0.0732, 0, 0.0845), quat=(0.5, 0.5, -0.5, -0.5), fovy=60.0, resolution=(640, 480)
    )


def _add_arm(spec: mujoco.MjSpec, torso: mujoco.MjsBody, arm: Arm) -> None:
    side = pr2.SIDE[arm]
    meets = FURNITURE | OBJECT | TRUNK
    build = _Builder(spec, RIGHT_ARM, meets | LEFT_ARM) if arm == "right" else _Builder(spec, LEFT_ARM, meets)
    joint = dict(zip(pr2.ARM_JOINT_KINDS, pr2.ARM_JOINTS[arm], strict=True))

    outwards = -1.0 if arm == "right" else 1.0
    pan = build.body(torso, f"{side}_shoulder_pan_link", (0, 0.188 * outwards, 0), joint["shoulder_pan"])
    build.round(pan, (0, 0, -0.24, 0, 0, 0.12), 0.085, WHITE, 25.8, _CYLINDER)
    build.box(pan, (0.05, 0, 0), (0.06, 0.05, 0.09), WHITE, 0.0, **_LOOKS)
    lift = build.body(pan, f"{side}_shoulder_lift_link", (0.1, 0, 0), joint["shoulder_lift"], (0, 1, 0))
    build.round(lift, (0, -0.075, 0, 0, 0.075, 0), 0.095, SILVER, 2.75, _CYLINDER)
    for link in (pan, lift):
        spec.add_exclude(bodyname1="torso_lift_link", bodyname2=link.name)
        spec.add_exclude(bodyname1="base_link", bodyname2=link.name)

    upper = build.body(lift, f"{side}_upper_arm_link", (0, 0, 0), joint["upper_arm_roll"], (1, 0, 0))
    build.box(upper, (0.21, 0, 0), (0.15, 0.062, 0.062), WHITE, 6.0)
    build.box(upper, (0.22, 0, 0.0), (0.09, 0.0635, 0.035), BLUE, 0.0, **_LOOKS)
    elbow = build.body(upper, f"{side}_elbow_flex_link", (0.4, 0, 0), joint["elbow_flex"], (0, 1, 0))
    build.round(elbow, (0, -0.055, 0, 0, 0.055, 0), 0.065, SILVER, 1.9, _CYLINDER)
    forearm = build.body(elbow, f"{side}_forearm_link", (0, 0, 0), joint["forearm_roll"], (1, 0, 0))
    build.round(forearm, (0.10, 0, 0, 0.245, 0, 0), 0.052, WHITE, 2.6)
    build.round(forearm, (0.07, 0, 0, 0.105, 0, 0), 0.057, DARK, 0.0, _CYLINDER, **_LOOKS)
    build.box(forearm, (0.17, 0, 0.036), (0.06, 0.026, 0.022), DARK, 0.0, **_LOOKS)
    wrist = build.body(forearm, f"{side}_wrist_flex_link", (0.321, 0, 0), joint["wrist_flex"], (0, 1, 0))
    build.round(wrist, (0, -0.032, 0, 0, 0.032, 0), 0.032, SILVER, 0.6, _CYLINDER)
    palm = build.body(wrist, pr2.PALM[arm], (0, 0, 0), joint["wrist_roll"], (1, 0, 0))
    _add_gripper(spec, build, palm, arm)


def _add_gripper(spec: mujoco.MjSpec, build: _Builder, palm: mujoco.MjsBody, arm: Arm) -> None:
    side = pr2.SIDE[arm]
    build.box(palm, (0.075, 0, 0), (0.04, 0.062, 0.024), GREY, 0.58)
    build.box(palm, (0.075, 0, 0.0245), (0.022, 0.03, 0.001), BLUE, 0.0, **_LOOKS)
    palm.add_site(name=pr2.TOOL_FRAME[arm], pos=(pr2.TOOL_OFFSET, 0, 0), group=4)

    reach = pr2.TOOL_OFFSET + pr2.PAD_LENGTH / 2
    thickness = pr2.FINGER_THICKNESS
    tendon = spec.add_tendon(name=pr2.GRIPPER[arm])
    for finger, pad, name, way in zip("lr", pr2.PADS[arm], pr2.FINGER_JOINTS[arm], (1.0, -1.0), strict=True):
        body = palm.add_body(name=f"{side}_gripper_{finger}_finger_link", gravcomp=1.0)
        body.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=(0, way, 0),
            range=(0.0, pr2.GRIPPER_OPEN / 2),
            armature=0.5,
        )
        tendon.wrap_joint(name, 1.0)
        middle = (0.09 + reach) / 2
        back = thickness / 2 + 0.004
        build.box(body, (middle, way * back, 0), (reach - middle, thickness / 2 - 0.004, 0.011), GREY, 0.17)
        build.box(
            body,
            (pr2.TOOL_OFFSET, way * 0.004, 0),
            (pr2.PAD_LENGTH / 2, 0.004, pr2.PAD_HEIGHT / 2),
            DARK,
            0.05,
            name=pad,
            friction=(1.5, 0.05, 0.001),
            condim=4,
            # The pads are stiff also against light things: their own figures hold, whatever they touch.
            priority=1,
            solref=(0.008, 1.0),
            solimp=(0.97, 0.995, 0.001, 0.5, 2.0),
        )
    left, right = pr2.FINGER_JOINTS[arm]
    # The real fingers are geared to each other, with some give: both still press what is a little off the middle.
    coupling = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT, name1=left, name2=right, name=f"{side}_finger_gear", solref=(0.04, 1.0)
    )
    coupling.data[:5] = (0, 1, 0, 0, 0)
    actuator = spec.add_actuator(
        name=pr2.GRIPPER[arm],
        target=pr2.GRIPPER[arm],
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        forcerange=(-pr2.GRIPPER_FORCE, pr2.GRIPPER_FORCE),
        forcelimited=True,
    )
    actuator.set_to_position(kp=3000.0, kv=70.0)
