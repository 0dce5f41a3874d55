"""Picking up and putting down from posture to posture: the straight parts and the ways there and back.

The searches are iterators: each step is one short piece of work, so that a caller can run them off the event loop and
stop between any two steps. A step yields a whole motion that is free of collisions, or None.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, Percept, Point
from attune.robots.mujoco import pr2
from attune.robots.mujoco.arm_paths import joint_path
from attune.robots.mujoco.beliefs import Held
from attune.robots.mujoco.carry import carrying_path, folding_path
from attune.robots.mujoco.frames import frame_of
from attune.robots.mujoco.grasps import grasps_for
from attune.robots.mujoco.hand_ways import HandWay
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.pick_place import (
    LIFTS,
    PickPlan,
    PlacePlan,
    Start,
    finish_pick,
    finish_place,
    is_hopeless,
    key,
    pick_starts,
    place_starts,
    starts_along,
)
from attune.robots.mujoco.skeleton import through_things
from attune.robots.mujoco.upright_paths import upright_path

Array = NDArray[np.float64]

_STARTS = 40
"""Candidates of the straight part that are tried, for each height of lifting."""
_ALIKE = 4
"""Candidates with the same pose of the hand that are tried, of those."""
_AT_ONCE = 128
"""Candidates that are looked through at once for those that do not reach through something."""


@dataclass(frozen=True, slots=True)
class Pick:
    """A whole picking motion.

    Attributes:
        reach: From where the arm is to the beginning of the approach, shape (n, 7).
        plan: The straight part.
        carry: From the lifted posture to one for driving, shape (m, 7).
    """

    reach: Array
    plan: PickPlan
    carry: Array


@dataclass(frozen=True, slots=True)
class Place:
    """A whole placing motion.

    Attributes:
        reach: From where the arm is to above the place, shape (n, 7).
        plan: The straight part.
        fold: From where it has drawn back to the folded posture, shape (m, 7).
    """

    reach: Array
    plan: PlacePlan
    fold: Array


_NEAR_PITCH = 0.4
"""A hand that comes down so much steeper or flatter than wanted is still held as wanted [rad]."""


@dataclass(frozen=True, slots=True)
class Manner:
    """How the hand comes and goes.

    Attributes:
        over: The open hand comes down over the object and rises from it, instead of moving along its fingers.
        strict: Only grasps with the pitch that is wanted.
        roomy: What is carried keeps well away from other objects.
        slantwise: The object is lifted towards the robot: it stands close before a wall or under the edge of a board.
        thorough: All that the hand can do is tried: many more grasps and ways to them, longer searches for the arm's.
        high: What is put down is let go a little higher: fingers that hold it near its bottom need room below them.
    """

    over: bool = False
    strict: bool = False
    roomy: bool = False
    slantwise: bool = False
    thorough: bool = False
    high: bool = False


THOROUGH = Manner(thorough=True)


def manners(pitch: float | None = None) -> tuple[Manner, ...]:
    """The manners of picking up, the best first: what is not grasped as wanted must be set down again.

    Args:
        pitch: How steeply the hand should come down, if that matters [rad].
    """
    usual = (Manner(), Manner(over=True), Manner(slantwise=True))
    return usual if pitch is None else (Manner(strict=True), *usual)


PLACING = (Manner(roomy=True), Manner(), Manner(over=True), Manner(high=True))
"""The manners of putting down, the best first."""
_SLANT = 0.6
"""How far towards the robot what is lifted slantwise comes for each metre up."""
_LOW = 0.03
"""Fingers whose middle is not higher over the bottom of what they hold may come too near to what it is put on [m]."""
_HIGHER = 0.004
"""So much higher these then let go [m]."""
_ROOMY = 0.016
"""Kept from other objects if possible: camera, hand and arm may each err by a few millimetres [m]."""


def radius(percept: Percept) -> float:
    """Of the circle around an object's middle that it fits into, seen from above [m]."""
    return float(np.hypot(percept.extent[0], percept.extent[1])) / 2


_RUB = 0.006
"""Fingers have this much give [m]; opened, they are 7.5 mm away from a cup that was grasped in the middle."""


def find_picks(
    world: Imagination,
    carrying: Imagination,
    percept: Percept,
    arm: Arm,
    posture: Array,
    rng: np.random.Generator,
    completions: int = 12,
    pitch: float | None = None,
    hopeless: set[bytes] | None = None,
    manner: Manner = Manner(),
    ways: Sequence[HandWay] = (),
) -> Iterator[Pick | None]:
    """Ways to pick an object up from where the base stands.

    Args:
        world: The object stands where it was seen.
        carrying: Made with the object in this arm's gripper.
        percept: The object.
        arm: The arm.
        posture: Its configuration at the beginning.
        rng: For the searches.
        completions: How many candidates of the straight part are tried to the end.
        pitch: How steeply the hand should come down, if that matters [rad].
        hopeless: Hand poses that are not free, wherever the base stands; those that are found are added.
        manner: How the hand comes.
        ways: What the hand alone can do, for a thorough search.
    """
    hopeless = set() if hopeless is None else hopeless
    world.put(percept.name, frame_of(percept.pose))
    for starts in _pick_starts(world, percept, arm, pitch, hopeless, manner, ways):
        for start in _worth_trying(world, starts, percept.name, hopeless):
            world.aim_at(percept.name)
            world.set_gripper(arm, pr2.GRIPPER_OPEN)
            world.set_arm(arm, start.keys[0])
            if not world.hand_free(arm):
                hopeless.add(key(start.frames[0]))
                plan = None
            else:
                plan = finish_pick(world, carrying, percept, start, hopeless)
            world.keep_clear(percept.name)
            if plan is None:
                continue
            yield _with_ways(world, carrying, percept, posture, plan, rng, manner.thorough)
            completions -= 1
            if completions <= 0:
                return
        yield None


