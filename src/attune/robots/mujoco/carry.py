"""Postures for driving: arms folded, or holding something upright, high enough for the tables and close to the body."""

from collections.abc import Iterator, Mapping
from itertools import islice
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm
from attune.robots.mujoco import pr2
from attune.robots.mujoco.arm_paths import joint_path
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.reaching import comfort
from attune.robots.mujoco.upright_paths import upright_path

Array = NDArray[np.float64]

FOLDED: Mapping[Arm, Array] = MappingProxyType(
    {
        "right": np.array([-0.22, 1.33, -0.92, -2.25, 0.74, -0.95, -1.27]),
        "left": np.array([0.22, 1.33, 0.92, -2.25, -0.74, -0.95, 1.27]),
    }
)
"""The empty arm's posture: inside the base's outline, elbow down, hand before the chest."""

_HEIGHTS = (1.04, 1.12, 0.98)
"""Of a carried object's bottom over the floor [m]."""
_AHEAD = (0.25, 0.33, 0.41, 0.5, 0.6)
_ASIDE = (0.0, 0.12, 0.24, 0.36)
_TURNS = 12
_TRIES = 400
_PATHS = 12
_CLOSE = 0.55
"""Of a carried object's middle and the hand to the base's middle [m]."""
COMPACT = 0.5
"""The same for driving through narrow ways [m]."""
_SAME = 0.05
"""Joints nearer than this to a posture are in it [rad]."""


def folding_path(
    world: Imagination, arm: Arm, rng: np.random.Generator, start: Array, instead: Array | None = None
) -> Array | None:
    """A free path of an empty arm from a configuration to the folded posture, shape (n, 7), or None.

    Args:
        world: Where the arm is empty.
        arm: The arm.
        rng: For the search.
        start: Its configuration.
        instead: The posture to go to where the other arm takes up the room for folding this one.
    """
    goal = FOLDED[arm]
    if instead is not None:
        world.set_arm(arm, instead)
        fold(world, arm)
        goal = world.arm(arm)
    return joint_path(world, arm, start, goal, rng)


def is_folded(world: Imagination, arm: Arm, posture: Array | None = None) -> bool:
    """Whether a posture, or the one the arm is in, is the folded one."""
    now = world.arm(arm) if posture is None else posture
    return bool(np.max(np.abs(world.kinematics[arm].unwrap(FOLDED[arm], now) - now)) < _SAME)


def fold(world: Imagination, arm: Arm) -> None:
    """Imagine an empty arm folded; where the other arm takes up the room for that, the arm stays as it is bent."""
    now = world.arm(arm)
    world.set_arm(arm, FOLDED[arm])
    if not world.clear_of_itself():
        world.set_arm(arm, now)


def is_out_of_the_way(world: Imagination, arm: Arm) -> bool:
    """Whether an empty arm is folded, or close to the body where the other arm takes up the room for folding it."""
    now = world.arm(arm)
    fold(world, arm)
    blocked = bool((world.arm(arm) == now).all())
    world.set_arm(arm, now)
    return is_folded(world, arm) or (blocked and _from_middle(world, world.tool(arm)) < _CLOSE)


def _from_middle(world: Imagination, frame: Frame) -> float:
    """Of a frame from the base's middle, over the floor [m]."""
    return float(np.hypot(frame.position[0] - world.base.x, frame.position[1] - world.base.y))


def is_carrying(world: Imagination, arm: Arm, close: float = _CLOSE) -> bool:
    """Whether what the arm carries is high enough and close enough to the body for driving.

    Args:
        world: Made with the object in the gripper.
        arm: The arm.
        close: Of the object's middle and the hand to the base's middle, at most [m].
    """
    held, tool = world.carried_frame(arm), world.tool(arm)
    away = max(_from_middle(world, held), _from_middle(world, tool))
    return away < close and float(held.position[2]) > min(_HEIGHTS) - 0.02


_ROOM = 0.02
"""Left around what is carried on the way, if possible [m]."""


def carrying_path(world: Imagination, arm: Arm, start: Array, reach: float, rng: np.random.Generator) -> Array | None:
    """A free path of an arm that carries something to a posture for driving, shape (n, 7), or None.

    Args:
        world: Made with the object in the gripper.
        arm: The arm.
        start: Its configuration; the object is upright in it.
        reach: Radius of the carried object around its middle [m].
        rng: For the search.
    """
    for posture in islice(_free_postures(world, arm, _postures(world, arm, start, reach)[:_TRIES]), _PATHS):
        path = upright_path(world, arm, start, posture, rng)
        if path is not None:
            return path
    return None


def _free_postures(world: Imagination, arm: Arm, postures: Array) -> Iterator[Array]:
    """Those of some postures, shape (n, 7), that are free; first those with more room, in their order.

    How it lies in the hand is known only once it is grasped: where there is room, more is left around it.
    """
    narrow = []
    for posture in postures:
        if _is_free(world, arm, posture, _ROOM):
            yield posture
        else:
            narrow.append(posture)
    yield from (posture for posture in narrow if _is_free(world, arm, posture))


def _is_free(world: Imagination, arm: Arm, posture: Array, room: float = 0.0) -> bool:
    if room:
        world.widen_carried(arm, room)
    world.set_arm(arm, posture)
    free = world.free()
    if room:
        world.widen_carried(arm)
    return free


def _postures(world: Imagination, arm: Arm, start: Array, reach: float) -> Array:
    """Upright configurations close to the body, best first, shape (n, 7)."""
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    world.set_arm(arm, start)
    _, orientation = kinematics.forward(start[None])
    tool, held = world.tool(arm), world.carried_frame(arm)
    above_bottom = tool.position[2] - held.position[2]
    offset = torso.rotation.T @ (held.position - tool.position)
    side = 1.0 if arm == "left" else -1.0
    turns = 2 * np.pi * np.arange(_TURNS) / _TURNS
    grid = np.array(
        [
            (x, side * y, height + above_bottom - torso.position[2], turn)
            for height in _HEIGHTS
            for x in _AHEAD
            for y in _ASIDE
            for turn in turns
        ]
    )
    turned = rotation(2, grid[:, 3])
    # The grid is where the object's middle goes; the hand is beside it.
    moved = (turned @ offset)[:, :2]
    position = np.column_stack((grid[:, :2] - moved, grid[:, 2]))
    q, index = kinematics.solutions(position, turned @ orientation[0], kinematics.pan_grid(0.2))
    same = kinematics.branch(q) == kinematics.branch(start[None])[0]
    q, index = q[same], index[same]
    q = kinematics.unwrap(q, start)
    base_offset = np.array([pr2.SHOULDER_OFFSETS[arm][0], 0.0])
    wrist = position[index] - pr2.TOOL_OFFSET * (turned @ orientation[0])[index][:, :, 0]
    elbow = kinematics.elbow(q)
    radius = np.max(
        (
            np.linalg.norm(grid[index, :2] + base_offset, axis=1) + reach,
            np.linalg.norm(position[index, :2] + base_offset, axis=1) + 0.03,
            np.linalg.norm(wrist[:, :2] + base_offset, axis=1) + 0.05,
            np.linalg.norm(elbow[:, :2] + base_offset, axis=1) + 0.07,
        ),
        axis=0,
    )
    cost = (
        6.0 * np.maximum(0.0, radius - 0.47)
        + 0.15 * np.max(np.abs(q - start), axis=1)
        + comfort(kinematics, q) ** 8
        + 0.05 * (grid[index, 2] != grid[0, 2])
    )
    return np.asarray(q[np.argsort(cost, kind="stable")])
