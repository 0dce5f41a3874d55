"""One gripper: how it closes, and how it holds what both pads press."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.core.scene import Scene
from attune.robots.interface import Arm
from attune.robots.mujoco import pr2
from attune.robots.mujoco.kitchen import leaf_name

Array = NDArray[np.float64]

_STIFF = (0.008, 1.0)
"""Time constant [s] and damping ratio of the fixture; at least two time steps."""


def _hold_name(arm: Arm, thing: str) -> str:
    return f"{pr2.SIDE[arm]}_holds_{thing}"


class Grip:
    """The gripper of one arm. Its callers hold the world's lock.

    Args:
        model: The compiled model, with this gripper's constraints.
        scene: What there is to hold.
        arm: Which arm.
        friction_only: Hold objects without fixing them.

    Attributes:
        held: The object that it holds.
        handle: The container whose handle it holds.
    """

    def __init__(self, model: Any, scene: Scene, arm: Arm, *, friction_only: bool) -> None:
        self._model = model
        self._friction_only = friction_only
        self._objects = {thing.name for thing in scene.objects}
        self._constraints = {
            name: model.equality(_hold_name(arm, name)).id
            for name in (*self._objects, *(container.name for container in scene.containers))
        }
        self._palm = model.body(pr2.PALM[arm]).id
        self._tool = model.site(pr2.TOOL_FRAME[arm]).id
        self._actuator = model.actuator(pr2.GRIPPER[arm]).id
        self._fingers = [model.joint(joint).qposadr[0] for joint in pr2.FINGER_JOINTS[arm]]
        self._goal = 0.0
        self.held: str | None = None
        self.handle: str | None = None

    @staticmethod
    def add_constraints(spec: mujoco.MjSpec, scene: Scene, arm: Arm) -> None:
        """Add the fixtures of palm and object, and of palm and handle, all inactive."""
        bodies = [(thing.name, thing.name, mujoco.mjtEq.mjEQ_WELD) for thing in scene.objects]
        bodies += [(box.name, leaf_name(box.name), mujoco.mjtEq.mjEQ_CONNECT) for box in scene.containers]
        for name, body, kind in bodies:
            spec.add_equality(
                name=_hold_name(arm, name),
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                name1=pr2.PALM[arm],
                name2=body,
                active=False,
                solref=_STIFF,
            )

    def gap(self, data: Any) -> float:
        """Between the pads [m]."""
        positions = data.qpos
        return float(positions[self._fingers[0]] + positions[self._fingers[1]])

    def command(self, data: Any, gap: float) -> None:
        """Set the gap to move to; a wider one than now lets go."""
        self._goal = min(max(gap, pr2.GRIPPER_CLOSED), pr2.GRIPPER_OPEN)
        now = self.gap(data)
        if self._goal > now:
            data.ctrl[self._actuator] = max(data.ctrl[self._actuator], now)
            self._let_go(data)

    def drive(self, data: Any, duration: float) -> None:
        """Move the servo's target towards the goal."""
        step = pr2.GRIPPER_SPEED * duration
        target = data.ctrl[self._actuator]
        data.ctrl[self._actuator] = target + min(max(self._goal - target, -step), step)

    def update(self, data: Any, pressed: str | None) -> None:
        """Notice what both pads press now, and hold it.

        Args:
            data: The state.
            pressed: The one thing that both pads press.
        """
        closing = self._goal < self.gap(data)
        if self._friction_only and (self.held or pressed in self._objects):
            self.held = pressed if closing and pressed in self._objects else None
        elif pressed and closing and not (self.held or self.handle):
            self._fix(data, pressed)

    def lose(self, data: Any, name: str) -> None:
        """Stop holding an object that somebody took."""
        if self.held == name:
            self._let_go(data)

    def turn(self, data: Any, rotation: Array) -> None:
        """Turn the held object in the hand, about the middle between the pads.

        Args:
            data: The state.
            rotation: In the tool frame, shape (3, 3).
        """
        if self.held is None:
            return
        site, body = data.site_xmat[self._tool].reshape(3, 3), self._model.body(self.held)
        turn = site @ rotation @ site.T
        joint = self._model.jnt_qposadr[body.jntadr[0]]
        centre = data.site_xpos[self._tool]
        data.qpos[joint : joint + 3] = centre + turn @ (data.xpos[body.id] - centre)
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, (turn @ data.xmat[body.id].reshape(3, 3)).flatten())
        data.qpos[joint + 3 : joint + 7] = quat
        mujoco.mj_kinematics(self._model, data)
        self._fix(data, self.held)

    def _fix(self, data: Any, name: str) -> None:
        constraint = self._constraints[name]
        settings = self._model.eq_data[constraint]
        rotation = data.xmat[self._palm].reshape(3, 3)
        if name in self._objects:
            body = self._model.eq_obj2id[constraint]
            inverse, turn = np.zeros(4), np.zeros(4)
            mujoco.mju_negQuat(inverse, data.xquat[self._palm])
            mujoco.mju_mulQuat(turn, inverse, data.xquat[body])
            settings[0:3] = 0.0
            settings[3:6] = rotation.T @ (data.xpos[body] - data.xpos[self._palm])
            settings[6:10] = turn
            settings[10] = 1.0
            self.held = name
        else:
            leaf = self._model.eq_obj2id[constraint]
            point = data.site_xpos[self._tool]
            settings[0:3] = rotation.T @ (point - data.xpos[self._palm])
            settings[3:6] = data.xmat[leaf].reshape(3, 3).T @ (point - data.xpos[leaf])
            self.handle = name
        data.eq_active[constraint] = 1

    def _let_go(self, data: Any) -> None:
        for name in (self.held, self.handle):
            if name:
                data.eq_active[self._constraints[name]] = 0
        self.held = self.handle = None
