"""Whole motions of an arm for picking up and putting down, tried in the imagination before they are made.

A plan is complete: every part of it is free of collisions and continuous, from the posture the arm is in to the one it
ends in. `*_starts` gives the candidates, cheaply and many at once; `finish_*` tries one of them to its end.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, Percept, Point
from attune.robots.mujoco import pr2
from attune.robots.mujoco.frames import Frame, frame_of
from attune.robots.mujoco.grasps import Grasp
from attune.robots.mujoco.hand_ways import HandWay
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import comfort, follow, reach_all, straight

Array = NDArray[np.float64]

APPROACH = 0.10
"""Length of the straight way to a grasp, and back from an object that was put down [m]."""
LIFTS = (0.10, 0.05)
"""How far an object is lifted straight up, and put down straight from above [m]: the first that is possible."""
PLACE_GAP = 0.004
"""Height over the surface at which an object is let go [m]."""
_HEADING = np.pi / 4
"""Between two directions in which an object is lifted slantwise [rad]."""
_OVER = 0.02
"""Between an object's top and the fingers over it [m]."""
_LONGEST = 0.8
"""From the shoulder to the wrist, about [m]."""
_YAWS = 16


@dataclass(frozen=True, slots=True)
class Start:
    """A candidate: key configurations of one motion, and what they are for.

    Attributes:
        keys: Configurations, shape (k, 7).
        frames: The hand's poses at these.
        cost: Lower is better.
        arm: The arm that makes it.
    """

    arm: Arm
    keys: Array
    frames: tuple[Frame, ...]
    cost: float


@dataclass(frozen=True, slots=True)
class PickPlan:
    """How to pick an object up.

    Attributes:
        approach: Straight to the grasp, along the fingers or from above, shape (n, 7).
        lift: From the grasp up, shape (m, 7).
        in_hand: The object's pose in the tool frame once it is grasped.
    """

    arm: Arm
    approach: Array
    lift: Array
    in_hand: Frame


@dataclass(frozen=True, slots=True)
class PlacePlan:
    """How to put an object down.

    Attributes:
        lower: From above down to where the object is let go, shape (n, 7).
        retreat: From there back along the fingers or up, shape (m, 7).
        placed: The object's pose then.
    """

    arm: Arm
    lower: Array
    retreat: Array
    placed: Frame


def moved(frame: Frame, offset: Array) -> Frame:
    """A frame shifted by an offset in the map frame [m]."""
    return Frame(frame.position + offset, frame.rotation)


def up(height: float) -> Array:
    """An offset straight up [m]."""
    return np.array([0.0, 0.0, height])


def pick_starts(
    world: Imagination, arm: Arm, grasps: Sequence[Grasp], lift: float, top: float | None = None, slant: float = 0.0
) -> list[Start]:
    """Candidates for grasping from where the base stands, best first: keys are grasp, pre-grasp, lifted.

    Args:
        world: Where the base stands.
        arm: The arm.
        grasps: Where the hand may close.
        lift: How far the object is lifted [m].
        top: Height of the object's top over the floor [m], if the open fingers shall come down on both sides of it;
            None for a hand that comes along its fingers.
        slant: How far the object comes towards the robot while it is lifted [m].
    """
    torso = world.torso_frame()
    kinematics = world.kinematics[arm]
    shoulder = torso.position + torso.rotation @ kinematics.geometry.shoulder
    near = [
        g
        for g in grasps
        if np.linalg.norm(g.tool.position - pr2.TOOL_OFFSET * g.tool.rotation[:, 0] - shoulder) < _LONGEST
    ]
    if not near:
        return []
    offset = up(lift)
    if slant:
        aside = shoulder - near[0].tool.position
        # In few directions, so that what is hopeless from one place is known to be so from others.
        heading = np.round(np.arctan2(aside[1], aside[0]) / _HEADING) * _HEADING
        offset = offset + slant * np.array([np.cos(heading), np.sin(heading), 0.0])
    series = [(g.tool, _back(g.tool, top), moved(g.tool, offset)) for g in near]
    keys, index = reach_all(kinematics, torso, series, kinematics.pan_grid())
    costs = np.array([near[i].cost for i in index]) + 0.5 * comfort(kinematics, keys[:, 0]) ** 4
    return _ranked(arm, keys, index, series, costs)


def starts_along(world: Imagination, arm: Arm, ways: Sequence[HandWay], step: float = 0.12) -> list[Start]:
    """Candidates for grasping along ways of the hand from where the base stands, best first.

    Args:
        world: Where the base stands.
        arm: The arm.
        ways: Of its hand.
        step: Between two shoulder pans that are tried [rad].
    """
    torso, kinematics = world.torso_frame(), world.kinematics[arm]
    shoulder = torso.position + torso.rotation @ kinematics.geometry.shoulder
    near = [
        way
        for way in ways
        if np.linalg.norm(way.grasp.position - pr2.TOOL_OFFSET * way.grasp.rotation[:, 0] - shoulder) < _LONGEST
    ]
    if not near:
        return []
    series = [(way.grasp, way.before, way.lifted) for way in near]
    keys, index = reach_all(kinematics, torso, series, kinematics.pan_grid(step))
    costs = np.array([near[i].cost for i in index]) + 0.5 * comfort(kinematics, keys[:, 0]) ** 4
    return _ranked(arm, keys, index, series, costs)


def _back(hand: Frame, top: float | None) -> Frame:
    """Where the open hand is before it grasps and after it has let go: back along its fingers, or over the object."""
    if top is None:
        return moved(hand, -APPROACH * hand.rotation[:, 0])
    return moved(hand, up(max(0.0, top - float(hand.position[2])) + pr2.PAD_HEIGHT / 2 + _OVER))


