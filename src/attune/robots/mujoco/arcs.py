"""Opening and closing motions: the hand on a handle, following it while the door turns or the drawer slides.

The handle is a round bar, so the hand may turn about it on the way. Each way of doing that (how steeply the hand
begins, how far it turns, where on the bar it grips) gives a series of hand poses; a plan is one that the arm can follow
from one base pose, with the leaf moving, without touching anything but the handle.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco.arm_paths import joint_path
from attune.robots.mujoco.carry import folding_path
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import ArmKinematics, rotation
from attune.robots.mujoco.kitchen import handle_name, joint_name
from attune.robots.mujoco.reaching import finer, follow, stacked, straight
from attune.robots.mujoco.tracking import Tracks
from attune.robots.mujoco.trees import sparse_first

Array = NDArray[np.float64]

WAYPOINTS = 24
"""Of the handle's way."""
HANDLE_GAP = 0.045
"""To which the fingers open around a handle: wider, they would touch the front behind it [m]."""
_APPROACH = 0.09
_BEGINNINGS = (0.0, 0.4, -0.4, 0.8, -0.8)
"""Turns of the hand about the bar at the beginning, or where the door is closed [rad]."""
_SHARES = (0.0, 0.5, -0.5, 0.9, -0.9)
"""How far the hand turns about the bar on the way, as a share of the door's own turn."""
_ALONG = (0.0, 0.05, -0.05)
"""Where on the bar the hand grips, from its middle [m]."""
_HAND = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""The tool's axes in the handle's frame: pointing at the front, the fingers closing across the bar."""
_WAYS = 10
_STEP = 0.05
"""Between two collision checks on the handle's way [rad]."""
ROOMS = (0.02, 0.008)
"""Left around the arm while the container moves [m]: the first that is possible."""
_STARTS = 5
_PAN_STEP = 0.04
_APART = 0.3
"""Between the shoulder pans with which two joint paths along the same way begin, at least [rad]."""


@dataclass(frozen=True, slots=True)
class Arc:
    """A whole opening or closing motion.

    Attributes:
        reach: From where the arm is to before the handle, shape (n, 7).
        approach: To the handle, shape (m, 7).
        swing: Along the handle's way, shape (k, 7).
        retreat: Back from the handle, shape (l, 7).
        fold: To the folded posture, shape (o, 7).
    """

    arm: Arm
    reach: Array
    approach: Array
    swing: Array
    retreat: Array
    fold: Array


def handle_ways(world: Imagination, container: str, start: float, end: float) -> list[list[Frame]]:
    """Series of hand poses that move a container from one position to another [m or rad], the plainest first."""
    positions = np.linspace(start, end, WAYPOINTS + 1)
    handles = []
    for position in positions:
        world.set_joint(joint_name(container), float(position))
        handles.append(world.site(handle_name(container)))
    ways = []
    turns = abs(float(np.trace(handles[0].rotation.T @ handles[-1].rotation)) - 3.0) > 0.1
    # What opens a door also closes it, played backwards: turns may be counted from the closed door as well.
    origins = {start, min(start, end, key=abs)} if turns else {start}
    combinations = product(_BEGINNINGS, _SHARES if turns else (0.0,), _ALONG, sorted(origins))
    for beginning, share, along, origin in sorted(
        combinations, key=lambda way: abs(way[0]) + abs(way[1]) + 5 * abs(way[2])
    ):
        turn = beginning + share * (positions - origin)
        grips = handles_at(handles, rotation(0, turn), along)
        ways.append(grips)
    world.set_joint(joint_name(container), start)
    return ways


def handles_at(handles: Sequence[Frame], turns: Array, along: float) -> list[Frame]:
    """Hand poses on handles: turned about the bar, shape (n, 3, 3), and shifted along it [m]."""
    return [
        Frame(handle.position + along * handle.rotation[:, 0], handle.rotation @ turn @ _HAND)
        for handle, turn in zip(handles, turns, strict=True)
    ]


