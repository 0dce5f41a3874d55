"""The simulated world: physics of the PR2, the kitchen and its objects. Physics is always on.

One assumption helps the fingers. As soon as both pads of a closing gripper press the same object with more than
`GRASP_FORCE`, it is fixed to the palm as it lies there, until the gripper opens; what is not pressed by both pads is a
free body. Handles are held in the same way, but turn in the hand. With `friction_only` objects are held by the pads'
friction alone (handles still need the help), and time steps are half as long.
"""

import threading
from collections.abc import Iterable, Mapping, Sequence
from math import cos, sin
from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.core.messages import ObjectSpec
from attune.core.scene import Scene
from attune.robots.interface import ARMS, Arm, BasePose, Point, Pose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.grip import Grip
from attune.robots.mujoco.kitchen import joint_name
from attune.robots.mujoco.model import world_spec
from attune.robots.mujoco.regions import Regions
from attune.robots.mujoco.things import free_joint
from attune.robots.mujoco.touch import Touch
from attune.robots.simulated import TrueObject

TICK = 0.02
"""Control period [s]."""
GRASP_FORCE = 2.0
"""With which both pads must press [N]."""
_SETTLING = 0.4
"""Time in which the objects come to rest before the world begins [s]."""
_GONE = 50.0
"""Where removed objects are [m]."""
_UPRIGHT = cos(np.radians(20))

Array = NDArray[np.float64]


