"""The permutations of the planner test: which commands, in which order, interrupting each other at which step.

The paper's own part has each command of its two scenarios once, for each object type, each ordered pair of types and
both age groups. The part beyond has the interruption at every step of the interrupted plan: at each change of the
robot's published state.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from attune.core.messages import Band, BringMe, CarryOn, Command, ObjectSpec, ReplaceObject, SettingBreakfast, Stop
from attune.core.scene import Scene

BANDS: tuple[Band, ...] = ("younger", "older")
Part = Literal["paper", "every step"]
ScenarioName = Literal["bring_me", "setting_breakfast"]
Moment = int | Literal["carrying", "settled"]
"""When a command is given: after so many state changes, when the robot carries something to its goal, or at the end."""


@dataclass(frozen=True, slots=True)
class Saying:
    """One command, and when it is given.

    Attributes:
        kind: Of the command.
        type: The object type it asks for, "" when it names none.
        instead_of: The type that a replacement removes.
        at: The moment, counted from the command before.
    """

    kind: Literal["bring_me", "replace_object", "setting_breakfast", "stop", "carry_on"]
    type: str = ""
    instead_of: str = ""
    at: Moment = 0

    def command(self, band: Band) -> Command:
        """As a message."""
        wanted = ObjectSpec(type=self.type)
        match self.kind:
            case "bring_me":
                return BringMe(time=0.0, objects=(wanted,), band=band)
            case "replace_object":
                return ReplaceObject(time=0.0, remove=ObjectSpec(type=self.instead_of), add=wanted, band=band)
            case "setting_breakfast":
                return SettingBreakfast(time=0.0, band=band)
            case "stop":
                return Stop(time=0.0, band=band)
            case "carry_on":
                return CarryOn(time=0.0, band=band)

    def __str__(self) -> str:
        what = f" {self.type}" if self.type else ""
        old = f" for {self.instead_of}" if self.instead_of else ""
        moment = f" after {self.at} changes" if isinstance(self.at, int) else f" when {self.at}"
        return f"{self.kind}{what}{old}{'' if self.at == 0 else moment}"


@dataclass(frozen=True, slots=True)
class Permutation:
    """One run of the test."""

    part: Part
    scenario: ScenarioName
    band: Band
    sayings: tuple[Saying, ...]

    def __str__(self) -> str:
        return f"{self.band}: {', then '.join(str(saying) for saying in self.sayings)}"


def paper_permutations(scene: Scene) -> Iterator[Permutation]:
    """The paper's: each command once for each object type or ordered pair of types, and both age groups."""
    types = scene.vocabulary.types
    for band in BANDS:
        for first in types:
            yield Permutation("paper", "bring_me", band, (_bring(first),))
            for second in types:
                if second != first:
                    swap = Saying("replace_object", second, first, at="carrying")
                    yield Permutation("paper", "bring_me", band, (_bring(first), swap))
        breakfast = Saying("setting_breakfast")
        yield Permutation("paper", "setting_breakfast", band, (breakfast,))
        for also in types:
            extra, stop = _bring(also, "carrying"), Saying("stop", at="carrying")
            yield Permutation("paper", "setting_breakfast", band, (breakfast, extra))
            yield Permutation("paper", "setting_breakfast", band, (breakfast, extra, stop))


def undisturbed(scene: Scene) -> Iterator[Permutation]:
    """The runs whose state changes are the moments of the part beyond the paper."""
    for band in BANDS:
        yield Permutation("every step", "setting_breakfast", band, (Saying("setting_breakfast"),))
        for first in scene.vocabulary.types:
            yield Permutation("every step", "bring_me", band, (_bring(first),))


def interrupted(scene: Scene, alone: Permutation, changes: int) -> Iterator[Permutation]:
    """An undisturbed run, interrupted by each command at each of its state changes.

    Args:
        scene: Names the object types.
        alone: The run.
        changes: How many states it publishes.
    """
    (first,) = alone.sayings
    for step in range(changes + 1):
        for second in scene.vocabulary.types:
            if first.kind == "setting_breakfast":
                yield _with(alone, _bring(second, step))
            elif second != first.type:
                yield _with(alone, Saying("replace_object", second, first.type, at=step))
        stop = Saying("stop", at=step)
        yield _with(alone, stop)
        yield _with(alone, stop, Saying("carry_on", at="settled"))


def sample(permutations: Sequence[Permutation], count: int, seed: int) -> tuple[Permutation, ...]:
    """At most `count` of them, chosen at random, in their order."""
    chosen = random.Random(seed).sample(range(len(permutations)), min(count, len(permutations)))
    return tuple(permutations[index] for index in sorted(chosen))


def _bring(type_: str, at: Moment = 0) -> Saying:
    return Saying("bring_me", type_, at=at)


def _with(alone: Permutation, *sayings: Saying) -> Permutation:
    return Permutation(alone.part, alone.scenario, alone.band, (*alone.sayings, *sayings))
