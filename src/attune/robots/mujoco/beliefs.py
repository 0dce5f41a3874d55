"""What the robot knows: objects as it saw them, what it holds and how, and the imagined worlds made of that."""

import math
from collections.abc import Collection, Hashable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import ARMS, Arm, Percept, Pose
from attune.robots.mujoco.frames import Frame, frame_of
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.world import World

Array = NDArray[np.float64]

_SAME = 0.1
"""An object seen within this distance of where it was is still there [m]."""
_UNKNOWN = Frame(np.zeros(3), np.eye(3))


@dataclass(frozen=True, slots=True)
class Held:
    """An object in a gripper, and its pose in the tool frame."""

    percept: Percept
    in_hand: Frame

    @property
    def upright(self) -> Array:
        """The object's rotation as it stood before, without its turn about the vertical, shape (3, 3)."""
        stood = frame_of(self.percept.pose).rotation
        return rotation(2, -np.arctan2(stood[1, 0], stood[0, 0])) @ stood


class Beliefs:
    """The robot's memory. Only the event loop's thread changes it."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.seen: dict[str, Percept] = {}
        self._opened: dict[str, float] = {}
        """How far the drawer that an object lies in was open when it was seen [m]."""
        self.held: dict[Arm, Held] = {}
        self._drawers = {box.name: box for box in world.scene.containers if box.kind == "drawer"}

    def notice(self, percepts: Iterable[Percept]) -> None:
        """Remember what is seen now; what is held stays held."""
        held = {held.percept.name for held in self.held.values()}
        for percept in percepts:
            if percept.name not in held:
                self.seen[percept.name] = percept
                drawer = self._drawers.get(percept.place)
                self._opened[percept.name] = self._world.container_position(drawer.name) if drawer else 0.0

    def is_news(self, percept: Percept) -> bool:
        """Whether an object is seen where it was not known to be."""
        known = self.seen.get(percept.name)
        return known is None or math.dist(known.pose.position, percept.pose.position) > _SAME

    def forget(self, name: str) -> None:
        """An object is not where it was."""
        self.seen.pop(name, None)

    def grasped(self, arm: Arm, percept: Percept, in_hand: Frame) -> None:
        """An object is in the gripper now."""
        self.forget(percept.name)
        self.held[arm] = Held(percept, in_hand)

    def released(self, arm: Arm) -> None:
        """The gripper is empty now."""
        self.held.pop(arm, None)

    def feel_hands(self) -> None:
        """Notice when something is not in a gripper any more: somebody took it, or it fell."""
        for arm in tuple(self.held):
            if self._world.held(arm) is None:
                self.released(arm)

    @property
    def free_arms(self) -> tuple[Arm, ...]:
        """Arms that hold nothing."""
        return tuple(arm for arm in ARMS if arm not in self.held)

    def surroundings(self) -> Hashable:
        """What the robot must drive around, to compare with: believed objects and open doors, to the centimetre."""
        objects = (
            (name, *(round(value, 2) for value in (*self._now(percept).position, *percept.pose.orientation)))
            for name, percept in self.seen.items()
        )
        doors = (round(self._world.container_position(box.name), 2) for box in self._world.scene.containers)
        return frozenset(objects), tuple(doors)

    def _now(self, percept: Percept) -> Pose:
        """Where an object must be now: what lies in a drawer moves with it."""
        drawer = self._drawers.get(percept.place)
        if drawer is None:
            return percept.pose
        moved = self._world.container_position(drawer.name) - self._opened[percept.name]
        shift = moved / drawer.opened * np.array(self._world.scene.surface(drawer.name).shift)
        x, y, z = (float(value) for value in percept.pose.position + shift)
        return Pose((x, y, z), percept.pose.orientation)

    def imagine(
        self,
        *,
        grasping: tuple[Arm, str] | None = None,
        empty: Arm | None = None,
        without_content: str = "",
        without: Collection[str] = (),
    ) -> Imagination:
        """The kitchen as believed, the robot as it stands.

        Args:
            grasping: An arm, and an object to put into its gripper; set its pose with `set_in_hand`.
            empty: An arm that is imagined to hold nothing.
            without_content: A drawer that is to be moved: what lies in it would stay behind.
            without: Objects that are imagined away.
        """
        carried = {arm: (held.percept.name, held.in_hand) for arm, held in self.held.items() if arm != empty}
        moving = self._drawers.get(without_content)
        poses = {
            name: self._now(percept)
            for name, percept in self.seen.items()
            if name not in without and (moving is None or percept.place != moving.name)
        }
        if grasping is not None:
            carried[grasping[0]] = (grasping[1], _UNKNOWN)
            poses.pop(grasping[1], None)
        world = Imagination(self._world.model, self._world.snapshot(), poses, carried)
        for arm in self.held:
            if arm in carried and grasping is None:
                world.let_brush(arm)
        return world