class World:
    """The simulation's state, and everything that moves it. Each method may be called from any thread.

    Args:
        scene: What the kitchen is made of.
        friction_only: Hold objects by friction alone.

    Attributes:
        model: The compiled MuJoCo model. Not changed after construction.
        data: Its state; hold `lock` while reading or writing it.
        lock: Guards `data`.
        scene: The scene.
    """

    def __init__(self, scene: Scene, *, friction_only: bool = False) -> None:
        self.scene = scene
        spec = world_spec(scene, friction_only=friction_only)
        spec.compiler.discardvisual = True  # What is only looked at would take part in every search for contacts.
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self.lock = threading.RLock()
        self._substeps = round(TICK / self.model.opt.timestep)
        self._touch = Touch(self.model, scene)
        self._regions = Regions(scene)
        self._grips = {arm: Grip(self.model, scene, arm, friction_only=friction_only) for arm in ARMS}
        self._gone: set[str] = set()
        robot_joints = [*pr2.SERVOS, *(joint for arm in ARMS for joint in pr2.FINGER_JOINTS[arm])]
        self._robot_dofs = np.array([self.model.joint(joint).dofadr[0] for joint in robot_joints])
        self._ctrl = self.data.ctrl  # A view: it follows the state.
        self._velocities = np.zeros(self.model.nu)
        self._actuators: dict[tuple[str, ...], NDArray[np.intp]] = {}
        self._feed_forward = np.zeros(self.model.nu)
        for joint, servo in pr2.SERVOS.items():
            self._feed_forward[self._actuators_of((joint,))] = servo.damping / servo.stiffness
        for joint, position in pr2.start_posture(BasePose(*scene.robot_start)).items():
            self.data.qpos[self.model.joint(joint).qposadr[0]] = position
            if joint in pr2.SERVOS:
                self.command(joint, position)
        for _ in range(round(_SETTLING / TICK)):
            self.tick()
        self.data.time = 0.0

    # --- time ---------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time since the beginning [s]."""
        return float(self.data.time)

    def tick(self) -> None:
        """Simulate one control period."""
        with self.lock:
            for grip in self._grips.values():
                grip.drive(self.data, TICK)
            # The targets move on within the period, so that the joints do not jerk from one to the next.
            if self._velocities.any():
                targets, step = self._ctrl, self._velocities * self.model.opt.timestep
                targets -= step * self._substeps
                for _ in range(self._substeps):
                    targets += step
                    mujoco.mj_step(self.model, self.data)
                self._velocities[:] = 0.0
            else:
                mujoco.mj_step(self.model, self.data, self._substeps)
            self._touch.update(self.data, {arm: grip.held for arm, grip in self._grips.items()})
            for arm, grip in self._grips.items():
                grip.update(self.data, self._touch.pressed_by_both(arm, GRASP_FORCE))

    # --- what the robot commands --------------------------------------------------------------------------------

    def command(self, joint: str, position: float, velocity: float = 0.0) -> None:
        """Set the target of a joint's servo: see `command_together`."""
        self.command_together((joint,), np.array([position]), np.array([velocity]))

    def command_together(self, joints: Sequence[str], position: Array, velocity: Array) -> None:
        """Set the targets of joints' servos.

        Args:
            joints: Some of `pr2.SERVOS`.
            position: Where they should be at the end of the next tick, shape (n,) [m or rad].
            velocity: With which they should move meanwhile, shape (n,) [m/s or rad/s].
        """
        actuators = self._actuators_of(tuple(joints))
        with self.lock:
            self._ctrl[actuators] = position + self._feed_forward[actuators] * velocity
            self._velocities[actuators] = velocity

    def _actuators_of(self, joints: tuple[str, ...]) -> NDArray[np.intp]:
        if joints not in self._actuators:
            self._actuators[joints] = np.array([self.model.actuator(joint).id for joint in joints], dtype=np.intp)
        return self._actuators[joints]

    def command_gripper(self, arm: Arm, gap: float) -> None:
        """Open or close a gripper to a gap between its pads [m]; it moves with `pr2.GRIPPER_SPEED`.

        `pr2.GRIPPER_CLOSED` presses what is between the pads. A command to open lets go of it.
        """
        with self.lock:
            self._grips[arm].command(self.data, gap)

    # --- what the robot can measure -----------------------------------------------------------------------------

    def joint_position(self, joint: str) -> float:
        """Of any joint of robot or furniture [m or rad]."""
        with self.lock:
            return float(self.data.qpos[self.model.joint(joint).qposadr[0]])

    def base(self) -> BasePose:
        """Where the base stands."""
        return BasePose(*(self.joint_position(joint) for joint in pr2.BASE_JOINTS))

    def gripper_gap(self, arm: Arm) -> float:
        """Gap between the pads now [m]."""
        with self.lock:
            return self._grips[arm].gap(self.data)

    def pad_forces(self, arm: Arm) -> Mapping[str, tuple[float, float]]:
        """What the pads press, and how hard each does (left pad, right pad) [N]. A handle has its container's name."""
        with self.lock:
            return self._touch.pad_forces(arm)

    def held(self, arm: Arm) -> str | None:
        """The object in a gripper: both pads press it, or pressed it and have not opened since."""
        with self.lock:
            return self._grips[arm].held

    def gripped_handle(self, arm: Arm) -> str | None:
        """The container whose handle a gripper holds."""
        with self.lock:
            return self._grips[arm].handle

    def speeds(self) -> Array:
        """Speed of each of the robot's joints [m/s or rad/s]."""
        with self.lock:
            return cast("Array", np.abs(self.data.qvel[self._robot_dofs]))

    def speed(self) -> float:
        """The fastest motion of any of the robot's joints [m/s or rad/s]."""
        return float(self.speeds().max())

    def snapshot(self) -> Array:
        """All joint positions, `model.nq` of them: a copy to plan with."""
        with self.lock:
            return cast("Array", self.data.qpos.copy())

    # --- touching -----------------------------------------------------------------------------------------------

    def permit(self, arm: Arm, things: Iterable[str]) -> None:
        """Say what this gripper may touch besides what it holds: names of objects and containers (their handles)."""
        with self.lock:
            self._touch.permit(arm, things)

    def forbidden_contacts(self) -> tuple[tuple[str, str], ...]:
        """Contacts at the end of the last tick that should not be: robot part and the thing that it touches."""
        with self.lock:
            return self._touch.forbidden({arm: grip.held for arm, grip in self._grips.items()})

    def lower(self, arm: Arm | None) -> None:
        """Say that what an arm carries may now be set on something; None ends it."""
        with self.lock:
            self._touch.lower(arm)

    def bumps(self) -> tuple[tuple[str, str], ...]:
        """Contacts at the end of the last tick of carried objects with what they neither left nor are put on.

        Object, and the thing that it touches. The robot does not feel these; judges see them.
        """
        with self.lock:
            return self._touch.bumps

    # --- the truth about objects and furniture ------------------------------------------------------------------

    @property
    def object_names(self) -> tuple[str, ...]:
        """The objects that are there."""
        return tuple(thing.name for thing in self.scene.objects if thing.name not in self._gone)

    def object_pose(self, name: str) -> Pose:
        """Where an object is: its bottom centre and orientation, map frame."""
        with self.lock:
            body = self.data.body(name)
            return Pose(_point(body.xpos), cast("tuple[float, float, float, float]", tuple(body.xquat.tolist())))

    def extent(self, name: str) -> Point:
        """Size of an object's bounding box along its own axes [m]."""
        return self.scene.shape(name).extent

    def is_upright(self, name: str) -> bool:
        """Whether an object's axis is within 20 degrees of upright."""
        with self.lock:
            return bool(self.data.body(name).xmat[8] >= _UPRIGHT)

    def place_of(self, name: str) -> str:
        """Name of the surface that an object rests on or in; "" when it is held, or on the floor."""
        with self.lock:
            if name in self._gone or any(grip.held == name for grip in self._grips.values()):
                return ""
            return self._regions.at(_point(self.data.body(name).xipos), self.container_position)

    def container_position(self, name: str) -> float:
        """How far a container is open [m or rad]."""
        return self.joint_position(joint_name(name))

    def true_objects(self) -> Mapping[str, TrueObject]:
        """All objects of the world by name."""
        with self.lock:
            return {name: self._true_object(name) for name in self.object_names}

    def _true_object(self, name: str) -> TrueObject:
        thing, place = self.scene.object(name), self.place_of(name)
        kind = self.scene.surface(place).place if place else ""
        spec = ObjectSpec(type=thing.type, color=thing.color, size=thing.size, location=kind, name=name)
        holder = next((arm for arm in ARMS if self._grips[arm].held == name), None)
        return TrueObject(spec, place, self.object_pose(name).position, holder, self.is_upright(name))

    # --- what other people do -----------------------------------------------------------------------------------

    def move_object(self, name: str, position: Point, yaw: float = 0.0) -> None:
        """Put an object somewhere, upright, at rest; also out of a gripper. `position` is its bottom centre."""
        with self.lock:
            for grip in self._grips.values():
                grip.lose(self.data, name)
            self._gone.discard(name)
            joint = self.model.joint(free_joint(name))
            start, speed = joint.qposadr[0], joint.dofadr[0]
            self.data.qpos[start : start + 7] = (*position, cos(yaw / 2), 0.0, 0.0, sin(yaw / 2))
            self.data.qvel[speed : speed + 6] = 0.0
            self._wake()
            mujoco.mj_forward(self.model, self.data)

    def turn_in_hand(self, arm: Arm, rotation: Array) -> None:
        """Turn what a gripper holds between its pads: a rotation in the tool frame, shape (3, 3)."""
        with self.lock:
            self._grips[arm].turn(self.data, rotation)
            mujoco.mj_forward(self.model, self.data)

    def remove_object(self, name: str) -> None:
        """Take an object away for good (`move_object` brings it back)."""
        with self.lock:
            index = self.scene.objects.index(self.scene.object(name))
            self.move_object(name, (_GONE + index, _GONE, 0.0))
            self._gone.add(name)

    def move_container(self, name: str, position: float) -> None:
        """Open or close a container by an unseen hand [m or rad]; what lies in a drawer moves along."""
        with self.lock:
            container, surface = self.scene.container(name), self.scene.surface(name)
            share = (position - self.container_position(name)) / container.opened
            inside = [thing for thing in self.object_names if self.place_of(thing) == name]
            joint = self.model.joint(joint_name(name))
            self.data.qpos[joint.qposadr[0]] = position
            self.data.qvel[joint.dofadr[0]] = 0.0
            for thing in inside:
                start = self.model.joint(free_joint(thing)).qposadr[0]
                self.data.qpos[start : start + 3] += share * np.array(surface.shift)
            self._wake()
            mujoco.mj_forward(self.model, self.data)

    def _wake(self) -> None:
        # Sleepers are not simulated, so they would not notice that their neighbour or support is gone. MuJoCo wakes
        # what has any velocity.
        velocity = self.data.qvel
        velocity[velocity == 0.0] = 1e-9


def _point(values: Array) -> Point:
    return float(values[0]), float(values[1]), float(values[2])
