"""The planner's evaluation: all permutations of the paper's test, and each interruption at each step, in simulation."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

from attune.core.clock import Clock
from attune.core.config import PlannerConfig, RobotConfig
from attune.core.messages import Command, CommandOutcome, RobotState
from attune.core.scene import Scene, load_scene
from attune.evaluation.kitchen import Kitchen
from attune.evaluation.parallel import in_parallel
from attune.evaluation.planner_judge import Evidence, Verdict, judge
from attune.evaluation.planner_matrix import interrupted, paper_permutations, undisturbed
from attune.evaluation.planner_matrix import sample as sample_of
from attune.evaluation.planner_oracle import Moment
from attune.evaluation.planner_sayings import Permutation, Saying
from attune.robots.interface import Robot

RobotKind = Literal["symbolic", "mujoco"]
STANDSTILL = 0.01
"""A robot stands still when no joint moves faster [m/s or rad/s]."""
STOPPING_TIME = 0.3
"""After which a stopped robot must stand still [s]."""
WATCHED = 4.0
"""So long it must go on standing still [s]."""
COARSE = 0.5
"""Control period of the symbolic robot [s]: what is tested is the order of things."""


@dataclass(frozen=True, slots=True)
class Run:
    """One permutation as it went.

    Attributes:
        verdicts: One per command.
        changes: State changes after the last command.
        robot_time: [s].
        computing_time: Processor time [s].
    """

    permutation: Permutation
    verdicts: tuple[Verdict, ...]
    changes: int
    robot_time: float
    computing_time: float


@dataclass(frozen=True, slots=True)
class PlannerEvaluation:
    """All runs.

    Attributes:
        of_all: How many permutations there are; more than `runs` when they were sampled.
    """

    robot: RobotKind
    seed: int
    runs: tuple[Run, ...]
    of_all: int


@dataclass(frozen=True, slots=True)
class Player:
    """Plays permutations; may be sent to another process."""

    robot: RobotKind
    seed: int

    def __call__(self, permutation: Permutation) -> Run:
        """Play one permutation in a fresh kitchen and judge it."""
        scene, config = _scene(), PlannerConfig()
        began = time.process_time()
        kitchen = Kitchen(scene, self._robot, config)
        commands = [saying.command(permutation.band) for saying in permutation.sayings]
        still: list[bool] = []
        moments: list[Moment] = []
        at_rest, before_last = True, 0

        async def script() -> None:
            nonlocal at_rest, before_last
            for saying, command in zip(permutation.sayings, commands, strict=True):
                await _wait_for(kitchen, saying)
                moments.append(Moment(kitchen.after(), tuple(kitchen.outcomes)))
                before_last = len(kitchen.states)
                kitchen.say(command)
                if saying.kind == "stop":
                    still.append(await _stands_still(kitchen))
            at_rest = await kitchen.settle()

        kitchen.play(script)
        evidence = Evidence(
            permutation.band,
            permutation.sayings,
            tuple(moments),
            tuple(_told(kitchen, command) for command in commands),
            tuple(still),
            kitchen.before,
            kitchen.after(),
            at_rest,
        )
        return Run(
            permutation,
            judge(scene, config, evidence),
            len(kitchen.states) - before_last,
            kitchen.clock.now(),
            time.process_time() - began,
        )

    def _robot(self, scene: Scene, clock: Clock) -> Robot:
        if self.robot == "symbolic":
            from attune.robots.symbolic import SymbolicRobot

            return SymbolicRobot(scene, clock, self.seed, tick=COARSE)
        from attune.robots.mujoco.robot import MujocoRobot

        return MujocoRobot(scene, clock, RobotConfig(seed=self.seed))


def evaluate_planner(
    robot: RobotKind,
    *,
    seed: int = 0,
    sample: int = 0,
    jobs: int = 1,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> PlannerEvaluation:
    """Play the whole test, or a random sample of it.

    Args:
        robot: On which robot.
        seed: Of the robot's camera and planning.
        sample: At most so many runs; 0 plays all.
        jobs: Processes that work at the same time.
        on_progress: Told how many runs of how many are done.
    """
    scene = _scene()
    # The moments come from the symbolic robot: it publishes the same states, in a hundredth of the time.
    alone = tuple(undisturbed(scene))
    first = tuple(in_parallel(Player("symbolic", seed), alone, jobs))
    permutations: list[Permutation] = list(paper_permutations(scene))
    for run in first:
        permutations += interrupted(scene, run.permutation, run.changes)
    chosen = _chosen(permutations, sample, seed)
    runs: list[Run] = []
    for run in in_parallel(Player(robot, seed), chosen, jobs):
        runs.append(run)
        on_progress(len(runs), len(chosen))
    return PlannerEvaluation(robot, seed, tuple(runs), len(permutations))


@cache
def _scene() -> Scene:
    """The kitchen that comes with Attune, once for each process."""
    return load_scene()


def _chosen(permutations: Sequence[Permutation], count: int, seed: int) -> Sequence[Permutation]:
    """All, or a sample, half of it from each part."""
    if not count:
        return permutations
    paper = [item for item in permutations if item.part == "paper"]
    beyond = [item for item in permutations if item.part != "paper"]
    half = min(len(paper), (count + 1) // 2)
    return (*sample_of(paper, half, seed), *sample_of(beyond, count - half, seed))


async def _wait_for(kitchen: Kitchen, saying: Saying) -> None:
    if isinstance(saying.at, int):
        await kitchen.after_changes(saying.at)
    elif saying.at == "settled":
        await kitchen.settle()
    else:
        await kitchen.until(_carries)


def _carries(state: RobotState) -> bool:
    return state.step == "transporting_deliver" and state.move_base and bool(state.holding)


async def _stands_still(kitchen: Kitchen) -> bool:
    """Whether the robot stops in time and then neither moves nor changes its state."""
    await kitchen.clock.sleep(STOPPING_TIME)
    ends = kitchen.clock.now() + WATCHED
    while kitchen.clock.now() < ends:
        if kitchen.speed() > STANDSTILL:
            return False
        await kitchen.clock.sleep(0.1)
    return kitchen.states[-1].step == "stopped"


def _told(kitchen: Kitchen, command: Command) -> tuple[CommandOutcome, ...]:
    return tuple(outcome for outcome in kitchen.outcomes if outcome.command == command.id)


def failures(runs: Iterable[Run]) -> tuple[tuple[Run, Verdict], ...]:
    """The commands that were ignored or failed."""
    return tuple((run, item) for run in runs for item in run.verdicts if item.status in {"ignored", "failed"})
