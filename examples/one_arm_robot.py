"""A second robot behind the Robot interface: a mobile base with one arm, in a world of points on surfaces.

Run it to see it bring a cup and a spoon with Attune's own planner, in virtual time:

    python examples/one_arm_robot.py

docs/robots.md goes through it. It passes the contract tests of all robots: tests/robots/test_contract.py.
"""

import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import anyio

from attune.core.bus import COMMAND, OUTCOME, ROBOT_STATE, Bus
from attune.core.clock import Clock, VirtualClock, run
from attune.core.config import PlannerConfig
from attune.core.messages import BringMe, CommandOutcome, ObjectSpec
from attune.core.scene import Scene, Surface, load_scene
from attune.planner.planner import Planner
from attune.robots.interface import (
    Arm,
    BasePose,
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
    RobotStatus,
    Target,
    UnknownTarget,
    Unreachable,
)
from attune.robots.simulated import TrueObject

ARM: Arm = "right"
TICK = 0.1
SPEED = 0.4
REACH = 1.0
SIGHT = 2.0


class OneArmRobot(Robot):
    """One arm on a round base that drives through furniture's gaps in straight lines.

    Args:
        scene: The kitchen.
        clock: Time.
    """

    arms = (ARM,)

    def __init__(self, scene: Scene, clock: Clock) -> None:
        self._scene = scene
        self._clock = clock
        self._base = BasePose(*scene.robot_start)
        self._gaze: Point = (0.0, 0.0, 0.0)
        self._opened: set[str] = set()
        self._halted = threading.Event()
        self._working = False
        self._things: dict[str, TrueObject] = {}
        for item in scene.objects:
            surface = scene.surface(item.at)
            spec = ObjectSpec(type=item.type, color=item.color, size=item.size, location=surface.place, name=item.name)
            x, y, z, _ = scene.starts[item.name]
            self._things[item.name] = TrueObject(spec, surface.name, _shifted((x, y, z), surface), None)

    # --- what a simulation can tell; a real robot has no such thing ---------------------------------------------

    def true_objects(self) -> Mapping[str, TrueObject]:
        """The truth about the objects."""
        return dict(self._things)

    def speed(self) -> float:
        """Of the base while anything moves [m/s]."""
        return SPEED if self.status().moving else 0.0

    def take_away(self, name: str, surface: str) -> None:
        """Somebody puts an object on another surface, also out of the gripper."""
        self._put(name, _middle(self._scene.surface(surface)), surface)

    # --- state --------------------------------------------------------------------------------------------------

    def status(self) -> RobotStatus:
        """The robot's own state, now."""
        held = self._held()
        return RobotStatus(
            base=self._base,
            moving=self._working and not self._halted.is_set(),
            halted=self._halted.is_set(),
            holding={ARM: held} if held else {},
            opened=frozenset(self._opened),
        )

    async def run(self) -> None:
        """A real robot keeps its connection alive here."""
        await anyio.sleep_forever()

    def halt(self) -> None:
        """Stand still from the next tick on."""
        self._halted.set()

    def resume(self) -> None:
        """Go on."""
        self._halted.clear()

    async def _work(self, seconds: float, *, atomic: bool = False) -> None:
        """Every action is made of ticks: each can be cancelled unless it is atomic, and none counts under a halt."""
        left = max(1, round(seconds / TICK))
        self._working = True
        try:
            while left:
                with anyio.CancelScope(shield=atomic and not self._halted.is_set()):
                    await self._clock.sleep(TICK)
                left -= not self._halted.is_set()
        finally:
            self._working = False

    # --- where to stand -----------------------------------------------------------------------------------------

    async def base_poses(self, target: Target) -> Sequence[BasePose]:
        """Free points around the target, the nearest first."""
        match target:
            case PickTarget(percept, _):
                point = percept.pose.position
            case PlaceTarget(_, position):
                point = position
            case LookTarget(point):
                pass
            case OpenTarget(container):
                point = _middle(self._container(container))
        await self._clock.sleep(TICK)
        here = (self._base.x, self._base.y)
        return sorted(self._around(point), key=lambda pose: math.dist((pose.x, pose.y), here))

    def _around(self, point: Point) -> Iterator[BasePose]:
        for distance in (0.7, 0.9):
            for step in range(16):
                angle = math.tau * step / 16
                x, y = point[0] - distance * math.cos(angle), point[1] - distance * math.sin(angle)
                inside = 0.0 < x < self._scene.room[0] and 0.0 < y < self._scene.room[1]
                if inside and all(_outside(surface, x, y) > 0.25 for surface in self._scene.surfaces):
                    yield BasePose(x, y, angle)

    # --- moving and seeing --------------------------------------------------------------------------------------

    async def navigate(self, goal: BasePose) -> None:
        """Drive straight, tick by tick, so that a cancelled drive ends where it was cancelled."""
        start, way = self._base, math.dist((self._base.x, self._base.y), (goal.x, goal.y))
        ticks = max(1, round(way / SPEED / TICK))
        for tick in range(1, ticks + 1):
            await self._work(TICK)
            share = tick / ticks
            self._base = BasePose(start.x + share * (goal.x - start.x), start.y + share * (goal.y - start.y), goal.yaw)

    async def look_at(self, point: Point) -> None:
        """Turn the camera."""
        await self._work(0.3)
        self._gaze = point

    async def perceive(self, spec: ObjectSpec = ObjectSpec()) -> tuple[Percept, ...]:
        """What is near the point that is looked at, and not behind a door."""
        await self._work(TICK)
        seen = (self._percept(name, thing) for name, thing in self._things.items() if self._sees(thing))
        return tuple(percept for percept in seen if percept.matches(spec))

    def _sees(self, thing: TrueObject) -> bool:
        if thing.held_by or (thing.place and self._is_closed(self._scene.surface(thing.place))):
            return False
        near = math.dist((self._base.x, self._base.y), thing.position[:2]) < SIGHT
        return near and math.dist(self._gaze[:2], thing.position[:2]) < 0.8

    def _percept(self, name: str, thing: TrueObject) -> Percept:
        spec = thing.spec
        extent = self._scene.shape(name).extent
        return Percept(name, spec.type, spec.color, spec.size, Pose(thing.position), extent, thing.place)

    # --- acting -------------------------------------------------------------------------------------------------

    async def open(self, container: str) -> None:
        """Takes 3 s, and a free hand."""
        await self._turn_door(container, opened=True)

    async def close(self, container: str) -> None:
        """Takes 3 s, and a free hand."""
        await self._turn_door(container, opened=False)

    async def _turn_door(self, container: str, *, opened: bool) -> None:
        surface = self._container(container)
        if (container in self._opened) == opened:
            return
        if held := self._held():
            raise GripperFull(held)
        self._check_reach(container, _middle(surface))
        await self._work(3.0)
        (self._opened.add if opened else self._opened.discard)(container)

    async def pick(self, percept: Percept, arm: Arm | None = None, goal: Point | None = None) -> Arm:
        """Reach out, close the fingers (shielded for 0.4 s), lift."""
        if held := self._held():
            raise GripperFull(held)
        if arm not in (None, ARM):
            raise Unreachable(percept.name, f"this robot has no {arm} arm")
        self._check_reach(percept.name, percept.pose.position)
        await self._work(2.0)
        thing = self._things.get(percept.name)
        if thing is None or math.dist(thing.position, percept.pose.position) > 0.03:
            raise ObjectNotThere(percept.name)
        await self._work(0.4, atomic=True)
        self._things[percept.name] = replace(thing, place="", held_by=ARM, spec=replace(thing.spec, location=""))
        await self._work(1.0)
        return ARM

    async def place(self, arm: Arm, position: Point) -> None:
        """Reach out, open the fingers (shielded for 0.4 s), draw back, and look whether it stands."""
        name = self._held()
        if name is None or arm != ARM:
            raise ObjectLost("what was held", arm)
        self._check_reach(name, position)
        await self._work(2.0)
        if self._held() != name:
            raise ObjectLost(name, arm)
        await self._work(0.4, atomic=True)
        under = next((s for s in self._scene.surfaces if _is_on(s, position)), None)
        self._put(name, position, under.name if under else "")
        if under is None:
            raise PlacementFailed(name, "fell to the floor")
        await self._work(0.6)

    async def park_arms(self) -> None:
        """Fold the arm."""
        await self._work(1.0)

    async def move_torso(self, height: float) -> None:
        """This robot's torso is fixed."""

    # --- helpers ------------------------------------------------------------------------------------------------

    def _held(self) -> str | None:
        return next((name for name, thing in tuple(self._things.items()) if thing.held_by), None)

    def _put(self, name: str, position: Point, surface: str) -> None:
        location = self._scene.surface(surface).place if surface else ""
        spec = replace(self._things[name].spec, location=location)
        self._things[name] = TrueObject(spec, surface, position, None)

    def _container(self, name: str) -> Surface:
        found = next((surface for surface in self._scene.surfaces if name and surface.container == name), None)
        if found is None:
            raise UnknownTarget("container", name, [box.name for box in self._scene.containers])
        return found

    def _is_closed(self, surface: Surface) -> bool:
        return bool(surface.container) and surface.container not in self._opened

    def _check_reach(self, what: str, point: Point) -> None:
        if math.dist((self._base.x, self._base.y), point[:2]) > REACH:
            raise Unreachable(what, "it is too far away")
        inside = next((surface for surface in self._scene.surfaces if _is_on(surface, point)), None)
        if inside and self._is_closed(inside) and what != inside.container:
            raise Unreachable(what, f"{inside.container} is closed")


