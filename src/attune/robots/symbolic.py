"""A robot without physics, for developing plans and for teaching.

It keeps the contract of `attune.robots.interface` exactly, in a world of points on surfaces: it drives at constant
speed in straight lines, sees what stands near and in front of it but not inside closed containers, and picks and
places in plausible time. Faults are declared: an action can be told to fail, and objects can be moved, removed, added
or taken out of the gripper while it works.
"""

import math
import random
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import anyio

from attune.core.clock import Clock
from attune.core.messages import ObjectSpec, Size
from attune.core.scene import Scene
from attune.robots.interface import (
    ARMS,
    Arm,
    BasePose,
    Collision,
    GripperFull,
    LookTarget,
    ObjectLost,
    ObjectNotThere,
    OpenTarget,
    Percept,
    PickTarget,
    PlacementFailed,
    PlaceTarget,
    Point,
    Pose,
    Robot,
    RobotFailure,
    RobotStatus,
    Target,
    Unreachable,
)
from attune.robots.simulated import TrueObject
from attune.robots.symbolic_world import SymbolicWorld, Thing, middle

Action = Literal["navigate", "open", "close", "pick", "place"]

SPEED = 0.5
"""Of the base [m/s]."""
TURN = 1.2
"""Of the base [rad/s]."""
REACH = 0.95
"""Farthest an arm reaches from the base's centre [m]."""
SIGHT = 2.5
"""Farthest at which an object is recognised [m]."""
FIELD_OF_VIEW = math.radians(40)
"""Half the angle the camera sees [rad]."""


