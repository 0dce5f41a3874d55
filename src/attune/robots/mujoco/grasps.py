"""Ways to grasp an object, computed from its pose and extent; nothing is written per object.

Three families: between the pads from the side or slantwise (what is narrow enough), from above across the narrow side
(what lies flat), and one pad inside, one outside a rim (what is wide and open). Whether a way works is for the
collision tests to say: they close the imagined fingers and look whether both pads meet the object.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Percept
from attune.robots.mujoco import pr2
from attune.robots.mujoco.frames import Frame, frame_of

Array = NDArray[np.float64]

_WIDEST = pr2.GRIPPER_OPEN - 0.006
"""What fits between the open pads [m]."""
_DEEPEST = 0.052
"""From the palm's front to the middle of the pads, less a little [m]."""
_LOWEST = pr2.PAD_LENGTH / 2 + 0.003
"""Of the tool frame over the surface when the fingers point down [m]."""
_FLAT = 0.05
"""What is lower than this lies flat and is taken from above [m]."""
_YAWS = 16
_PITCHES = (0.0, 0.35, 0.7, 1.05, np.pi / 2)
"""How steeply the hand comes down [rad]."""


_FINE_PITCHES = tuple(np.linspace(-0.35, np.pi / 2, 12))
"""The same, many of them."""
_ASKEW = (0.13, -0.13, 0.26, -0.26, 0.37, -0.37)
"""Turns of a hand away from straight across what lies flat [rad]."""
_STEEP = (np.pi / 2, 1.4, 1.22, 1.05, 0.87)
"""How steeply a hand comes down on what lies flat [rad]."""
_SLIDES = tuple(np.linspace(-0.85, 0.85, 11))
"""Where along it, as shares of half its length."""
_PALM_MIDDLE, _PALM_HALF = 0.105, (0.04, 0.024)
"""How far the palm's middle is behind the tool frame, and half its length and height [m]."""
_PALM_ROOM = 0.006
"""Between palm and object [m]."""
_INSIDE = 0.010
"""Least distance of the tool frame from an object's outline [m]."""
_INSISTENCE = 2.0
"""Weight of a pitch that is wanted."""


@dataclass(frozen=True, slots=True)
class Grasp:
    """Where the tool frame is when the fingers close, and how far from the best such place (0 is best)."""

    tool: Frame
    cost: float

    @property
    def pitch(self) -> float:
        """How steeply the hand comes down [rad]."""
        return float(np.arcsin(np.clip(-self.tool.rotation[2, 0], -1.0, 1.0)))


@lru_cache(maxsize=8)  # A search for base poses asks again at each of them.
def grasps_for(percept: Percept, pitch: float | None = None) -> tuple[Grasp, ...]:
    """Candidates for an object that stands or lies as perceived, best first: such with this pitch [rad], if given."""
    frame = frame_of(percept.pose)
    width, depth, height = percept.extent
    found = [*_pinches(frame, width, depth, height, pitch)]
    if min(width, depth) > _WIDEST:
        found += _rims(frame, width, depth, height)
    return tuple(sorted(found, key=lambda grasp: grasp.cost))


@lru_cache(maxsize=8)
def more_grasps(percept: Percept) -> tuple[Grasp, ...]:
    """Many more candidates for what stands where few are possible: at every pitch, as deep as the palm lets it."""
    frame = frame_of(percept.pose)
    width, depth, height = percept.extent
    yaw = float(np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0]))
    round_or_square = abs(width - depth) < 0.004
    found = [*_more_flat(frame, width, depth)] if height < _FLAT else []
    for step in range(_YAWS):
        angle = 2 * np.pi * step / _YAWS
        across = abs(np.sin(angle)) * width + abs(np.cos(angle)) * depth
        if not (across <= _WIDEST or (round_or_square and width <= _WIDEST)):
            continue
        along = width / 2 if round_or_square else (abs(np.cos(angle)) * width + abs(np.sin(angle)) * depth) / 2
        ahead = np.array([np.cos(yaw + angle), np.sin(yaw + angle), 0.0])
        for pitch in _FINE_PITCHES:
            for u, z in _deepest(along, height, pitch):
                position = frame.position + u * ahead + np.array([0.0, 0.0, z])
                # Where few grasps are possible there is mostly a board above: level hands first.
                cost = 0.3 * abs(z / height - 0.6) + abs(pitch) + 0.15 * abs(u) / along
                found.append(Grasp(_hand(position, yaw + angle, pitch), float(cost)))
    rims = [grasp for grasp in grasps_for(percept) if min(width, depth) > _WIDEST]
    return tuple(sorted((*found, *rims), key=lambda grasp: grasp.cost))


def _more_flat(frame: Frame, width: float, depth: float) -> Iterator[Grasp]:
    """Across what lies flat, anywhere along it, the pads just over what it lies on: also a little askew and slantwise.

    Askew or from near one of its ends there is room for the fingers where a wall or another object is beside it.
    """
    long = frame.rotation[:, 0 if width >= depth else 1]
    heading = float(np.arctan2(long[1], long[0]))
    for turn in (0.0, *_ASKEW, *(np.pi + np.array((0.0, *_ASKEW)))):
        if abs(np.sin(turn)) * max(width, depth) + abs(np.cos(turn)) * min(width, depth) > _WIDEST:
            continue
        for pitch in _STEEP:
            z = _lowest(pitch)
            for slide in _SLIDES:
                position = frame.position + slide * max(width, depth) / 2 * long + np.array([0.0, 0.0, z])
                cost = abs(slide) + abs(np.sin(turn)) + abs(pitch - np.pi / 2)
                yield Grasp(_hand(position, heading + float(turn), pitch), float(cost))


