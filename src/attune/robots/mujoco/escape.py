"""First short moves out of a place where the robot touches something, after an action was broken off there."""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.reaching import follow, straight

Array = NDArray[np.float64]

_LENGTHS = (0.04, 0.08, 0.12)
"""Of the moves of the hand that are tried [m]."""
_STEPS = (0.05, 0.1, 0.2, 0.35)
"""Of the moves of the base that are tried [m]."""
_HEADINGS = 12
_TURNS = (0.0, 0.15, -0.15)
"""Of the base meanwhile [rad]."""


def escape_path(world: Imagination, arm: Arm) -> Array | None:
    """A path from where the arm is to a posture that touches nothing, shape (n, 7); one point when it is free already.

    What the arm nearly touches at the beginning it may touch on the way, but nothing else. None when no straight move
    of the hand leads out.
    """
    start = world.arm(arm)
    if world.free():
        return start[None]
    allowed = {pair[:2] for pair in world.contacts()}
    hand = world.tool(arm)
    kinematics, torso = world.kinematics[arm], world.torso_frame()
    upward = np.array([0.0, 0.0, 1.0])
    back = -hand.rotation[:, 0]
    to_body = torso.position - hand.position
    to_body[2] = 0.0
    to_body /= max(float(np.linalg.norm(to_body)), 1e-6)
    ways = (back, upward, back + upward, to_body, to_body + upward, -upward, hand.rotation[:, 1], -hand.rotation[:, 1])
    for length in _LENGTHS:
        for way in ways:
            offset = way / max(float(np.linalg.norm(way)), 1e-6) * length
            end = Frame(hand.position + offset, hand.rotation)
            path = follow(kinematics, torso, start, straight(hand, end, 0.01))
            if path is not None and _leads_out(world, arm, path, allowed):
                return path
    return None


def steps_away(world: Imagination, now: BasePose) -> Array | None:
    """A short straight way of the base to where the robot touches nothing, shape (2, 3), or None.

    What it nearly touches at the beginning it may touch on the way, but nothing else.
    """
    world.base = now
    allowed = {pair[:2] for pair in world.contacts()}
    for length in _STEPS:
        for heading in np.arange(_HEADINGS) * 2 * np.pi / _HEADINGS + np.pi:  # Backwards first.
            for turn in _TURNS:
                aside = length * np.array([np.cos(now.yaw + heading), np.sin(now.yaw + heading), 0.0])
                start = np.array([now.x, now.y, now.yaw])
                line = np.linspace(start, start + aside + (0.0, 0.0, turn), 12)
                if _base_leads_out(world, line, allowed):
                    return line[[0, -1]]
    return None


def _base_leads_out(world: Imagination, line: Array, allowed: set[tuple[str, str]]) -> bool:
    for x, y, yaw in line:
        world.base = BasePose(float(x), float(y), float(yaw))
        if not {pair[:2] for pair in world.contacts()} <= allowed:
            return False
    return world.free()


def _leads_out(world: Imagination, arm: Arm, path: Array, allowed: set[tuple[str, str]]) -> bool:
    for q in path:
        world.set_arm(arm, q)
        if not {pair[:2] for pair in world.contacts()} <= allowed:
            return False
    return world.free()
