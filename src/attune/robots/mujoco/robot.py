"""The PR2 in the simulated kitchen, behind the Robot interface."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from attune.core.clock import Clock
from attune.core.config import RobotConfig
from attune.core.furniture import Container
from attune.core.messages import ObjectSpec
from attune.core.scene import Scene
from attune.robots.interface import (
    ARMS,
    Arm,
    BasePose,
    Collision,
    GripperFull,
    ObjectNotThere,
    Percept,
    Point,
    Pose,
    Robot,
    RobotFailure,
    RobotStatus,
    Target,
)
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.containers import Containers
from attune.robots.mujoco.controller import Controller
from attune.robots.mujoco.driving import Driving
from attune.robots.mujoco.folding import Folding
from attune.robots.mujoco.manipulation import Manipulation
from attune.robots.mujoco.motions import Motions
from attune.robots.mujoco.perception import PERIOD, CameraSettings, Perception
from attune.robots.mujoco.searching import Searching
from attune.robots.mujoco.world import World
from attune.robots.simulated import TrueObject

_STANDSTILL = 0.01
"""A robot whose joints are all slower than this stands still [rad/s or m/s]."""
_SURFACE_ERROR = 0.015
"""An object seen less than this over or under a surface stands on it [m]."""
_LOOKS = 3
"""Looks that are averaged before an object is grasped."""
_NEARBY = 0.15
"""An object seen within this distance was only nudged [m]."""


class MujocoRobot(Robot):
    """A PR2 with real physics.

    Args:
        scene: The kitchen.
        clock: Time; `run` ticks the simulation by it.
        config: Of the robot.

    Attributes:
        world: The simulation. Tests and judges look at the truth through it; the robot itself only measures its own
            joints, its fingertips and what its camera sees.
    """

    def __init__(self, scene: Scene, clock: Clock, config: RobotConfig) -> None:
        self.world = World(scene, friction_only=config.friction_only)
        self._clock = clock
        self._scene = scene
        self._rng = np.random.default_rng(config.seed)
        camera = CameraSettings(noise=config.camera_noise, miss=config.camera_miss)
        self._perception = Perception(self.world, camera, seed=config.seed)
        self._controller = Controller(self.world, clock, self._touched)
        self._motions = Motions(self.world, self._controller)
        self._beliefs = Beliefs(self.world)
        self._driving = Driving(self._motions, self._beliefs, clock, self._see_on_the_way)
        self._folding = Folding(self.world, self._motions, self._beliefs, clock, self._rng)
        self._manipulation = Manipulation(
            self.world, self._motions, self._folding, self._beliefs, clock, self._look_for, self._rng
        )
        self._containers = Containers(self.world, self._motions, self._folding, self._beliefs, clock, self._rng)
        self._searching = Searching(
            scene, self._motions, self._beliefs, self._driving, self._containers, clock, self._rng
        )

    # --- state --------------------------------------------------------------------------------------------------

    def status(self) -> RobotStatus:
        """The robot's own state, now."""
        held = {arm: self.world.held(arm) for arm in ARMS}
        opened = frozenset(
            box.name for box in self._scene.containers if self.world.container_position(box.name) > 0.5 * box.opened
        )
        return RobotStatus(
            base=self.world.base(),
            moving=self.world.speed() > _STANDSTILL,
            halted=self._controller.halted,
            holding={arm: name for arm, name in held.items() if name is not None},
            opened=opened,
            atomic=self._manipulation.closing,
        )

    async def run(self) -> None:
        """Tick the control loop and the simulation until cancelled."""
        await self._controller.run()

    def halt(self) -> None:
        """Ramp all motion down from the next tick on."""
        self._controller.halt()

    def resume(self) -> None:
        """Go on."""
        self._controller.resume()

    def true_objects(self) -> Mapping[str, TrueObject]:
        """The truth about the objects: for judges, not for the robot."""
        return self.world.true_objects()

    def speed(self) -> float:
        """The fastest motion of any joint now [m/s or rad/s]."""
        return self.world.speed()

    def commanded_speed(self) -> float:
        """The share of the planned speed that is commanded now; 0 when nothing is to move."""
        return self._controller.commanded_speed

    def _touched(self) -> RobotFailure | None:
        contacts = [pair for pair in self.world.forbidden_contacts() if pair not in self._motions.excused]
        return Collision(*contacts[0]) if contacts else None

    # --- searching ----------------------------------------------------------------------------------------------

    async def base_poses(self, target: Target) -> Sequence[BasePose]:
        """A base pose to which a way leads and from which the target can be reached; to look from, up to two."""
        return await self._searching.base_poses(target)

    # --- acting -------------------------------------------------------------------------------------------------

    async def navigate(self, goal: BasePose) -> None:
        """Drive along a free path, replanned up to three times."""
        await self._driving.to(goal)

    async def look_at(self, point: Point) -> None:
        """Turn the head towards a point."""
        await self._motions.gaze(point)

    async def perceive(self, spec: ObjectSpec = ObjectSpec()) -> tuple[Percept, ...]:
        """What the head camera sees now and fits `spec`."""
        await self._clock.sleep(PERIOD)
        seen = [self._resting(percept) for percept in self._perception.look()]
        self._beliefs.notice(seen)
        return tuple(percept for percept in seen if percept.matches(spec))

    def sees(self, points: Sequence[Point]) -> tuple[bool, ...]:
        """Which points the head camera sees now, with nothing before or around them."""
        return self._perception.sees(points)

    def _resting(self, percept: Percept) -> Percept:
        """What is seen to stand on a known surface stands exactly on it, whatever the camera's noise says."""
        x, y, z = percept.pose.position
        if not percept.place:
            return percept
        height = self._scene.surface(percept.place).center[2]
        if abs(z - height) > _SURFACE_ERROR:
            return percept
        return replace(percept, pose=Pose((x, y, height), percept.pose.orientation))

    async def _see_on_the_way(self, point: Point) -> None:
        """Take in what was not known to be there; what is there as expected is not seen anew with other noise."""
        await self.look_at(point)
        await self._clock.sleep(PERIOD)
        self._beliefs.notice(seen for seen in self._perception.look() if self._beliefs.is_news(seen))

    async def _look_for(self, point: Point) -> tuple[Percept, ...]:
        await self.look_at(point)
        return await self.perceive()

    async def open(self, container: str) -> None:
        """Open a door or drawer as far as it is opened for use. The closing of the fingers is shielded, 3 s at most."""
        box = self._searching.container(container)
        if not self._containers.is_open(box):
            await self._move(box, box.opened)

    async def close(self, container: str) -> None:
        """Close a door or drawer. The closing of the fingers is shielded, three seconds at most."""
        box = self._searching.container(container)
        if not self._containers.is_closed(box):
            await self._move(box, 0.0)

    async def _move(self, box: Container, position: float) -> None:
        if not self._beliefs.free_arms:
            raise GripperFull(", ".join(held.percept.name for held in self._beliefs.held.values()))
        await self._containers.move(box, position)

    async def pick(self, percept: Percept, arm: Arm | None = None, goal: Point | None = None) -> Arm:
        """Grasp an object, lift it and take it to a posture for driving.

        The closing of the fingers is shielded from cancellation, for three seconds at most. The object is looked at
        first: if it was nudged, it is grasped where it is now.
        """
        self._beliefs.feel_hands()
        free = self._beliefs.free_arms
        if not free or (arm is not None and arm not in free):
            raise GripperFull(", ".join(held.percept.name for held in self._beliefs.held.values()))
        now = await self._find_again(percept)
        arms = (arm,) if arm is not None else self._nearest_first(free, now)
        return await self._manipulation.pick(now, arms, self._searching.pitch_for(goal), self._searching.proof(now))

    async def place(self, arm: Arm, position: Point) -> None:
        """Put down what `arm` holds, let go, draw back, fold the arm and look whether it stands."""
        await self._manipulation.place(arm, position)

    async def park_arms(self) -> None:
        """Fold empty arms; bring carried objects, upright, close to the body and above the tables."""
        self._beliefs.feel_hands()
        await self._folding.fold_all()

    async def move_torso(self, height: float) -> None:
        """Lift the torso to `height` [m] above its lowest position, as far as it goes."""
        await self._motions.lift_torso(height)

    async def _find_again(self, percept: Percept) -> Percept:
        """The object as it is seen now, near where it was seen before; as it was seen, if it is hidden from here."""
        x, y, z = percept.pose.position
        await self.look_at((x, y, z))
        looks = [seen for _ in range(_LOOKS) for seen in await self.perceive() if seen.name == percept.name]
        if not looks and not self.sees([(x, y, z + percept.extent[2] / 2)])[0]:
            return percept
        if not looks:
            self._beliefs.forget(percept.name)
            raise ObjectNotThere(percept.name)
        mean = np.mean([seen.pose.position for seen in looks], axis=0)
        if np.linalg.norm(mean - percept.pose.position) > _NEARBY:
            raise ObjectNotThere(percept.name)
        x, y, z = (float(value) for value in mean)
        now = replace(looks[-1], pose=Pose((x, y, z), looks[-1].pose.orientation))
        self._beliefs.notice((now,))
        return now

    def _nearest_first(self, arms: tuple[Arm, ...], percept: Percept) -> tuple[Arm, ...]:
        base = self._motions.base
        x, y, _ = percept.pose.position
        aside = np.cos(base.yaw) * (y - base.y) - np.sin(base.yaw) * (x - base.x)
        return tuple(sorted(arms, key=lambda arm: (arm == "left") != (aside > 0)))
