"""The robot's evaluation: random fetch-and-place tasks through the planner, with real physics, in virtual time."""

import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field

from attune.core.bus import PLAN
from attune.core.clock import Clock
from attune.core.config import RobotConfig
from attune.core.messages import BringMe, ObjectSpec, PlanNode, PlanTree
from attune.core.scene import Scene
from attune.evaluation.kitchen import Kitchen, moved
from attune.evaluation.parallel import in_parallel
from attune.evaluation.robot_draw import THING, Draw, draw
from attune.robots.interface import BasePose, PickTarget, Target
from attune.robots.mujoco.robot import MujocoRobot

TOLERANCE = 0.04
"""Farthest from where it was meant to be put that an object may stand [m]."""
WATCH_PERIOD = 0.02
"""Between two looks for forbidden contacts: the control period [s]."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One task as it went.

    Attributes:
        draw: The task, without its kitchen.
        problem: What is wrong at the end, "" when it succeeded.
        error: From where it was meant to be put to where it stands [m]; nan when it failed.
        retries: Attempts after the first.
        setbacks: Each part of the plan that failed on the way: its name and why.
        contacts: Forbidden contacts: robot part or carried object, and thing.
        robot_time: [s].
        cleared: Objects that were moved out of the way, as the robot told.
        computing_time: Processor time [s].
        searches: Processor time of each search for base poses to grasp from [s].
    """

    draw: Draw
    problem: str
    error: float
    retries: int
    setbacks: tuple[str, ...]
    contacts: tuple[str, ...]
    cleared: tuple[str, ...]
    robot_time: float
    computing_time: float
    searches: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class RobotEvaluation:
    """All trials, and the draws that are not possible."""

    seed: int
    trials: tuple[Trial, ...]
    impossible: tuple[Draw, ...]


class _MeasuredRobot(MujocoRobot):
    """Notes how long it searches for grasps."""

    def __init__(self, scene: Scene, clock: Clock, config: RobotConfig) -> None:
        super().__init__(scene, clock, config)
        self.searches: list[float] = []

    async def base_poses(self, target: Target) -> tuple[BasePose, ...]:
        began = time.process_time()
        poses = tuple(await super().base_poses(target))
        if isinstance(target, PickTarget):
            self.searches.append(time.process_time() - began)
        return poses


@dataclass
class _Record:
    """What is seen of a trial while it goes on."""

    trees: dict[float, PlanNode] = field(default_factory=dict)
    contacts: set[tuple[str, str]] = field(default_factory=set)

    def plan(self, tree: PlanTree) -> None:
        self.trees[tree.root.started or 0.0] = tree.root

    @property
    def nodes(self) -> Iterator[PlanNode]:
        for root in self.trees.values():
            yield from _nodes(root)


@dataclass(frozen=True, slots=True)
class Trier:
    """Plays tasks; may be sent to another process."""

    seed: int

    def __call__(self, number: int) -> Trial | Draw:
        """Play the task of this number; a task that is not possible comes back as it is."""
        task = draw(self.seed, number)
        return task if task.scene is None else self._play(task, task.scene)

    def _play(self, task: Draw, scene: Scene) -> Trial:
        began = time.process_time()
        robots: list[_MeasuredRobot] = []

        def make(scene: Scene, clock: Clock) -> _MeasuredRobot:
            robots.append(_MeasuredRobot(scene, clock, RobotConfig(seed=task.number)))
            return robots[0]

        kitchen = Kitchen(scene, make)
        (robot,) = robots
        record = _Record()
        kitchen.bus.on(PLAN, record.plan)
        at_rest = True

        wish = BringMe(time=0.0, objects=(ObjectSpec(name=THING, type=task.type),), destination=task.place)

        async def script() -> None:
            nonlocal at_rest
            kitchen.say(wish)
            at_rest = await kitchen.settle()

        def watch() -> None:
            record.contacts.update((*robot.world.forbidden_contacts(), *robot.world.bumps()))

        kitchen.play(script, meanwhile=lambda: kitchen.clock.every(WATCH_PERIOD, watch))
        error = _error(kitchen, THING)
        cleared = tuple(sorted({state.object.name for state in kitchen.states if state.step == "clearing"}))
        return Trial(
            draw=Draw(task.number, task.type, task.size, task.source, task.goal),
            problem=_problem(kitchen, task, wish, cleared) if at_rest else "the robot did not come to rest",
            error=error,
            retries=sum(_is_retry(node) for node in record.nodes),
            setbacks=tuple(f"{node.name}: {node.reason}" for node in record.nodes if _is_setback(node)),
            contacts=tuple(sorted(f"{part} touched {thing}" for part, thing in record.contacts)),
            cleared=cleared,
            robot_time=kitchen.clock.now(),
            computing_time=time.process_time() - began,
            searches=tuple(robot.searches),
        )