def _pick_starts(
    world: Imagination,
    percept: Percept,
    arm: Arm,
    pitch: float | None,
    hopeless: Collection[bytes],
    manner: Manner,
    ways: Sequence[HandWay],
) -> Iterator[list[Start]]:
    """Candidates for picking an object up: for each height of lifting, or all that the hand can do."""
    if manner.thorough:
        yield starts_along(world, arm, ways)
        return
    top = percept.pose.position[2] + percept.extent[2] if manner.over else None
    wanted = pitch if manner.strict else None
    for lift in LIFTS:
        grasps = [
            grasp
            for grasp in grasps_for(percept, pitch)
            if key(grasp.tool) not in hopeless and (wanted is None or abs(grasp.pitch - wanted) < _NEAR_PITCH)
        ]
        yield pick_starts(world, arm, grasps, lift, top, _SLANT * lift if manner.slantwise else 0.0)


def find_places(
    world: Imagination,
    carrying: Imagination,
    held: Held,
    arm: Arm,
    position: Point,
    posture: Array,
    rng: np.random.Generator,
    completions: int = 12,
    hopeless: set[bytes] | None = None,
    manner: Manner = Manner(),
) -> Iterator[Place | None]:
    """Ways to put an object down from where the base stands.

    Args:
        world: Made without the object in the gripper.
        carrying: Made with it.
        held: The object.
        arm: The arm.
        position: Where its bottom's middle shall be.
        posture: The arm's configuration at the beginning.
        rng: For the searches.
        completions: How many candidates of the straight part are tried to the end.
        hopeless: Hand poses that are not free, wherever the base stands; those that are found are added.
        manner: How the hand goes.
    """
    hopeless = set() if hopeless is None else hopeless
    top = position[2] + held.percept.extent[2] if manner.over else None
    if manner.high:
        if (held.upright @ held.in_hand.inverse().position)[2] > _LOW:
            return
        position = (position[0], position[1], position[2] + _HIGHER)
    if manner.roomy:
        carrying.widen_objects(_ROOMY)
    else:
        carrying.widen_objects()
    for lift in LIFTS:
        carrying.set_arm(arm, posture)
        starts = place_starts(carrying, arm, held.in_hand, held.upright, position, lift, top)
        for start in _worth_trying(carrying, starts, held.percept.name, hopeless):
            carrying.set_arm(arm, start.keys[0])
            if not carrying.hand_free(arm):
                hopeless.add(key(start.frames[0]))
                continue
            world.aim_at(held.percept.name, rub=_RUB)
            plan = finish_place(world, carrying, held.in_hand, held.percept.name, start, hopeless)
            world.keep_clear(held.percept.name)
            if plan is None:
                continue
            yield _from_and_to(world, carrying, posture, plan, rng)
            completions -= 1
            if completions <= 0:
                return
        yield None


def _worth_trying(
    world: Imagination, starts: Sequence[Start], handled: str, hopeless: Collection[bytes]
) -> Iterator[Start]:
    """So many candidates and no more, few of them with the same pose of the hand."""
    tried: Counter[bytes] = Counter()
    for index, start in enumerate(starts):
        if index % _AT_ONCE == 0:
            some = starts[index : index + _AT_ONCE]
            blocked = through_things(world, start.arm, np.stack([other.keys[0] for other in some]), handled)
        hand = key(start.frames[0])
        if blocked[index % _AT_ONCE] or tried[hand] == _ALIKE or is_hopeless(start, hopeless):
            continue
        tried[hand] += 1
        if tried.total() > _STARTS:
            return
        yield start


def _with_ways(
    world: Imagination,
    carrying: Imagination,
    percept: Percept,
    posture: Array,
    plan: PickPlan,
    rng: np.random.Generator,
    thorough: bool,
) -> Pick | None:
    arm = plan.arm
    world.set_gripper(arm, pr2.GRIPPER_OPEN)
    reach = joint_path(world, arm, posture, plan.approach[0], rng, thorough=thorough)
    if reach is None:
        return None
    approach = turned(plan.approach, reach[-1])
    lift = turned(plan.lift, approach[-1])
    carrying.set_in_hand(arm, plan.in_hand)
    carry = carrying_path(carrying, arm, lift[-1], radius(percept), rng)
    if carry is None and thorough:  # The way to it was hard to find: it is worth another try.
        carry = carrying_path(carrying, arm, lift[-1], radius(percept), rng)
    if carry is None:
        return None
    return Pick(reach, PickPlan(arm, approach, lift, plan.in_hand), carry)


def _from_and_to(
    world: Imagination, carrying: Imagination, posture: Array, plan: PlacePlan, rng: np.random.Generator
) -> Place | None:
    reach = upright_path(carrying, plan.arm, posture, plan.lower[0], rng)
    if reach is None:
        return None
    lower = turned(plan.lower, reach[-1])
    retreat = turned(plan.retreat, lower[-1])
    fold = folding_path(world, plan.arm, rng, retreat[-1], posture)
    if fold is None:
        return None
    return Place(reach, PlacePlan(plan.arm, lower, retreat, plan.placed), fold)


def turned(path: Array, first: Array) -> Array:
    """A path with its continuous joints turned by whole turns so that it goes on from `first`."""
    turns = np.round((first - path[0]) / (2 * np.pi))
    return np.asarray(path + 2 * np.pi * turns)
