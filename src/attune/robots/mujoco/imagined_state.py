"""The robot's own copy of the kitchen: where it imagines everything to be, and how it moves there."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import ARMS, Arm, BasePose, Pose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.frames import Frame, frame_of, quaternion, torso_frame
from attune.robots.mujoco.kinematics import ArmKinematics
from attune.robots.mujoco.pr2_arm import arm_geometry

Array = NDArray[np.float64]

AWAY = 50.0
"""Where objects are that the robot does not know of [m]."""


class _InHand:
    """What an arm carries: moves with the palm, in one call, because it does so at every point of every path."""

    def __init__(self, model: Any, data: Any, arm: Arm, name: str) -> None:
        address = model.jnt_qposadr[model.body(name).jntadr[0]]
        palm, site = model.body(pr2.PALM[arm]).id, model.site(pr2.TOOL_FRAME[arm])
        self._site = site.pos.copy(), site.quat.copy()
        self._offset = np.zeros(3), np.zeros(4)
        # Views: they follow the state.
        self._palm = data.xpos[palm], data.xquat[palm]
        self._pose = data.qpos[address : address + 3], data.qpos[address + 3 : address + 7]

    def lay(self, in_hand: Frame) -> None:
        """Set its pose in the tool frame."""
        mujoco.mju_mulPose(*self._offset, *self._site, in_hand.position, quaternion(in_hand.rotation))

    def follow(self) -> None:
        """Move it to where the palm is now."""
        mujoco.mju_mulPose(*self._pose, *self._palm, *self._offset)


class ImaginedState:
    """One imagined state of robot and kitchen. Not for several threads at once.

    Args:
        model: The simulation's model; it is copied.
        qpos: The state of robot and furniture to start from.
        objects: Poses of all objects believed to be there, by name, without the carried ones.
        carried: The object in each gripper, with its pose in the tool frame.

    Attributes:
        model: The copy.
        data: Its state.
        carried: The object in each gripper, with its pose in the tool frame.
        kinematics: Of each arm.
        robot_root: Id of the robot's first body.
        unknown: Ids of the objects that the robot does not know of, or carries.
    """

    def __init__(
        self, model: Any, qpos: Array, objects: Mapping[str, Pose], carried: Mapping[Arm, tuple[str, Frame]]
    ) -> None:
        self.model = copy.copy(model)
        self.data = mujoco.MjData(self.model)
        self._qpos = self.data.qpos  # A view: it follows the state.
        self._qpos[:] = qpos
        self._arm_address = {arm: self.addresses(pr2.ARM_JOINTS[arm]) for arm in ARMS}
        self._base_address = self.addresses(pr2.BASE_JOINTS)
        self._torso_address = self.addresses((pr2.TORSO,))[0]
        self.carried = dict(carried)
        self.kinematics = {arm: ArmKinematics(arm_geometry(arm)) for arm in ARMS}
        self.robot_root = self.model.body_rootid[self.model.body(pr2.PALM["right"]).id]
        self.unknown: set[int] = set()
        for index, name in enumerate(object_names(model)):
            if name in objects:
                self.put(name, frame_of(objects[name]))
            else:
                self.put(name, Frame(np.array([AWAY + index, 0.0, 0.0]), np.eye(3)))
                self.unknown.add(self.model.body(name).id)
        self._in_hand = {arm: _InHand(self.model, self.data, arm, name) for arm, (name, _) in self.carried.items()}
        for arm, (_, in_hand) in self.carried.items():
            self._in_hand[arm].lay(in_hand)
        self._move_carried()

    def addresses(self, joints: Sequence[str]) -> NDArray[np.intp]:
        """Where the positions of joints are in `data.qpos`."""
        return np.array([self.model.joint(joint).qposadr[0] for joint in joints], dtype=np.intp)

    @property
    def base(self) -> BasePose:
        """Where the base stands."""
        x, y, yaw = (float(v) for v in self._qpos[self._base_address])
        return BasePose(x, y, yaw)

    @base.setter
    def base(self, pose: BasePose) -> None:
        self._qpos[self._base_address] = (pose.x, pose.y, pose.yaw)
        self._move_carried()

    def torso_frame(self) -> Frame:
        """Where the torso's link is: the frame of the arms' kinematics."""
        return torso_frame(self.base, self.torso_lift)

    @property
    def torso_lift(self) -> float:
        """The torso's height above its lowest [m]."""
        return float(self._qpos[self._torso_address])

    def arm(self, arm: Arm) -> Array:
        """Configuration of an arm, shape (7,)."""
        return cast("Array", self._qpos[self._arm_address[arm]])

    def set_arm(self, arm: Arm, q: Array) -> None:
        """Bend an arm; what it carries comes along."""
        self._qpos[self._arm_address[arm]] = q
        if arm in self.carried:
            self._move_carried()

    def set_gripper(self, arm: Arm, gap: float) -> None:
        """Set the gap between an arm's pads [m]."""
        self._qpos[self.addresses(pr2.FINGER_JOINTS[arm])] = gap / 2

    def set_joint(self, joint: str, position: float) -> None:
        """Move one joint, of a door for instance."""
        self._qpos[self.model.joint(joint).qposadr[0]] = position

    def site(self, name: str) -> Frame:
        """Where a site is now, in the map frame."""
        mujoco.mj_kinematics(self.model, self.data)
        site = self.data.site(name)
        return Frame(site.xpos.copy(), site.xmat.reshape(3, 3).copy())

    def put(self, name: str, frame: Frame) -> None:
        """Put an object somewhere; from now on the robot knows of it."""
        body = self.model.body(name)
        self.unknown.discard(body.id)
        address = self.model.jnt_qposadr[body.jntadr[0]]
        self._qpos[address : address + 3] = frame.position
        self._qpos[address + 3 : address + 7] = quaternion(frame.rotation)

    def tool(self, arm: Arm, q: Array | None = None) -> Frame:
        """The tool frame of an arm in the map frame, for a configuration or as it is bent now."""
        position, orientation = self.kinematics[arm].forward((self.arm(arm) if q is None else q)[None])
        return self.torso_frame() @ Frame(position[0], orientation[0])

    def set_in_hand(self, arm: Arm, in_hand: Frame) -> None:
        """Change how a carried object lies in the hand."""
        self.carried[arm] = (self.carried[arm][0], in_hand)
        self._in_hand[arm].lay(in_hand)
        self._move_carried()

    def carried_frame(self, arm: Arm) -> Frame:
        """Where the object in an arm's gripper is now, in the map frame."""
        return self.tool(arm) @ self.carried[arm][1]

    def _move_carried(self) -> None:
        if not self.carried:
            return
        mujoco.mj_kinematics(self.model, self.data)
        for held in self._in_hand.values():
            held.follow()


def object_names(model: Any) -> tuple[str, ...]:
    """Names of the movable objects: the bodies that move freely."""
    free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
    return tuple(model.body(body).name for body in free)
