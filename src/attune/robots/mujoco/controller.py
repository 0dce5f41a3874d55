"""The control tick: moves the joints along their trajectories, and stops them on their way.

Every 20 ms the controller advances the motions that run, hands the joints' targets to the world and lets it simulate.
A halt ramps the speed along all paths to zero in `RAMP` seconds, from the next tick on; so does the cancellation of one
motion. Coroutines wait for ticks; the tick itself may run in any thread.
"""

import asyncio
import threading
from collections.abc import Callable, Mapping, Sequence

import anyio
import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.robots.interface import Arm, RobotFailure
from attune.robots.mujoco import pr2
from attune.robots.mujoco.trajectory import Trajectory
from attune.robots.mujoco.world import TICK, World

Array = NDArray[np.float64]

_GRIPPERS: Mapping[str, Arm] = {name: arm for arm, name in pr2.GRIPPER.items()}

RAMP = 0.14
"""Time from a halt or a cancellation to zero commanded velocity, and from a resume to full speed [s]."""
_LONGEST_STOP = 1.0
"""A cancelled motion lets the cancellation go on after this time at the latest [s], even if no tick comes."""


class _Motion:
    def __init__(self, joints: Sequence[str], trajectory: Trajectory) -> None:
        self.joints = tuple(joints)
        self.trajectory = trajectory
        self.time = 0.0
        self.speed = 1.0
        self.cancelled = False
        self.failure: RobotFailure | None = None
        self.done = anyio.Event()

    @property
    def ending(self) -> bool:
        return self.cancelled or self.failure is not None


class Controller:
    """Runs motions on the world.

    Args:
        world: What is moved.
        clock: Its ticks drive everything.
        check: Called after each tick; a failure that it returns ends all motions that run.
    """

    def __init__(self, world: World, clock: Clock, check: Callable[[], RobotFailure | None]) -> None:
        self._world = world
        self._clock = clock
        self._check = check
        self._motions: list[_Motion] = []
        self._watches: list[tuple[Callable[[], bool], anyio.Event]] = []
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._loop_thread = 0
        self._halted = False
        self._speed = 1.0

    @property
    def halted(self) -> bool:
        """Whether a halt is in force."""
        return self._halted

    @property
    def commanded_speed(self) -> float:
        """The speed along the paths that is commanded now, 1 being as planned; 0 without any motion."""
        with self._lock:
            return max((self._speed * motion.speed for motion in self._motions), default=0.0)

    def halt(self) -> None:
        """Ramp all motions down, from the next tick on. Any thread."""
        self._halted = True

    def resume(self) -> None:
        """Ramp them up again. Any thread."""
        self._halted = False

    async def run(self) -> None:
        """Tick until cancelled."""
        self._loop = asyncio.get_running_loop()
        self._loop_thread = threading.get_ident()
        await self._clock.every(TICK, self.tick)

    async def follow(self, joints: Sequence[str], trajectory: Trajectory) -> None:
        """Move joints along a trajectory and wait for its end.

        Cancelled, the joints come to rest on the path within `RAMP`, then the cancellation goes on.

        Raises:
            RobotFailure: What `check` found meanwhile; the joints are at rest.
        """
        motion = _Motion(joints, trajectory)
        with self._lock:
            self._motions.append(motion)
        try:
            await motion.done.wait()
        except anyio.get_cancelled_exc_class():
            motion.cancelled = True
            with anyio.move_on_after(_LONGEST_STOP, shield=True):
                await motion.done.wait()
            with self._lock:
                if motion in self._motions:
                    self._motions.remove(motion)
            raise
        if motion.failure is not None:
            raise motion.failure

    async def until(self, condition: Callable[[], bool], within: float) -> bool:
        """Wait until a condition holds after a tick; False when it does not hold `within` that time [s]."""
        event = anyio.Event()
        watch = (condition, event)
        with self._lock:
            self._watches.append(watch)
        try:
            with anyio.move_on_after(within):
                await event.wait()
                return True
            return False
        finally:
            with self._lock:
                if watch in self._watches:
                    self._watches.remove(watch)

    def tick(self) -> None:
        """Advance all motions and the world by one tick."""
        step = TICK / RAMP
        self._speed = _towards(self._speed, 0.0 if self._halted else 1.0, step)
        ended: list[anyio.Event] = []
        with self._lock:
            motions = tuple(self._motions)
        for motion in motions:
            if self._advance(motion, step):
                ended.append(motion.done)
                with self._lock:
                    if motion in self._motions:
                        self._motions.remove(motion)
        self._world.tick()
        failure = self._check()
        if failure is not None:
            for motion in motions:
                motion.failure = motion.failure or failure
        with self._lock:
            met = [watch for watch in self._watches if watch[0]()]
            self._watches = [watch for watch in self._watches if watch not in met]
        for event in (*ended, *(watch[1] for watch in met)):
            self._hand_over(event)

    def _advance(self, motion: _Motion, step: float) -> bool:
        """Move one motion on; whether it has ended."""
        motion.speed = _towards(motion.speed, 0.0 if motion.ending else 1.0, step)
        rate = self._speed * motion.speed
        motion.time += rate * TICK
        position, velocity = motion.trajectory.sample(motion.time)
        if gripper := _GRIPPERS.get(motion.joints[0]):
            self._world.command_gripper(gripper, float(position[0]))
        else:
            self._world.command_together(motion.joints, position, velocity * rate)
        return motion.time >= motion.trajectory.duration or (motion.ending and rate == 0.0)

    def _hand_over(self, event: anyio.Event) -> None:
        if self._loop is None or threading.get_ident() == self._loop_thread:
            event.set()
        else:
            self._loop.call_soon_threadsafe(event.set)


def _towards(value: float, goal: float, step: float) -> float:
    return min(goal, value + step) if goal > value else max(goal, value - step)