def _lowest(pitch: float) -> float:
    """Of the tool frame over the surface, for the pads of a hand that comes down so steeply [rad] to be free [m]."""
    return float(0.003 + pr2.PAD_LENGTH / 2 * np.sin(pitch) + pr2.PAD_HEIGHT / 2 * np.cos(pitch))


def _deepest(along: float, height: float, pitch: float) -> Iterator[tuple[float, float]]:
    """Places of the tool frame in the upright plane of a hand (ahead of the object's middle, over its bottom [m]).

    The hand comes in from points all over the object, and goes back along its fingers until its palm is free.
    """
    ahead, up = np.array([np.cos(pitch), -np.sin(pitch)]), np.array([np.sin(pitch), np.cos(pitch)])
    low = _lowest(pitch)
    # The object's and the palm's rectangles are apart if they are along one of their sides.
    middle, half = np.array([0.0, height / 2]), np.array([along, height / 2])
    seen = set()
    for share_u in (-0.75, -0.4, 0.0, 0.4, 0.75):
        for share_z in (0.15, 0.35, 0.55, 0.75, 0.9):
            tool = np.array([share_u * along, max(share_z * height, low)])
            for _ in range(60):
                offset = tool - _PALM_MIDDLE * ahead - middle
                apart = max(
                    *(np.abs(offset) - half - _PALM_HALF[0] * np.abs(ahead) - _PALM_HALF[1] * np.abs(up)),
                    abs(offset @ ahead) - _PALM_HALF[0] - half @ np.abs(ahead),
                    abs(offset @ up) - _PALM_HALF[1] - half @ np.abs(up),
                )
                if apart > _PALM_ROOM:
                    break
                tool = tool - 0.004 * ahead
            inside = min(along - abs(tool[0]), height - tool[1])
            place = tuple(np.round(tool / 0.012))
            if apart > _PALM_ROOM and inside > _INSIDE and tool[1] >= low and place not in seen:
                seen.add(place)
                yield float(tool[0]), float(tool[1])


def _hand(position: Array, heading: float, pitch: float) -> Frame:
    """The tool frame at a position; its x points along `heading`, `pitch` below the horizon, its y is level."""
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    x = np.cos(pitch) * ahead - np.sin(pitch) * np.array([0.0, 0.0, 1.0])
    y = np.array([-ahead[1], ahead[0], 0.0])
    return Frame(position, np.stack((x, y, np.cross(x, y)), axis=1))


def _pinches(frame: Frame, width: float, depth: float, height: float, wanted: float | None) -> Iterator[Grasp]:
    """Between the pads, the pads' axis level."""
    yaw = float(np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0]))
    round_or_square = abs(width - depth) < 0.004
    for step in range(_YAWS):
        angle = 2 * np.pi * step / _YAWS
        across = abs(np.sin(angle)) * width + abs(np.cos(angle)) * depth
        if not (across <= _WIDEST or (round_or_square and width <= _WIDEST)):
            continue
        along = (abs(np.cos(angle)) * width + abs(np.sin(angle)) * depth) / 2
        ahead = np.array([np.cos(yaw + angle), np.sin(yaw + angle), 0.0])
        for pitch in _PITCHES:
            if height < _FLAT and pitch < 1.0:
                continue  # The wrist would be in the table.
            steep = pitch > 1.5
            shift = 0.0 if steep else max(0.0, along * np.cos(pitch) - _DEEPEST)
            for level in _levels(height, steep):
                for slide in (0.0, 0.25, -0.25) if steep and along > 0.05 else (0.0,):
                    offset = ahead * (slide * 2 * along - shift)
                    position = frame.position + offset + np.array([0.0, 0.0, level])
                    cost = 0.6 * abs(level / height - 0.6) + abs(slide) + 4 * shift
                    if wanted is None:
                        cost += 0.3 * abs(pitch - (1.5 if height < _FLAT else 0.6))
                    else:
                        cost += _INSISTENCE * abs(pitch - wanted)
                    yield Grasp(_hand(position, yaw + angle, pitch), cost)


def _levels(height: float, steep: bool) -> tuple[float, ...]:
    """Heights of the tool frame over the object's bottom."""
    if steep or height < 0.05:
        return (max(height - 0.03, _LOWEST), max(height - 0.05, _LOWEST)) if height > 0.06 else (_LOWEST,)
    return tuple(np.clip(np.array([0.45, 0.65, 0.85]) * height, 0.03, height - 0.012))


def _rims(frame: Frame, width: float, depth: float, height: float) -> Iterator[Grasp]:
    """One pad inside, one outside, fingers down or leaning outwards."""
    yaw = float(np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0]))
    level = max(height - 0.012, _LOWEST + 0.008)
    for step in range(2 * _YAWS):
        angle = np.pi * step / _YAWS
        outward = np.array([np.cos(yaw + angle), np.sin(yaw + angle), 0.0])
        radius = 1.0 / np.hypot(2 * np.cos(angle) / width, 2 * np.sin(angle) / depth) - 0.004
        position = frame.position + outward * radius + np.array([0.0, 0.0, level])
        for lean in (0.0, 0.3):
            x = -np.cos(lean) * np.array([0.0, 0.0, 1.0]) - np.sin(lean) * outward
            y = np.cross(np.array([-outward[1], outward[0], 0.0]), x)
            yield Grasp(Frame(position, np.stack((x, y, np.cross(x, y)), axis=1)), 0.3 + 0.3 * lean)
