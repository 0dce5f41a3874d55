"""The two scenarios of the paper's system trials (section 4), judged by where things really are.

A scenario is what the person says, and when; the verdict compares the simulated world before and after.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from attune.core.messages import RobotState
from attune.robots.simulated import TrueObject

World = Mapping[str, TrueObject]

STANDSTILL = 0.01
"""A robot stands still when no joint moves faster than this [m/s or rad/s]."""


@dataclass(frozen=True, slots=True)
class Line:
    """One thing the person says.

    Attributes:
        text: The words.
        when: The moment is right when this holds for the robot's state.
        delay: How long after that moment they begin [s].
        command: The kind of command it should become.
    """

    text: str
    when: Callable[[RobotState], bool]
    delay: float
    command: str


@dataclass(frozen=True, slots=True)
class Check:
    """One claim about the world, and whether it holds."""

    claim: str
    holds: bool
    detail: str = ""


@dataclass(frozen=True, slots=True)
class Ending:
    """What is known when a scenario has ended.

    Attributes:
        before: The world when the session began.
        after: The world now.
        top_speed: The fastest joint motion in the last seconds of observation [m/s or rad/s].
        state: The robot's last symbolic state.
    """

    before: World
    after: World
    top_speed: float
    state: RobotState

    def moved(self) -> dict[str, TrueObject]:
        """Objects that are not on the surface where they started."""
        return {name: now for name, now in self.after.items() if now.place != self.before[name].place}


@dataclass(frozen=True, slots=True)
class Scenario:
    """A script and its verdict."""

    name: Literal["bring_me", "breakfast"]
    title: str
    lines: tuple[Line, ...]
    judge: Callable[[Ending], tuple[Check, ...]]


def _carrying(kind: str) -> Callable[[RobotState], bool]:
    return lambda state: (
        state.step == "transporting_deliver" and state.move_base and any(spec.type == kind for spec in state.holding)
    )


def _judge_bring_me(ending: Ending) -> tuple[Check, ...]:
    moved = ending.moved()
    bowls = [name for name, thing in moved.items() if thing.spec.type == "bowl" and thing.place]
    cups = [name for name, thing in moved.items() if thing.spec.type == "cup"]
    others = [name for name in moved if name not in bowls]
    held = [name for name, thing in ending.after.items() if thing.held_by]
    fallen = [name for name in bowls if not ending.after[name].upright]
    return (
        Check(
            "the bowl was brought",
            len(bowls) == 1,
            ", ".join(f"{name} on {ending.after[name].place}" for name in bowls) or "no bowl was moved",
        ),
        Check("the bowl stands upright", not fallen, ", ".join(fallen)),
        Check("the cup is back where it came from", not cups, ", ".join(cups)),
        Check("nothing but the bowl was brought", not others, ", ".join(others)),
        Check("the hands are empty", not held, ", ".join(held)),
    )


def _judge_breakfast(ending: Ending) -> tuple[Check, ...]:
    moved = ending.moved()
    cups = [name for name, thing in moved.items() if thing.spec.type == "cup"]
    lost = [name for name, thing in ending.after.items() if not thing.place and not thing.held_by]
    delivered = [name for name, thing in moved.items() if thing.place]
    return (
        Check("a cup was added to the breakfast", len(cups) == 1, _whereabouts(ending.after, cups)),
        Check("breakfast things were brought before", bool(delivered), _whereabouts(ending.after, delivered)),
        Check(
            "the robot stands still",
            ending.top_speed < STANDSTILL,
            f"fastest joint {ending.top_speed:.4f} rad/s or m/s",
        ),
        Check("the plan has stopped", ending.state.step == "stopped", ending.state.step),
        Check("nothing was dropped or lost", not lost, ", ".join(lost)),
    )


def _whereabouts(world: World, names: list[str]) -> str:
    def where(thing: TrueObject) -> str:
        return f"in the {thing.held_by} hand" if thing.held_by else f"on {thing.place or 'the floor'}"

    return ", ".join(f"{name} {where(world[name])}" for name in names)


BRING_ME = Scenario(
    name="bring_me",
    title="“Bring me a cup”, and on the way “I would like a bowl instead”",
    lines=(
        Line("bring me a cup", lambda state: state.step in ("idle", "task_done"), 1.0, "bring_me"),
        Line("I would like a bowl instead", _carrying("cup"), 1.0, "replace_object"),
    ),
    judge=_judge_bring_me,
)

BREAKFAST = Scenario(
    name="breakfast",
    title="“Please make breakfast”, then “bring me a cup as well”, then “stop!”",
    lines=(
        Line("please make breakfast", lambda state: state.step in ("idle", "task_done"), 1.0, "setting_breakfast"),
        Line("bring me a cup as well", lambda state: state.step == "transporting_deliver", 1.0, "bring_me"),
        Line("stop!", _carrying("cup"), 1.0, "stop"),
    ),
    judge=_judge_breakfast,
)

SCENARIOS: Mapping[str, Scenario] = {scenario.name: scenario for scenario in (BRING_ME, BREAKFAST)}
