"""What a hand alone can do: grasps with free ways to them and from them, wherever the robot stands.

They are found before anything is asked of the arm, so that a search for base poses can turn to those from which the arm
reaches one of them. All robot but the hand is taken out of the imagined world for that, and base and torso carry the
hand to any place.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Percept
from attune.robots.mujoco import pr2
from attune.robots.mujoco.frames import Frame, frame_of
from attune.robots.mujoco.grasps import Grasp
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import straight

Array = NDArray[np.float64]

_AWAY = 0.10
"""Length of the straight way to a grasp [m]."""
_OVER = 0.02 + pr2.PAD_HEIGHT / 2
"""Of the tool frame over an object's top where the fingers are clear of it [m]."""
_LIFTS = ((0.10, 0.0), (0.05, 0.0), (0.06, 0.06), (0.03, 0.08))
"""Ways of lifting: up, and back from where the hand came [m]."""
_TILTS = (0.0, 0.3, -0.3, 0.6, -0.6)
_AHEAD = (0.55, 0.45, 0.65)
_HEIGHTS = (0.0, -0.25, 0.2)
"""Where a hand is tried before the shoulder to find a posture of the arm for its rotation: [rad], [m] and [m]."""


@dataclass(frozen=True, slots=True)
class HandWay:
    """A grasp with its ways: straight from `before` to `grasp`, and straight from there to `lifted`."""

    grasp: Frame
    before: Frame
    lifted: Frame
    cost: float


def hand_ways(
    world: Imagination, carrying: Imagination, percept: Percept, arm: Arm, grasps: Sequence[Grasp]
) -> Iterator[HandWay | None]:
    """The grasps to which and from which there is a free way for the hand; None after each short piece of work.

    Args:
        world: The object stands where it was seen.
        carrying: Made with the object in this arm's gripper.
        percept: The object.
        arm: The arm whose hand it is.
        grasps: Candidates.
    """
    world.put(percept.name, frame_of(percept.pose))
    top = percept.pose.position[2] + percept.extent[2] + _OVER
    with _hand_alone(world, arm) as hand, _hand_alone(carrying, arm) as full:
        world.aim_at(percept.name)
        for grasp in grasps:
            yield None
            world.set_gripper(arm, pr2.GRIPPER_OPEN)
            if not hand.free(grasp.tool):
                continue
            befores = [other for other in _befores(grasp.tool, top) if hand.way_free(grasp.tool, other)]
            if not befores:
                continue
            hand.free(grasp.tool)
            gap = world.pads_meet(arm, percept.name)
            if gap is None:
                continue
            carrying.set_in_hand(arm, grasp.tool.inverse() @ frame_of(percept.pose))
            carrying.set_gripper(arm, gap)
            lifted = next((other for other in _lifted(grasp.tool) if full.way_free(grasp.tool, other)), None)
            if lifted is not None:
                for before in befores:
                    yield HandWay(grasp.tool, before, lifted, grasp.cost)
        world.keep_clear(percept.name)
        world.set_gripper(arm, pr2.GRIPPER_OPEN)


def _befores(hand: Frame, top: float) -> Iterator[Frame]:
    """Where the open hand may come from: along its fingers, from above, or level."""
    x = hand.rotation[:, 0]
    yield Frame(hand.position - _AWAY * x, hand.rotation)
    yield Frame(hand.position + (0.0, 0.0, max(0.0, top - float(hand.position[2]))), hand.rotation)
    ahead = np.hypot(x[0], x[1])
    if 0.2 < ahead < 0.99:
        yield Frame(hand.position - _AWAY / ahead * np.array([x[0], x[1], 0.0]), hand.rotation)


def _lifted(hand: Frame) -> Iterator[Frame]:
    x = hand.rotation[:, 0]
    ahead = np.hypot(x[0], x[1])
    for up, back in _LIFTS:
        if back and ahead < 0.2:
            continue
        level = back / max(ahead, 0.2) * np.array([x[0], x[1], 0.0])
        yield Frame(hand.position - level + (0.0, 0.0, up), hand.rotation)


class _Hand:
    """A hand that is carried to any pose by moving base and torso."""

    def __init__(self, world: Imagination, arm: Arm) -> None:
        self._world = world
        self._arm: Arm = arm
        self._postures: dict[bytes, tuple[float, Array] | None] = {}

    def free(self, frame: Frame) -> bool:
        """Whether the hand may be somewhere; it is there then, if any posture of the arm has this rotation."""
        posture = self._posture(frame.rotation)
        if posture is None:
            return False
        yaw, q = posture
        world = self._world
        world.base = BasePose(0.0, 0.0, yaw)
        world.set_joint(pr2.TORSO, 0.0)
        tool = world.tool(self._arm, q)
        shift = frame.position - tool.position
        world.set_joint(pr2.TORSO, float(shift[2]))
        world.base = BasePose(float(shift[0]), float(shift[1]), yaw)
        world.set_arm(self._arm, q)
        return world.free()

    def way_free(self, start: Frame, end: Frame) -> bool:
        """Whether the hand may go straight from one pose, where it may be, to another."""
        return all(self.free(frame) for frame in straight(start, end)[:0:-1])

    def _posture(self, hand: Array) -> tuple[float, Array] | None:
        """A heading of the base and a posture of the arm that give the hand this rotation."""
        key = np.round(hand, 6).tobytes()
        if key not in self._postures:
            self._postures[key] = self._find(hand)
        return self._postures[key]

    def _find(self, hand: Array) -> tuple[float, Array] | None:
        kinematics = self._world.kinematics[self._arm]
        x, y = hand[:, 0], hand[:, 1]
        heading = np.arctan2(x[1], x[0]) if np.hypot(x[0], x[1]) > 0.1 else np.arctan2(-y[0], y[1])
        for turn in _TILTS:
            yaw = float(heading + turn)
            own = rotation(2, -yaw) @ hand
            places = [kinematics.geometry.shoulder + (ahead, 0.0, height) for ahead in _AHEAD for height in _HEIGHTS]
            q, _ = kinematics.solutions(np.stack(places), np.stack([own] * len(places)), kinematics.pan_grid(0.3))
            if len(q):
                return yaw, q[0]
        return None


@contextmanager
def _hand_alone(world: Imagination, arm: Arm) -> Iterator[_Hand]:
    """For a while, nothing of the robot but one hand and what it carries meets anything."""
    m = world.model
    base, torso, posture = world.base, float(world.torso_lift), world.arm(arm)
    saved = [value.copy() for value in (m.geom_contype, m.geom_conaffinity, m.body_contype, m.body_conaffinity)]
    hand = [m.body(pr2.PALM[arm]).id, *(m.jnt_bodyid[m.joint(name).id] for name in pr2.FINGER_JOINTS[arm])]
    others = (m.body_rootid == world.robot_root) & ~np.isin(np.arange(m.nbody), hand)
    m.geom_contype[others[m.geom_bodyid]] = m.geom_conaffinity[others[m.geom_bodyid]] = 0
    m.body_contype[others] = m.body_conaffinity[others] = 0
    try:
        yield _Hand(world, arm)
    finally:
        for value, before in zip(
            (m.geom_contype, m.geom_conaffinity, m.body_contype, m.body_conaffinity), saved, strict=True
        ):
            value[:] = before
        world.set_joint(pr2.TORSO, torso)
        world.base = base
        world.set_arm(arm, posture)
