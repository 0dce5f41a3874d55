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
