"""The verdicts on the commands of a run, from the true world at its end and what was told on the way.

A command is executed when the final world is one of those that the commands may rightly lead to. A refusal is right
only if there was nothing to do.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from attune.core.config import PlannerConfig
from attune.core.messages import Band, CommandOutcome
from attune.core.scene import Scene
from attune.evaluation.planner_oracle import Effect, Moment, Oracle, Wishes, World
from attune.evaluation.planner_sayings import Saying

Status = Literal["executed", "refused", "ignored", "failed"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of one command.

    Attributes:
        status: `executed`: the world is as it should be. `refused`: nothing could be done, and a reason was told.
            `ignored`: it could have been done, but was refused or not answered. `failed`: the world is wrong.
        reason: Of a refusal, or what is wrong with the world.
    """

    saying: Saying
    status: Status
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a run left behind.

    Attributes:
        sayings: The commands given.
        moments: The state of things when each was given.
        told: For each command all that was told about it, in order.
        still: For each stop whether the robot stood still as it should.
        before: The world before.
        after: The world at the end.
        at_rest: Whether the robot came to rest.
    """

    band: Band
    sayings: tuple[Saying, ...]
    moments: tuple[Moment, ...]
    told: tuple[tuple[CommandOutcome, ...], ...]
    still: tuple[bool, ...]
    before: World
    after: World
    at_rest: bool


def judge(scene: Scene, config: PlannerConfig, evidence: Evidence) -> tuple[Verdict, ...]:
    """A verdict for each command of a run."""
    destination = destination_of(config, evidence.band)
    oracle = Oracle(scene, evidence.before, destination, config.breakfast)
    present = _present(scene, destination, evidence)
    options: set[Wishes] = {()}
    earlier: set[Wishes] = {()}
    may_refuse: list[bool] = []
    stopped = False
    for number, (saying, moment, told) in enumerate(
        zip(evidence.sayings, evidence.moments, evidence.told, strict=True)
    ):
        there = Counter({type_: 1 for type_ in saying.types if _already_there(type_, told, present)})
        effects: set[Effect] = set()
        for wishes in options:
            effects |= oracle.effects(number, saying, wishes, moment, there, stopped=stopped)
        stands_there = bool(saying.types) and all(there[type_] for type_ in saying.types)
        may_refuse.append(stands_there or any(not effect.possible for effect in effects))
        if _accepted(told):
            done = {effect.wishes for effect in effects if effect.possible}
            options = done or options
            stopped = saying.kind == "stop"
        elif saying.kind == "carry_on":
            stopped = False
        earlier |= options
    partial = bool(evidence.sayings) and evidence.sayings[-1].kind == "stop"
    ever = tuple({wish for wishes in earlier for wish in wishes})
    wrongs = [
        what_is_wrong(evidence) or oracle.misplaced(evidence.after, wishes, ever, may_be_partial=partial)
        for wishes in sorted(options, key=str)
    ]
    wrong = "" if "" in wrongs else wrongs[0]
    stills = iter(evidence.still)
    return tuple(
        _verdict(saying, told, refusable, wrong, next(stills) if saying.kind == "stop" else True)
        for saying, told, refusable in zip(evidence.sayings, evidence.told, may_refuse, strict=True)
    )


def destination_of(config: PlannerConfig, band: Band) -> str:
    """The kind of place to which things are brought for an age group."""
    places = {"younger": config.destination_younger, "older": config.destination_older}
    return places.get(band, config.destination_unknown)


def what_is_wrong(evidence: Evidence) -> str:
    """What must not be in any final world; "" when it is not."""
    if not evidence.at_rest:
        return "the robot did not come to rest"
    before, after = evidence.before, evidence.after
    if lost := sorted(set(before) - set(after)):
        return f"lost: {', '.join(lost)}"
    fallen = [name for name, thing in after.items() if before[name].upright and not (thing.upright or thing.held_by)]
    return f"not upright: {', '.join(fallen)}" if fallen else ""


def _present(scene: Scene, destination: str, evidence: Evidence) -> Counter[str]:
    """What stood at the destination from the beginning, on the surface nearest to the user."""
    surfaces = scene.surfaces_at(destination)
    nearest = min(surfaces, key=lambda surface: math.dist(surface.center[:2], scene.user)).name
    return Counter(thing.spec.type for thing in evidence.before.values() if thing.place == nearest)


def _accepted(told: Sequence[CommandOutcome]) -> bool:
    return bool(told) and told[0].status in {"accepted", "deferred"}


def _already_there(type_: str, told: Sequence[CommandOutcome], present: Counter[str]) -> bool:
    """Whether the robot says that one stands at the destination, and it did from the beginning."""
    return any(
        outcome.reason == "already_there" and outcome.object.type == type_ and present[type_] > 0 for outcome in told
    )


def _verdict(saying: Saying, told: Sequence[CommandOutcome], refusable: bool, wrong: str, still: bool) -> Verdict:
    if not told:
        return Verdict(saying, "ignored", "nothing was told")
    last = told[-1]
    if saying.kind == "stop":
        return Verdict(saying, "executed") if still else Verdict(saying, "failed", "the robot moved on")
    if not _accepted(told):
        nothing_to_do = refusable or (saying.kind == "carry_on" and not wrong)
        return Verdict(saying, "refused" if nothing_to_do and last.reason else "ignored", last.reason)
    if wrong:
        return Verdict(saying, "failed", f"{wrong}; told {last.status} {last.reason}".rstrip())
    if last.status == "failed":
        return Verdict(saying, "failed", f"told failed {last.reason}")
    return Verdict(saying, "executed")
