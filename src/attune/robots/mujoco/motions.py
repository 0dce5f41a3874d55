"""The parts of the body as things to move: base, head, torso, arms, grippers."""

from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import anyio
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Arm, BasePose, Point, RobotFailure
from attune.robots.mujoco import pr2
from attune.robots.mujoco.controller import Controller
from attune.robots.mujoco.frames import gaze, torso_frame
from attune.robots.mujoco.trajectory import Limits, Trajectory, plan_trajectory
from attune.robots.mujoco.world import World

Array = NDArray[np.float64]

_SHARE = 0.6
"""Share of the joints' highest velocity that motions use."""
_JOINED = 0.02
"""A path that begins nearer than this to the end of the last one goes on from it [rad]."""
_ARM_ACCELERATION = 4.0
_TOLERANCE = 0.003
"""How far a joint of an arm may leave the path that was found free of collisions [rad]."""
BASE_LIMITS = Limits(np.array([0.5, 0.5, 0.9]), np.array([0.7, 0.7, 1.4]))
_HEAD = Limits(np.array([2.0, 2.0]), np.array([8.0, 8.0]))
_TORSO = Limits(np.array([pr2.SERVOS[pr2.TORSO].speed]), np.array([0.1]))
_FINGERS = Limits(np.array([pr2.GRIPPER_SPEED]), np.array([1.0]))


async def together(*actions: Coroutine[Any, Any, None]) -> None:
    """Run actions at the same time; the first failure ends the others and is raised, not wrapped in a group."""
    failures: list[RobotFailure] = []

    async def one(action: Coroutine[Any, Any, None]) -> None:
        try:
            await action
        except RobotFailure as failure:
            failures.append(failure)
            tasks.cancel_scope.cancel()

    async with anyio.create_task_group() as tasks:
        for action in actions:
            tasks.start_soon(one, action)
    if failures:
        raise failures[0]


class Motions:
    """Moves parts of the body along paths, and knows where they are.

    Every coroutine can be cancelled: the part comes to rest on its path first.
    """

    def __init__(self, world: World, controller: Controller) -> None:
        self._world = world
        self._controller = controller
        self._trails: dict[Arm, Array] = {}
        self.excused: frozenset[tuple[str, str]] = frozenset()
        """Contacts, robot part and thing, that do not end motions now."""

    def positions(self, joints: Sequence[str]) -> Array:
        """Measured joint positions."""
        return np.array([self._world.joint_position(joint) for joint in joints])

    @property
    def base(self) -> BasePose:
        """Where the base stands."""
        return self._world.base()

    async def wait_until(self, condition: Callable[[], bool], within: float) -> bool:
        """Wait for a condition; False when it does not hold within that time [s]."""
        return await self._controller.until(condition, within)

    @contextmanager
    def leaving_contacts(self) -> Iterator[None]:
        """Within this, what the robot touched at the beginning does not end its motions: they lead away from it."""
        self.excused = frozenset(self._world.forbidden_contacts())
        try:
            yield
        finally:
            self.excused = frozenset()

    async def drive(self, trajectory: Trajectory) -> None:
        """Move the base."""
        await self._controller.follow(pr2.BASE_JOINTS, trajectory)

    async def bend(self, arm: Arm, path: Array, speed: float = 1.0) -> None:
        """Move an arm along configurations, shape (n, 7), at a share of the usual speed."""
        velocity = np.array([pr2.SERVOS[joint].speed for joint in pr2.ARM_JOINTS[arm]])
        trail = self._trails.get(arm)
        joined = trail is not None and float(np.abs(trail[-1] - path[0]).max()) < _JOINED
        self._trails[arm] = np.concatenate((trail, path[1:])) if trail is not None and joined else path
        limits = Limits(_SHARE * speed * velocity, np.full(7, _ARM_ACCELERATION * speed))
        await self._controller.follow(pr2.ARM_JOINTS[arm], plan_trajectory(path, limits, tolerance=_TOLERANCE))

    def way_back(self, arm: Arm) -> Array:
        """The arm's last continuous motions, backwards from where it is now, shape (n, 7)."""
        now = self.positions(pr2.ARM_JOINTS[arm])
        trail = self._trails.get(arm, now[None])
        nearest = int(np.argmin(np.abs(trail - now).max(axis=1)))
        return np.concatenate((now[None], trail[nearest::-1]))

    def forget_way(self, arm: Arm) -> None:
        """The arm is in a posture from which every way begins."""
        self._trails.pop(arm, None)

    async def fingers(self, arm: Arm, gap: float) -> None:
        """Open or close the fingers to a gap between the pads [m]."""
        path = np.array([[self._world.gripper_gap(arm)], [gap]])
        await self._controller.follow((pr2.GRIPPER[arm],), plan_trajectory(path, _FINGERS))

    async def lift_torso(self, height: float) -> None:
        """Move the torso to a height above its lowest [m], as far as it goes."""
        servo = pr2.SERVOS[pr2.TORSO]
        path = np.array([self.positions((pr2.TORSO,)), [float(np.clip(height, servo.low, servo.high))]])
        await self._controller.follow((pr2.TORSO,), plan_trajectory(path, _TORSO))

    async def gaze(self, point: Point) -> None:
        """Turn the head so that the camera looks at a point, as far as it turns."""
        torso = torso_frame(self.base, float(self.positions((pr2.TORSO,))[0]))
        path = np.array([self.positions(pr2.HEAD_JOINTS), gaze(torso, point)])
        await self._controller.follow(pr2.HEAD_JOINTS, plan_trajectory(path, _HEAD))
