"""How well and how fast the simulated robot fetches: random trials between open surfaces, nothing retried.

    python -m benchmarks.robot --trials 40 --seed 1

Each trial is a fresh kitchen: one object is put at a random free spot of one surface and fetched to a random free spot
of another. A trial succeeds when the object then stands upright within 4 cm of the goal, on that surface. Prints JSON.
"""

import argparse
import json
import math
import time
from collections import Counter
from dataclasses import dataclass, field

import anyio
import numpy as np

from attune.core.clock import VirtualClock, run
from attune.core.config import RobotConfig
from attune.core.messages import ObjectSpec
from attune.core.scene import Scene, load_scene
from attune.robots.interface import LookTarget, PickTarget, PlaceTarget, Point, RobotFailure, Unreachable
from attune.robots.mujoco.robot import MujocoRobot

OBJECTS = ("white_cup", "white_bowl", "blue_milk", "green_cereal", "blue_spoon")
SURFACES = ("counter", "table", "island")
APART = 0.05
"""Between two objects' outlines [m]."""


@dataclass
class Trial:
    """What happened in one trial."""

    thing: str
    source: str
    goal: str
    outcome: str = "succeeded"
    error: float = math.nan
    robot_time: float = 0.0
    cpu_time: float = 0.0
    searches: list[float] = field(default_factory=list)


def reach(scene: Scene, thing: str) -> float:
    """Of an object around its middle, seen from above [m]."""
    return math.hypot(*scene.shape(thing).extent[:2]) / 2


def free_spot(robot: MujocoRobot, scene: Scene, surface: str, thing: str, rng: np.random.Generator) -> Point:
    """A random point of a surface, clear of the objects on it."""
    on = scene.surface(surface)
    others = [
        (robot.world.object_pose(name).position, reach(scene, name) + reach(scene, thing) + APART)
        for name in robot.world.object_names
        if name != thing
    ]
    while True:
        half = np.array(on.size) / 2 - 0.1
        x, y = rng.uniform(-half, half)
        point = on.to_map(float(x), float(y))
        if all(math.dist(point[:2], other[:2]) > apart for other, apart in others):
            return point


async def fetch(robot: MujocoRobot, clock: VirtualClock, trial: Trial, goal: Point) -> None:
    """Bring the trial's object to its goal, step by step."""

    async def search(target: LookTarget | PickTarget | PlaceTarget) -> None:
        start = time.process_time()
        poses = await robot.base_poses(target)
        trial.searches.append(time.process_time() - start)
        if not poses:
            raise Unreachable(type(target).__name__)
        await robot.navigate(poses[0])

    await robot.park_arms()
    seen_from = robot.world.object_pose(trial.thing).position
    await search(LookTarget(seen_from))
    await robot.look_at(seen_from)
    percepts = await robot.perceive(ObjectSpec(name=trial.thing))
    if not percepts:
        raise Unreachable("seeing it")
    await search(PickTarget(percepts[0]))
    arm = await robot.pick(percepts[0])
    await search(LookTarget(goal))
    await robot.look_at(goal)
    await robot.perceive()
    await search(PlaceTarget(arm, goal))
    await robot.place(arm, goal)


async def run_trial(trial: Trial, clock: VirtualClock, rng: np.random.Generator, seed: int) -> None:
    """One trial in a fresh kitchen."""
    scene = load_scene()
    robot = MujocoRobot(scene, clock, RobotConfig(seed=seed))
    world = robot.world
    start = free_spot(robot, scene, trial.source, trial.thing, rng)
    world.move_object(trial.thing, start, float(rng.uniform(-math.pi, math.pi)))
    goal = free_spot(robot, scene, trial.goal, trial.thing, rng)
    cpu = time.process_time()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(robot.run)
        try:
            await fetch(robot, clock, trial, goal)
            trial.error = math.dist(world.object_pose(trial.thing).position, goal)
            if not (trial.error < 0.04 and world.is_upright(trial.thing) and world.place_of(trial.thing) == trial.goal):
                trial.outcome = "misplaced"
        except RobotFailure as failure:
            trial.outcome = f"{type(failure).__name__}: {failure}"
        tasks.cancel_scope.cancel()
    trial.robot_time, trial.cpu_time = clock.now(), time.process_time() - cpu


def report(trials: list[Trial]) -> dict[str, object]:
    """The figures."""
    good = [trial for trial in trials if trial.outcome == "succeeded"]
    searches = [1000 * seconds for trial in trials for seconds in trial.searches]
    by_thing = {name: [trial for trial in trials if trial.thing == name] for name in OBJECTS}
    return {
        "trials": len(trials),
        "succeeded": len(good),
        "by_object": {
            name: f"{sum(trial in good for trial in group)}/{len(group)}" for name, group in by_thing.items()
        },
        "failures": Counter(f"{trial.thing} {trial.outcome}" for trial in trials if trial not in good),
        "placement_error_mm": {
            "mean": round(1000 * float(np.mean([trial.error for trial in good])), 1),
            "max": round(1000 * max(trial.error for trial in good), 1),
        }
        if good
        else {},
        "robot_time_s_mean": round(float(np.mean([trial.robot_time for trial in good])), 1) if good else None,
        "base_pose_search_ms": {
            "median": round(float(np.median(searches))),
            "p95": round(float(np.quantile(searches, 0.95))),
        },
        "simulated_s_per_cpu_s": round(sum(t.robot_time for t in trials) / sum(t.cpu_time for t in trials), 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=25)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    trials = []
    for number in range(options.trials):
        rng = np.random.default_rng((options.seed, number))
        source, goal = rng.choice(SURFACES, 2, replace=False)
        trial = Trial(OBJECTS[number % len(OBJECTS)], str(source), str(goal))
        clock = VirtualClock()
        run(lambda: run_trial(trial, clock, rng, number), clock)  # noqa: B023
        trials.append(trial)
    print(json.dumps(report(trials), indent=2))


if __name__ == "__main__":
    main()