def key(*hands: Frame) -> bytes:
    """To compare poses of the hand with."""
    return b"".join(hand.position.tobytes() + hand.rotation.tobytes() for hand in hands)


def is_hopeless(start: Start, hopeless: Collection[bytes]) -> bool:
    """Whether the hand cannot be at one of a candidate's poses, or not go there, wherever the robot stands."""
    first, *others = start.frames
    return key(first) in hopeless or any(key(first, other) in hopeless for other in others)


def _free_way(world: Imagination, start: Start, path: Array, other: Frame, hopeless: set[bytes]) -> bool:
    """Whether an arm can go along a path from a candidate's first pose to another.

    If it is the hand or what it carries that cannot, that is noted: it holds wherever the robot stands.
    """
    if world.all_free(start.arm, path):
        return True
    if not world.hand_free(start.arm):
        hopeless.add(key(start.frames[0], other))
    return False


def finish_pick(
    world: Imagination, carrying: Imagination, percept: Percept, start: Start, hopeless: set[bytes]
) -> PickPlan | None:
    """Try a candidate: the object in the way until it is grasped, in the gripper after.

    Args:
        world: The object stands where it was seen.
        carrying: Made with the object in this arm's gripper; its pose in the hand is set here.
        percept: The object.
        start: From `pick_starts`.
        hopeless: See `is_hopeless`; what is found is added.
    """
    arm = start.arm
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    grasp, before, lifted = start.frames
    world.set_gripper(arm, pr2.GRIPPER_OPEN)
    if not world.all_free(arm, start.keys[:1]) or not _free_way(world, start, start.keys[1:2], before, hopeless):
        return None
    back = follow(kinematics, torso, start.keys[0], straight(grasp, before))
    rise = follow(kinematics, torso, start.keys[0], straight(grasp, lifted))
    if back is None or rise is None or not _free_way(world, start, back, before, hopeless):
        return None
    world.set_arm(arm, start.keys[0])
    gap = world.pads_meet(arm, percept.name)
    world.set_gripper(arm, pr2.GRIPPER_OPEN)
    if gap is None:
        return None
    in_hand = grasp.inverse() @ frame_of(percept.pose)
    carrying.set_in_hand(arm, in_hand)
    carrying.set_gripper(arm, gap)
    if not _free_way(carrying, start, rise[1:], lifted, hopeless):
        return None
    return PickPlan(arm, back[::-1], rise, in_hand)


def place_starts(
    world: Imagination,
    arm: Arm,
    in_hand: Frame,
    upright: Array,
    position: Point,
    lift: float,
    top: float | None = None,
) -> list[Start]:
    """Candidates for putting down from where the base stands, best first: keys are placed, above, drawn back.

    Args:
        world: Where the base stands.
        arm: The arm.
        in_hand: The object's pose in the tool frame.
        upright: Its rotation when it stands.
        position: Where its bottom's middle shall be.
        lift: From how far above it comes [m].
        top: Height of its top over the floor when it stands [m], if the open hand shall rise from it; None for a hand
            that draws back along its fingers.
    """
    torso = world.torso_frame()
    kinematics = world.kinematics[arm]
    hand = in_hand.inverse()
    series = []
    for step in range(_YAWS):
        turn = rotation(2, 2 * np.pi * step / _YAWS) @ upright
        placed = Frame(np.array(position) + up(PLACE_GAP), turn) @ hand
        above = moved(placed, up(lift))
        series.append((placed, above, _back(placed, top)))
    keys, index = reach_all(kinematics, torso, series, kinematics.pan_grid())
    # An upright path cannot change the branch that the arm is on.
    same = kinematics.branch(keys[:, 0]) == kinematics.branch(world.arm(arm)[None])[0]
    keys, index = keys[same], index[same]
    costs = 0.5 * comfort(kinematics, keys[:, 0]) ** 4
    return _ranked(arm, keys, index, series, costs)


def finish_place(
    world: Imagination, carrying: Imagination, in_hand: Frame, name: str, start: Start, hopeless: set[bytes]
) -> PlacePlan | None:
    """Try a candidate: the object in the gripper on the way down, standing there on the way back.

    Args:
        world: Made without the object in the gripper; its place is set here.
        carrying: Made with it.
        in_hand: Its pose in the tool frame.
        name: The object.
        start: From `place_starts`.
        hopeless: See `is_hopeless`; what is found is added.
    """
    arm = start.arm
    kinematics, torso = carrying.kinematics[arm], carrying.torso_frame()
    placed, above, drawn_back = start.frames
    if not carrying.all_free(arm, start.keys[:1]) or not _free_way(carrying, start, start.keys[1:2], above, hopeless):
        return None
    rise = follow(kinematics, torso, start.keys[0], straight(placed, above))
    back = follow(kinematics, torso, start.keys[0], straight(placed, drawn_back))
    if back is None or rise is None or not _free_way(carrying, start, rise, above, hopeless):
        return None
    standing = placed @ in_hand
    world.put(name, standing)
    world.set_gripper(arm, pr2.GRIPPER_OPEN)
    if not _free_way(world, start, back, drawn_back, hopeless):
        return None
    return PlacePlan(arm, rise[::-1], back, standing)


def _ranked(
    arm: Arm, keys: Array, index: NDArray[np.intp], series: Sequence[tuple[Frame, ...]], costs: Array
) -> list[Start]:
    order = np.argsort(costs, kind="stable")
    return [Start(arm, keys[i], series[index[i]], float(costs[i])) for i in order]