def find_arcs(
    world: Imagination,
    arm: Arm,
    container: str,
    ways: Sequence[Sequence[Frame]],
    span: tuple[float, float],
    posture: Array,
    rng: np.random.Generator,
    room: float,
    completions: int = 12,
) -> Iterator[Arc | None]:
    """Ways to move a container from where the base stands; each step is one short piece of work.

    Args:
        world: The container stands at the beginning of `span`.
        arm: The arm.
        container: Its name.
        ways: From `handle_ways`.
        span: Positions of the container from where to where [m or rad].
        posture: The arm's configuration at the beginning.
        rng: For the searches.
        room: Left around the arm while the container moves [m].
        completions: How many ways of the handle are tried to the end.
    """
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    middle = torso.position + torso.rotation @ kinematics.geometry.shoulder
    if any(np.linalg.norm(way[0].position - middle) > 1.0 for way in ways):
        return
    possible = _reachable(world, arm, ways)
    yield None
    for index in possible[:_WAYS]:
        for swing in _swings(kinematics, *stacked(torso, ways[index])):
            if _swings_free(world, arm, container, swing, span, room):
                yield _complete(world, arm, container, swing, ways[index], span, posture, rng)
                completions -= 1
                if completions <= 0:
                    return
        yield None


def _swings(kinematics: ArmKinematics, position: Array, orientation: Array) -> Iterator[Array]:
    """Different joint paths along hand poses, shape (n, 7) each, the smoothest first."""
    pans = kinematics.pan_grid(_PAN_STEP)
    branches = [Tracks(kinematics, position, orientation, pans, branch) for branch in (1.0, -1.0)]
    costs = np.stack([tracks.costs for tracks in branches])
    for _ in range(_STARTS):
        branch, column = np.unravel_index(int(np.argmin(costs)), costs.shape)
        if not np.isfinite(costs[branch, column]):
            return
        yield branches[branch].path(int(column))
        costs[branch, np.abs(pans - pans[column]) < _APART] = np.inf


def _reachable(world: Imagination, arm: Arm, ways: Sequence[Sequence[Frame]]) -> list[int]:
    """Ways of which beginning, quarters and end can each be reached."""
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    keys = [0, WAYPOINTS // 2, WAYPOINTS]
    position, orientation = stacked(torso, [way[key] for way in ways for key in keys])
    _, index = kinematics.solutions(position, orientation, kinematics.pan_grid(0.25))
    reached = np.zeros(len(ways) * len(keys), dtype=bool)
    reached[index] = True
    return [int(way) for way in np.flatnonzero(reached.reshape(-1, len(keys)).all(axis=1))]


def _swings_free(
    world: Imagination, arm: Arm, container: str, swing: Array, span: tuple[float, float], room: float
) -> bool:
    """Whether the arm may move along the handle's way, the container with it. Joints turn far between waypoints."""
    line = np.column_stack((swing, np.linspace(*span, len(swing))))
    checked = finer(line, _STEP)
    world.ignore_handle(container)
    world.set_gripper(arm, 0.02)
    world.widen_arm(arm, room)
    try:
        for point in checked[[0, *sparse_first(len(checked))]]:
            world.set_joint(joint_name(container), float(point[-1]))
            if not world.all_free(arm, point[None, :-1]):
                return False
        return True
    finally:
        world.widen_arm(arm)
        world.set_joint(joint_name(container), span[0])


def _complete(
    world: Imagination,
    arm: Arm,
    container: str,
    swing: Array,
    way: Sequence[Frame],
    span: tuple[float, float],
    posture: Array,
    rng: np.random.Generator,
) -> Arc | None:
    """Add the ways to the handle and back from it."""
    world.ignore_handle(container)
    world.set_gripper(arm, HANDLE_GAP)
    parts: list[Array] = []
    for position, q, hand in ((span[0], swing[0], way[0]), (span[1], swing[-1], way[-1])):
        world.set_joint(joint_name(container), position)
        back = Frame(hand.position - _APPROACH * hand.rotation[:, 0], hand.rotation)
        path = follow(world.kinematics[arm], world.torso_frame(), q, straight(hand, back))
        if path is None or not world.all_free(arm, path):
            return None
        parts.append(path)
    approach, retreat = parts[0][::-1], parts[1]
    # Only these may touch the handle: what pushes it aside moves the door, and the hand then closes beside it.
    world.ignore_handle(container, ignored=False)
    fold = folding_path(world, arm, rng, retreat[-1], posture)
    world.set_joint(joint_name(container), span[0])
    if fold is None:
        return None
    reach = joint_path(world, arm, posture, approach[0], rng)
    if reach is None:
        return None
    turns = 2 * np.pi * np.round((reach[-1] - approach[0]) / (2 * np.pi))
    return Arc(arm, reach, approach + turns, swing + turns, retreat + turns, fold + turns)
