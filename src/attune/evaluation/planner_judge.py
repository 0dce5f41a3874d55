"""What the final world must be after a permutation of commands: an oracle that knows nothing of the planner.

It counts, for each object type, how many objects the accepted commands want at the destination, and looks whether just
these have been brought there and all others are where they were. A refusal is right only if there was nothing to do.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from attune.core.config import PlannerConfig
from attune.core.messages import Band, CommandOutcome
from attune.core.scene import Scene
from attune.evaluation.kitchen import moved
from attune.evaluation.planner_matrix import Saying
from attune.robots.simulated import TrueObject

World = Mapping[str, TrueObject]
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
        told: For each command all that was told about it, in order.
        still: For each stop whether the robot stood still as it should.
        before: The world before.
        after: The world at the end.
        at_rest: Whether the robot came to rest.
    """

    band: Band
    sayings: tuple[Saying, ...]
    told: tuple[tuple[CommandOutcome, ...], ...]
    still: tuple[bool, ...]
    before: World
    after: World
    at_rest: bool


def judge(scene: Scene, config: PlannerConfig, evidence: Evidence) -> tuple[Verdict, ...]:
    """A verdict for each command of a run."""
    destination = destination_of(config, evidence.band)
    surfaces = scene.surfaces_at(destination)
    places = {surface.name for surface in surfaces}
    nearest = min(surfaces, key=lambda surface: math.dist(surface.center[:2], scene.user)).name
    stock = Counter(thing.spec.type for thing in evidence.before.values())
    present = Counter(thing.spec.type for thing in evidence.before.values() if thing.place == nearest)
    wanted: Counter[str] = Counter()
    feasible: list[bool] = []
    for saying, told in zip(evidence.sayings, evidence.told, strict=True):
        # What the person finds at the nearest surface of that place already need not be brought.
        left = stock - wanted - (Counter() if _accepted(told) else present)
        possible = _is_possible(saying, wanted, left, config)
        feasible.append(possible)
        if possible and _accepted(told) and not _already_there(told, present):
            _want(saying, wanted, config)
        elif saying.kind == "replace_object" and _accepted(told):
            wanted -= Counter({saying.instead_of: 1})
    stopped = bool(evidence.sayings) and evidence.sayings[-1].kind == "stop"
    wrong = what_is_wrong(evidence, wanted, places, may_be_partial=stopped)
    stills = iter(evidence.still)
    return tuple(
        _verdict(saying, told, possible, wrong, next(stills) if saying.kind == "stop" else True)
        for saying, told, possible in zip(evidence.sayings, evidence.told, feasible, strict=True)
    )


def destination_of(config: PlannerConfig, band: Band) -> str:
    """The kind of place to which things are brought for an age group."""
    places = {"younger": config.destination_younger, "older": config.destination_older}
    return places.get(band, config.destination_unknown)


def what_is_wrong(evidence: Evidence, wanted: Counter[str], places: set[str], *, may_be_partial: bool) -> str:
    """How the final world differs from what it should be; "" when it is right.

    Args:
        evidence: The run.
        wanted: How many objects of each type are wanted at the destination.
        places: The destination's surfaces.
        may_be_partial: The robot was stopped: it may hold something and not have brought all.
    """
    if not evidence.at_rest:
        return "the robot did not come to rest"
    before, after = evidence.before, evidence.after
    if lost := sorted(set(before) - set(after)):
        return f"lost: {', '.join(lost)}"
    fallen = [name for name, thing in after.items() if before[name].upright and not (thing.upright or thing.held_by)]
    if fallen:
        return f"not upright: {', '.join(fallen)}"
    return _misplaced(before, after, wanted, places, may_be_partial=may_be_partial)


def _misplaced(before: World, after: World, wanted: Counter[str], places: set[str], *, may_be_partial: bool) -> str:
    where = moved(before, after)
    brought = Counter(after[name].spec.type for name, now in where.items() if now in places)
    astray = {name: now for name, now in where.items() if now not in places}
    if may_be_partial:
        astray = {name: now for name, now in astray.items() if now != "hand"}
    if astray:
        return f"astray: {', '.join(f'{name} on {now}' for name, now in astray.items())}"
    right = brought <= wanted if may_be_partial else brought == wanted
    return "" if right else f"brought {_words(brought)} instead of {_words(wanted)}"


def _is_possible(saying: Saying, wanted: Counter[str], left: Counter[str], config: PlannerConfig) -> bool:
    """Whether there is anything to do for a command."""
    match saying.kind:
        case "bring_me" | "replace_object":
            return left[saying.type] > 0
        case "setting_breakfast":
            return any(not wanted[type_] for type_ in config.breakfast)
        case "stop" | "carry_on":
            return True


def _want(saying: Saying, wanted: Counter[str], config: PlannerConfig) -> None:
    match saying.kind:
        case "bring_me":
            wanted[saying.type] += 1
        case "replace_object":
            wanted[saying.type] += 1
            wanted[saying.instead_of] = max(0, wanted[saying.instead_of] - 1)
        case "setting_breakfast":
            for type_ in config.breakfast:
                wanted[type_] = max(1, wanted[type_])
        case "stop" | "carry_on":
            pass


def _accepted(told: Sequence[CommandOutcome]) -> bool:
    return bool(told) and told[0].status in {"accepted", "deferred"}


def _already_there(told: Sequence[CommandOutcome], present: Counter[str]) -> bool:
    """Whether the robot found the object at the destination, and it was there from the beginning."""
    return any(outcome.reason == "already_there" and present[outcome.object.type] > 0 for outcome in told)


def _verdict(saying: Saying, told: Sequence[CommandOutcome], possible: bool, wrong: str, still: bool) -> Verdict:
    if not told:
        return Verdict(saying, "ignored", "nothing was told")
    last = told[-1]
    if saying.kind == "stop":
        return Verdict(saying, "executed") if still else Verdict(saying, "failed", "the robot moved on")
    if not _accepted(told):
        nothing_to_do = not possible or (saying.kind == "carry_on" and not wrong)
        return Verdict(saying, "refused" if nothing_to_do and last.reason else "ignored", last.reason)
    if wrong:
        return Verdict(saying, "failed", f"{wrong}; told {last.status} {last.reason}".rstrip())
    if last.status == "failed":
        return Verdict(saying, "failed", f"told failed {last.reason}")
    return Verdict(saying, "executed")


def _words(types: Counter[str]) -> str:
    return ", ".join(sorted(types.elements())) or "nothing"