def _shifted(point: Point, surface: Surface) -> Point:
    """Where a point of a surface is when its container is open: a drawer comes out."""
    return (point[0] + surface.shift[0], point[1] + surface.shift[1], point[2])


def _middle(surface: Surface) -> Point:
    return _shifted(surface.center, surface)


def _outside(surface: Surface, x: float, y: float) -> float:
    """How far a point of the floor is outside a surface's rectangle [m]; negative inside."""
    own = surface.from_map(x, y)
    return max(abs(own[0]) - surface.size[0] / 2, abs(own[1]) - surface.size[1] / 2)


def _is_on(surface: Surface, point: Point) -> bool:
    inside = _outside(surface, point[0] - surface.shift[0], point[1] - surface.shift[1]) <= 0
    return inside and abs(surface.center[2] - point[2]) < 0.05


async def bring(clock: VirtualClock, *types: str) -> OneArmRobot:
    """Let the planner bring one object of each type to the table with this robot."""
    scene, bus = load_scene(), Bus()
    robot = OneArmRobot(scene, clock)
    planner = Planner(bus, clock, scene, robot, PlannerConfig())
    wish = BringMe(time=0.0, objects=tuple(ObjectSpec(type=type_) for type_ in types), destination="table")
    ended = anyio.Event()

    def tell(outcome: CommandOutcome) -> None:
        print(f"{outcome.time:6.1f} s  {outcome.status:9}{outcome.object}")  # noqa: T201 - it is for the terminal
        if outcome.status in {"done", "failed", "refused"} and outcome.object == ObjectSpec():
            ended.set()

    bus.on(OUTCOME, tell)
    async with anyio.create_task_group() as group:
        group.start_soon(robot.run)
        group.start_soon(planner.run)
        with bus.subscribe(ROBOT_STATE) as states:
            await states.receive()
        bus.publish(COMMAND, wish)
        await ended.wait()
        group.cancel_scope.cancel()
    return robot


if __name__ == "__main__":
    virtual = VirtualClock()
    run(lambda: bring(virtual, "cup", "spoon"), virtual)
