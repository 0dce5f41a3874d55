"""How well and how fast the simulated robot fetches, and how fast it gives way to an interruption.

`attune eval robot --trials 300` is the whole evaluation of fetching.
"""

import json
import random
from collections.abc import Callable
from typing import Any

import anyio
import numpy as np

from attune.core.bus import COMMAND, ROBOT_STATE, ROBOT_STOP, Bus
from attune.core.clock import Clock, RealClock, VirtualClock, run
from attune.core.config import PlannerConfig, RobotConfig
from attune.core.messages import BringMe, ChangeLocation, ObjectSpec, StopSignal
from attune.core.scene import load_scene
from attune.evaluation.robot import evaluate_robot
from attune.evaluation.robot_report import to_data
from attune.planner.planner import Planner
from attune.robots.mujoco.robot import MujocoRobot

TRIALS = 20
STANDSTILL = 0.01
"""A robot stands still when no joint moves faster [m/s or rad/s]."""
PLACES = ("table", "countertop")


def fetching() -> dict[str, Any]:
    """The figures of random tasks, without the lists of single trials."""
    data = to_data(evaluate_robot(TRIALS, seed=1))
    return {name: value for name, value in data.items() if name not in {"failures", "setbacks", "not_possible"}}


class Interrupted:
    """A delivery that is interrupted again and again at random moments, while something moves at full speed."""

    def __init__(self, clock: Clock, seed: int) -> None:
        self.clock = clock
        self.bus = Bus()
        scene = load_scene()
        self.robot = MujocoRobot(scene, clock, RobotConfig(seed=seed))
        self.planner = Planner(self.bus, clock, scene, self.robot, PlannerConfig())
        self.random = random.Random(seed)
        self.minor: list[float] = []
        self.major: list[float] = []
        self.standstill: list[float] = []

    def play(self, count: int) -> None:
        """Interrupt so many times, by another destination and by a stop that is taken back, in turn."""

        async def main() -> None:
            async with anyio.create_task_group() as group:
                group.start_soon(self.robot.run)
                group.start_soon(self.planner.run)
                await self.clock.sleep(0.5)
                self._ask()
                for number in range(count):
                    await self._moving()
                    await (self._redirect() if number % 2 else self._stop())
                group.cancel_scope.cancel()

        run(main, self.clock)

    def _ask(self) -> None:
        things = (ObjectSpec(name="red_cup"), ObjectSpec(name="white_bowl"), ObjectSpec(name="blue_milk"))
        self.bus.publish(COMMAND, BringMe(time=self.clock.now(), objects=things))

    async def _moving(self) -> None:
        """A random moment at which something moves at full speed and a minor interruption need not wait."""
        while True:
            await self.clock.sleep(self.random.uniform(0.5, 3.0))
            state = self.bus.latest(ROBOT_STATE)
            if state is None or (state.step == "idle" and not state.queue):
                self._ask()
            elif state.interruptible and self.robot.commanded_speed() > 0.99:
                return

    async def _redirect(self) -> None:
        before, began = self.robot.commanded_speed(), self.clock.now()
        state = self.bus.latest(ROBOT_STATE)
        now = next((task.destination for task in state.queue if task.status == "active"), "") if state else ""
        self.bus.publish(COMMAND, ChangeLocation(time=began, destination=PLACES[now == PLACES[0]]))
        self.minor.append(await self._time_until(lambda: self.robot.commanded_speed() < before))

    async def _stop(self) -> None:
        before, began = self.robot.commanded_speed(), self.clock.now()
        self.bus.publish(ROBOT_STOP, StopSignal(time=began, state="spotted"))
        self.major.append(await self._time_until(lambda: self.robot.commanded_speed() < before))
        last = began
        while self.clock.now() < began + 1.0:
            if self.robot.speed() > STANDSTILL:
                last = self.clock.now()
            await self.clock.sleep(0.002)
        self.standstill.append(last - began)
        self.bus.publish(ROBOT_STOP, StopSignal(time=self.clock.now(), state="withdrawn"))

    async def _time_until(self, condition: Callable[[], bool]) -> float:
        began = self.clock.now()
        while not condition():
            await self.clock.sleep(0.0005)
        return self.clock.now() - began


def interrupting() -> dict[str, Any]:
    """From the arrival of an interruption to a lower commanded speed; from a stop to standstill."""
    figures: dict[str, Any] = {}
    clocks: tuple[tuple[str, Clock, int], ...] = (("virtual", VirtualClock(), 120), ("real", RealClock(), 40))
    for name, clock, count in clocks:
        trial = Interrupted(clock, seed=3)
        trial.play(count)
        figures |= {
            f"minor interruption to changed motion, {name} time [ms]": distribution(trial.minor),
            f"stop to changed motion, {name} time [ms]": distribution(trial.major),
            f"stop to standstill of every joint, {name} time [ms]": distribution(trial.standstill),
        }
    return figures


def distribution(seconds: list[float]) -> dict[str, float]:
    """In milliseconds."""
    shares = {"median": 0.5, "95 %": 0.95, "99 %": 0.99, "max": 1.0}
    return {name: round(1000 * float(np.quantile(seconds, share)), 1) for name, share in shares.items()} | {
        "n": len(seconds)
    }


def main() -> dict[str, Any]:
    """All figures."""
    return interrupting() | fetching()


if __name__ == "__main__":
    print(json.dumps(main(), indent=2))
