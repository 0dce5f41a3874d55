"""The verdicts of the paper's scenarios come from the world alone, and can fail."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from attune.core.clock import VirtualClock, run
from attune.core.config import load_config, with_values
from attune.core.messages import ObjectSpec, RobotState
from attune.evaluation.scenarios import BREAKFAST, BRING_ME, SCENARIOS, Ending, Scenario
from attune.evaluation.trial import TrialResult, run_trial
from attune.robots.simulated import TrueObject

CUP = TrueObject(ObjectSpec(type="cup", color="white"), "counter", (0.0, 0.0, 0.9), None)
BOWL = TrueObject(ObjectSpec(type="bowl", color="white"), "counter", (0.5, 0.0, 0.9), None)
MILK = TrueObject(ObjectSpec(type="milk", color="blue"), "counter", (1.0, 0.0, 0.9), None)
BEFORE = {"cup": CUP, "bowl": BOWL, "milk": MILK}


def verdict(
    scenario: Scenario, after: Mapping[str, TrueObject], *, speed: float = 0.0, step: str = "task_done"
) -> bool:
    state = RobotState(time=0.0, step=step)  # type: ignore[arg-type]
    return all(check.holds for check in scenario.judge(Ending(BEFORE, BEFORE | dict(after), speed, state)))


def on_table(thing: TrueObject) -> TrueObject:
    return replace(thing, place="table", position=(3.0, 0.0, 0.75))


def in_hand(thing: TrueObject) -> TrueObject:
    return replace(thing, place="", held_by="right")


def test_only_the_bowl_on_the_table_passes() -> None:
    assert verdict(BRING_ME, {"bowl": on_table(BOWL)})


@pytest.mark.parametrize(
    "after",
    [
        {},
        {"cup": on_table(CUP)},
        {"bowl": on_table(BOWL), "cup": on_table(CUP)},
        {"bowl": on_table(BOWL), "cup": in_hand(CUP)},
        {"bowl": on_table(BOWL), "milk": on_table(MILK)},
        {"bowl": replace(on_table(BOWL), upright=False)},
        {"bowl": in_hand(BOWL)},
    ],
    ids=["nothing", "the cup", "both", "cup kept", "milk too", "tipped over", "still held"],
)
def test_anything_else_fails(after: Mapping[str, TrueObject]) -> None:
    assert not verdict(BRING_ME, after)


def test_a_stopped_robot_with_the_cup_in_its_hand_passes_breakfast() -> None:
    assert verdict(BREAKFAST, {"milk": on_table(MILK), "cup": in_hand(CUP)}, step="stopped")


@pytest.mark.parametrize(
    ("after", "speed", "step"),
    [
        ({"milk": on_table(MILK), "cup": in_hand(CUP)}, 0.2, "stopped"),
        ({"milk": on_table(MILK), "cup": in_hand(CUP)}, 0.0, "task_done"),
        ({"milk": on_table(MILK)}, 0.0, "stopped"),
        ({"cup": in_hand(CUP)}, 0.0, "stopped"),
        ({"milk": replace(MILK, place=""), "bowl": on_table(BOWL), "cup": in_hand(CUP)}, 0.0, "stopped"),
    ],
    ids=["still moving", "did not stop", "no cup", "no breakfast", "milk on the floor"],
)
def test_breakfast_fails_otherwise(after: Mapping[str, TrueObject], speed: float, step: str) -> None:
    assert not verdict(BREAKFAST, after, speed=speed, step=step)


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_typed_scenarios_pass_with_the_robot_without_physics(name: str) -> None:
    values = {"robot": {"kind": "symbolic"}, "voice": {"output": "none"}}
    config, clock = with_values(load_config(environment={}), values), VirtualClock()

    async def main() -> TrialResult:
        return await run_trial(SCENARIOS[name], config, clock, None)

    result = run(main, clock)
    assert result.passed, result.checks
    assert result.repetitions == 0


def test_a_line_whose_moment_never_comes_is_said_when_the_robot_rests() -> None:
    values = {"robot": {"kind": "symbolic"}, "voice": {"output": "none"}}
    config, clock = with_values(load_config(environment={}), values), VirtualClock()
    wish, change = BRING_ME.lines
    late = replace(BRING_ME, lines=(wish, replace(change, when=lambda state: False)))
    result = run(lambda: run_trial(late, config, clock, None), clock)
    assert result.passed
    assert result.robot_time < 400