def evaluate_robot(
    trials: int = 300,
    *,
    seed: int = 0,
    jobs: int = 1,
    only: Sequence[int] = (),
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> RobotEvaluation:
    """Play so many possible tasks; impossible draws come apart.

    Args:
        trials: How many.
        seed: Of the tasks.
        jobs: Processes that work at the same time.
        only: Numbers of the tasks to play, instead of the first `trials` possible ones.
        on_progress: Told how many trials of how many are done.
    """
    numbers = tuple(only or _possible_and_not(seed, trials))
    played: list[Trial] = []
    impossible: list[Draw] = []
    for result in in_parallel(Trier(seed), numbers, jobs):
        if isinstance(result, Draw):
            impossible.append(result)
        else:
            played.append(result)
            on_progress(len(played), len(only) or trials)
    return RobotEvaluation(seed, tuple(played), tuple(impossible))


def _possible_and_not(seed: int, trials: int) -> Iterator[int]:
    """Numbers of draws until so many of them are possible."""
    number = possible = 0
    while possible < trials:
        yield number
        possible += not draw(seed, number).why_not
        number += 1


def _error(kitchen: Kitchen, name: str) -> float:
    """Distance between where the robot means to have put an object and where it really is [m]."""
    world = kitchen.believed()
    believed = next((item for item in world.objects if item.spec.name == name), None) if world else None
    if believed is None or believed.position is None or not believed.place:
        return math.nan
    surface = kitchen.scene.surface(believed.place)
    is_open = surface.container in kitchen.robot.status().opened
    # What was put into an open drawer has moved with it since.
    shift = (0.0, 0.0, 0.0) if is_open or not surface.container else surface.shift
    meant = tuple(value - moved for value, moved in zip(believed.position, shift, strict=True))
    return math.dist(meant, kitchen.after()[name].position)


def _problem(kitchen: Kitchen, task: Draw, wish: BringMe, cleared: Collection[str]) -> str:
    """What is wrong with the final world; "" when the task is done and nothing else has happened.

    What was moved out of the way, and told so, may be elsewhere: it has to stand on a surface where the robot believes
    it to be.
    """
    before, after = kitchen.before, kitchen.after()
    thing = after[THING]
    told = next((outcome for outcome in reversed(kitchen.outcomes) if outcome.command == wish.id), None)
    if told is None or told.status != "done":
        return f"told {told.status} {told.reason}: {told.detail}" if told else "nothing was told"
    if thing.spec.location != task.place:
        return f"it is on {thing.place or 'the floor'}"
    elsewhere = {name: now for name, now in moved(before, after).items() if name != THING}
    others = [f"{name} is on {now}" for name, now in elsewhere.items() if name not in cleared or not after[name].place]
    lost = [f"{name} is not where it is believed" for name in cleared if not _error(kitchen, name) < TOLERANCE]
    fallen = [f"{name} fell over" for name, now in after.items() if before[name].upright and not now.upright]
    opened = [f"{name} was left open" for name in sorted(kitchen.robot.status().opened)]
    if problems := [*others, *lost, *fallen, *opened]:
        return "; ".join(problems)
    error = _error(kitchen, THING)
    return f"it stands {1000 * error:.0f} mm from its spot" if not error < TOLERANCE else ""


def _nodes(node: PlanNode) -> Iterator[PlanNode]:
    yield node
    for child in node.children:
        yield from _nodes(child)


def _is_retry(node: PlanNode) -> bool:
    return node.name.startswith("attempt ") and node.name != "attempt 1"


def _is_setback(node: PlanNode) -> bool:
    """Whether a failure began at this node."""
    return node.status == "failed" and not any(child.status == "failed" for child in node.children)