class SymbolicRobot(Robot):
    """A mobile robot with two arms, and the kitchen it works in.

    Args:
        scene: The kitchen.
        clock: Time.
        seed: Of the camera's misses.
        tick: Control period [s]; actions can be cancelled and halted at each.
        miss_rate: Probability that the camera misses an object it could see, for each look.
    """

    def __init__(
        self, scene: Scene, clock: Clock, seed: int = 0, *, tick: float = 0.02, miss_rate: float = 0.0
    ) -> None:
        self._scene = scene
        self._clock = clock
        self._random = random.Random(seed)
        self._tick = tick
        self._miss_rate = miss_rate
        self._base = BasePose(*scene.robot_start)
        self._gaze = self._base.yaw
        self._opened: set[str] = set()
        self._halted = threading.Event()
        self._working = False
        self._atomic = False
        self._faults: dict[Action, list[RobotFailure]] = {}
        self._world = SymbolicWorld(scene)
        self.arms_parked = True
        """Whether the arms are in the posture for driving."""

    # --- the world, and what can go wrong in it ----------------------------------------------------------------

    def true_objects(self) -> Mapping[str, TrueObject]:
        """All objects of the world by name."""
        return self._world.true_objects()

    def speed(self) -> float:
        """The speed of the base while anything moves [m/s]."""
        return SPEED if self.status().moving else 0.0

    def add_object(self, name: str, type_: str, color: str, size: Size, surface: str) -> None:
        """Put a new object of a known type on a free spot of a surface."""
        self._world.add_object(name, type_, color, size, surface)

    def move_object(self, name: str, surface: str) -> None:
        """Move an object, also out of the gripper, to a free spot of a surface."""
        self._world.move_object(name, surface)

    def remove_object(self, name: str) -> None:
        """Take an object, also out of the gripper, away for good."""
        self._world.remove_object(name)

    def fail_next(self, action: Action, failure: RobotFailure, times: int = 1) -> None:
        """Let the next `times` calls of an action fail, at the moment at which a real one would.

        A `Collision` in a pick comes when the object is lifted: it is held. A `PlacementFailed` leaves the object
        beside the wanted spot, and an `ObjectLost` drops it on that surface.
        """
        self._faults.setdefault(action, []).extend([failure] * times)

    def heal(self) -> None:
        """Forget the faults that were to come."""
        self._faults.clear()

    # --- the Robot interface -----------------------------------------------------------------------------------

    def status(self) -> RobotStatus:
        """The robot's own state, now."""
        return RobotStatus(
            base=self._base,
            moving=self._working and not self._halted.is_set(),
            halted=self._halted.is_set(),
            holding=self._world.holding(),
            opened=frozenset(self._opened),
            atomic=self._atomic,
        )

    async def run(self) -> None:
        """Nothing needs to be kept alive."""
        await anyio.sleep_forever()

    async def base_poses(self, target: Target) -> Sequence[BasePose]:
        """Free poses around the target, nearest to where the robot stands first."""
        match target:
            case PickTarget(percept, _):
                point, distances = percept.pose.position, (0.7, 0.85)
            case PlaceTarget(_, position):
                point, distances = position, (0.7, 0.85)
            case OpenTarget(container):
                point, distances = middle(self._world.container(container)), (0.7, 0.85)
            case LookTarget(position):
                point, distances = position, (1.0, 1.3)
        around = (
            (point[0] - distance * math.cos(angle), point[1] - distance * math.sin(angle), angle)
            for distance in distances
            for angle in (2 * math.pi * step / 16 for step in range(16))
        )
        free = [BasePose(*pose) for pose in around if self._world.is_free(pose[0], pose[1])]
        await self._clock.sleep(self._tick)
        return sorted(free, key=lambda pose: math.dist((pose.x, pose.y), (self._base.x, self._base.y)))

    async def navigate(self, goal: BasePose) -> None:
        """Turn, drive straight, turn."""
        start = self._base
        distance = math.dist((start.x, start.y), (goal.x, goal.y))
        fault = self._fault("navigate")
        if distance > 0.01:
            heading = math.atan2(goal.y - start.y, goal.x - start.x)
            await self._turn(heading)
            steps = max(1, round(distance / SPEED / self._tick))
            for step in range(1, steps + 1):
                await self._spend(self._tick)
                part = step / steps
                x, y = start.x + part * (goal.x - start.x), start.y + part * (goal.y - start.y)
                self._base = BasePose(x, y, heading)
                if fault and part >= 0.5:
                    raise fault
        elif fault:
            raise fault
        await self._turn(goal.yaw)

    async def look_at(self, point: Point) -> None:
        """Turn the head."""
        await self._spend(0.4)
        self._gaze = math.atan2(point[1] - self._base.y, point[0] - self._base.x)

    async def perceive(self, spec: ObjectSpec = ObjectSpec()) -> tuple[Percept, ...]:
        """What stands in front of the head and fits `spec`."""
        await self._spend(0.1)
        seen = (thing for thing in self._world.things.values() if self._is_visible(thing))
        percepts = (
            Percept(
                thing.name,
                thing.type,
                thing.color,
                thing.size,
                Pose(thing.position),
                self._scene.all_types[thing.type].shape(thing.size or "normal").extent,
                thing.surface,
            )
            for thing in seen
            if self._random.random() >= self._miss_rate
        )
        return tuple(percept for percept in percepts if percept.matches(spec))

    async def open(self, container: str) -> None:
        """Open a container within reach; the opening itself takes 3 s."""
        await self._move_door(container, "open")
        self._opened.add(container)

    async def close(self, container: str) -> None:
        """Close a container within reach; the closing itself takes 2 s."""
        await self._move_door(container, "close")
        self._opened.discard(container)

    async def pick(self, percept: Percept, arm: Arm | None = None, goal: Point | None = None) -> Arm:
        """Reach (2 s), close the fingers (0.4 s, shielded), lift (1 s)."""
        holding = self._world.holding()
        hand = arm or next((free for free in ARMS if free not in holding), None)
        if hand is None or hand in holding:
            raise GripperFull(", ".join(holding.values()))
        fault = self._fault("pick")
        self._check_reach(percept.name, percept.pose.position)
        self.arms_parked = False
        await self._spend(2.0)
        thing = self._world.things.get(percept.name)
        if thing is None or thing.held_by or math.dist(thing.position, percept.pose.position) > 0.03:
            raise ObjectNotThere(percept.name)
        await self._spend(0.4, atomic=True)
        if fault and not isinstance(fault, Collision):
            raise fault
        self._world.things[thing.name] = replace(thing, surface="", held_by=hand)
        await self._spend(1.0)
        if fault:
            raise fault
        return hand

    async def place(self, arm: Arm, position: Point) -> None:
        """Reach (2 s), open the fingers (0.4 s, shielded), draw back (0.6 s)."""
        if (name := self._world.holding().get(arm)) is None:
            raise ObjectLost("what was held", arm)
        fault = self._fault("place")
        self._check_reach(name, position)
        self.arms_parked = False
        await self._spend(2.0)
        if self._world.holding().get(arm) != name:
            raise ObjectLost(name, arm)
        if isinstance(fault, ObjectLost):
            self._world.put_down(name, position, beside=True)
        if fault and not isinstance(fault, PlacementFailed):
            raise fault
        await self._spend(0.4, atomic=True)
        crowded = self._world.blocker(position)
        self._world.put_down(name, position, beside=fault is not None or crowded is not None)
        if fault:
            raise fault
        if crowded:
            raise PlacementFailed(name, f"{crowded} stood there")
        if not self._world.things[name].surface:
            raise PlacementFailed(name, "fell to the floor")
        await self._spend(0.6)

    async def park_arms(self) -> None:
        """Fold the arms (1.5 s, or at once if they are folded)."""
        if not self.arms_parked:
            await self._spend(1.5)
            self.arms_parked = True

    async def move_torso(self, height: float) -> None:
        """Takes 1 s and changes nothing: this world's arms have no height."""
        await self._spend(1.0)

    def halt(self) -> None:
        """Stand still from the next tick on."""
        self._halted.set()

    def resume(self) -> None:
        """Go on."""
        self._halted.clear()

    # --- motion ------------------------------------------------------------------------------------------------

    async def _spend(self, seconds: float, *, atomic: bool = False) -> None:
        """Work for a while. Time under a halt does not count, and a halt lets even atomic work be cancelled."""
        remaining = max(1, round(seconds / self._tick))
        self._working, self._atomic = True, atomic
        try:
            while remaining:
                with anyio.CancelScope(shield=atomic and not self._halted.is_set()):
                    await self._clock.sleep(self._tick)
                    remaining -= not self._halted.is_set()
        finally:
            self._working = self._atomic = False

    async def _turn(self, yaw: float) -> None:
        angle = math.remainder(yaw - self._base.yaw, math.tau)
        await self._spend(abs(angle) / TURN)
        self._base = replace(self._base, yaw=yaw)
        self._gaze = yaw

    async def _move_door(self, container: str, action: Literal["open", "close"]) -> None:
        surface = self._world.container(container)
        if (container in self._opened) == (action == "open"):
            return
        if len(self._world.holding()) == len(ARMS):
            raise GripperFull(", ".join(self._world.holding().values()))
        fault = self._fault(action)
        self._check_reach(container, middle(surface))
        self.arms_parked = False
        await self._spend(3.0 if action == "open" else 2.0)
        if fault:
            raise fault

    # --- geometry and bookkeeping ------------------------------------------------------------------------------

    def _fault(self, action: Action) -> RobotFailure | None:
        faults = self._faults.get(action)
        return faults.pop(0) if faults else None

    def _check_reach(self, what: str, point: Point) -> None:
        if math.dist(point[:2], (self._base.x, self._base.y)) > REACH:
            raise Unreachable(what, "too far away")
        surface = self._world.surface_at(point)
        if surface and surface.container and what != surface.container and surface.container not in self._opened:
            raise Unreachable(what, f"{surface.container} is closed")

    def _is_visible(self, thing: Thing) -> bool:
        if thing.held_by:
            return False
        if thing.surface:
            container = self._world.surface(thing.surface).container
            if container and container not in self._opened:
                return False
        x, y = thing.position[0] - self._base.x, thing.position[1] - self._base.y
        off_gaze = abs(math.remainder(math.atan2(y, x) - self._gaze, math.tau))
        return math.hypot(x, y) <= SIGHT and off_gaze <= FIELD_OF_VIEW
