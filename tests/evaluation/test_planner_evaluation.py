"""The planner's evaluation: the matrix is whole, the verdicts come from the world and can fail, the report counts."""

import json
from dataclasses import replace
from typing import get_args

import pytest
from typer.testing import CliRunner

from attune.cli.main import app
from attune.core.config import PlannerConfig
from attune.core.messages import CommandOutcome, ObjectSpec
from attune.core.scene import load_scene
from attune.evaluation.planner import Player, evaluate_planner, failures
from attune.evaluation.planner_judge import Evidence, judge
from attune.evaluation.planner_matrix import interrupted, paper_permutations, undisturbed
from attune.evaluation.planner_oracle import Moment
from attune.evaluation.planner_report import to_data, to_markdown
from attune.evaluation.planner_sayings import Kind, Permutation, Saying
from attune.robots.simulated import TrueObject
from attune.robots.symbolic import SymbolicRobot

SCENE = load_scene()
TYPES = SCENE.vocabulary.types
ALONE = Permutation("every step", "bring_me", "older", (Saying("bring_me", "cup"),))


def world() -> dict[str, TrueObject]:
    from attune.core.clock import VirtualClock

    return dict(SymbolicRobot(SCENE, VirtualClock()).true_objects())


def put(objects: dict[str, TrueObject], name: str, place: str) -> dict[str, TrueObject]:
    return objects | {name: replace(objects[name], place=place, held_by=None if place else "right")}


def told(status: str, reason: str = "") -> CommandOutcome:
    return CommandOutcome(time=0.0, command="c", kind="bring_me", status=status, reason=reason)  # type: ignore[arg-type]


def verdicts(sayings, outcomes, after, still=(), at_rest=True, moments=()):
    moments = moments or tuple(Moment(world()) for _ in sayings)
    evidence = Evidence("older", sayings, moments, outcomes, still, world(), after, at_rest)
    return [verdict.status for verdict in judge(SCENE, PlannerConfig(), evidence)]


BRING = Saying("bring_me", "cup")
SWAP = Saying("replace_object", "bowl", "cup", at=3)
YES = (told("accepted"), told("done"))


def test_the_papers_part_has_each_type_each_ordered_pair_and_both_age_groups() -> None:
    found = list(paper_permutations(SCENE))
    pairs = {(p.sayings[1].instead_of, p.sayings[1].type) for p in found if p.sayings[-1].kind == "replace_object"}
    assert pairs == {(a, b) for a in TYPES for b in TYPES if a != b}
    assert {p.sayings[0].type for p in found if len(p.sayings) == 1 and p.scenario == "bring_me"} == set(TYPES)
    assert {p.sayings[1].type for p in found if p.sayings[-1].kind == "stop"} == set(TYPES)
    younger = [p.sayings for p in found if p.band == "younger"]
    assert younger == [p.sayings for p in found if p.band == "older"]


def test_each_run_is_interrupted_at_each_of_its_state_changes_by_each_command() -> None:
    for alone in undisturbed(SCENE):
        first = len(alone.sayings)
        commands = {p.sayings[first].kind for p in interrupted(SCENE, alone, 7)}
        for kind in commands:
            assert {p.sayings[first].at for p in interrupted(SCENE, alone, 7) if p.sayings[first].kind == kind} == {
                *range(8)
            }
        if alone.part == "each other":
            assert commands == set(get_args(Kind)) - {"carry_on"}
    others = [alone.scenario for alone in undisturbed(SCENE) if alone.part == "each other"]
    assert set(others) == set(get_args(Kind)) - {"stop"}
    swaps = [p.sayings[1] for p in interrupted(SCENE, ALONE, 7) if p.sayings[1].kind == "replace_object"]
    assert len(swaps) == 8 * (len(TYPES) - 1)


def test_a_cup_on_the_table_is_a_cup_that_was_brought() -> None:
    assert verdicts((BRING,), (YES,), put(world(), "red_cup", "table")) == ["executed"]


@pytest.mark.parametrize(
    "after",
    [
        world(),
        put(world(), "red_cup", "shelf"),
        put(world(), "red_cup", ""),
        put(world(), "white_bowl", "table"),
        put(put(world(), "red_cup", "table"), "white_bowl", "table"),
        put(put(world(), "red_cup", "table"), "blue_cup", "table"),
        {name: thing for name, thing in put(world(), "red_cup", "table").items() if name != "blue_cup"},
        put(world(), "red_cup", "table") | {"blue_cup": replace(world()["blue_cup"], upright=False)},
    ],
    ids=["nothing", "elsewhere", "in hand", "a bowl", "a bowl too", "two cups", "one lost", "one fallen"],
)
def test_any_other_world_is_a_failure(after) -> None:
    assert verdicts((BRING,), (YES,), after) == ["failed"]


def test_a_robot_that_does_not_come_to_rest_has_failed() -> None:
    assert verdicts((BRING,), (YES,), put(world(), "red_cup", "table"), at_rest=False) == ["failed"]


def test_a_replacement_leaves_only_the_new_object() -> None:
    assert verdicts((BRING, SWAP), (YES, YES), put(world(), "white_bowl", "table")) == ["executed", "executed"]
    both = put(put(world(), "white_bowl", "table"), "red_cup", "table")
    assert verdicts((BRING, SWAP), (YES, YES), both) == ["failed", "failed"]


def test_a_refusal_of_what_could_be_done_is_ignored_and_silence_too() -> None:
    cup = put(world(), "red_cup", "table")
    assert verdicts((BRING, SWAP), (YES, (told("refused", "not_found"),)), cup) == ["executed", "ignored"]
    assert verdicts((BRING, SWAP), (YES, ()), cup) == ["executed", "ignored"]


def test_a_second_cereal_is_rightly_refused_as_there_is_only_one() -> None:
    cereal = Saying("bring_me", "cereal")
    outcomes = (YES, (told("refused", "nothing_to_do"),))
    assert verdicts((cereal, cereal), outcomes, put(world(), "green_cereal", "table")) == ["executed", "refused"]


def test_a_stop_is_executed_when_the_robot_stood_still_even_with_something_in_its_hand() -> None:
    stop = Saying("stop", at=3)
    in_hand = put(world(), "red_cup", "")
    assert verdicts((BRING, stop), (YES, YES), in_hand, still=(True,)) == ["executed", "executed"]
    assert verdicts((BRING, stop), (YES, YES), in_hand, still=(False,)) == ["executed", "failed"]
    assert verdicts((BRING, stop), (YES, YES), put(world(), "red_cup", "shelf"), still=(True,))[0] == "failed"


def test_what_stands_at_the_destination_already_need_not_move() -> None:
    bread = Saying("bring_me", "bread")
    there = (told("accepted"), replace(told("done", "already_there"), object=ObjectSpec(type="bread")))
    evidence = Evidence("younger", (bread,), (Moment(world()),), (there,), (), world(), world(), True)
    assert [verdict.status for verdict in judge(SCENE, PlannerConfig(), evidence)] == ["executed"]


BOTH = Saying("bring_me", "cup", also="spoon")
ELSEWHERE = Saying("change_location", place="shelf", at=3)


def one_delivered() -> Moment:
    """The cup stands on the table and the person was told so, the spoon is still to come."""
    report = replace(told("done"), object=ObjectSpec(type="cup"), place="table")
    return Moment(put(world(), "red_cup", "table"), (told("accepted"), report))


def test_a_new_place_is_for_what_is_still_to_come_and_not_for_what_was_delivered() -> None:
    moments = (Moment(world()), one_delivered())
    right = put(put(world(), "red_cup", "table"), "blue_spoon", "shelf")
    assert verdicts((BOTH, ELSEWHERE), (YES, YES), right, moments=moments) == ["executed", "executed"]
    for wrong in (put(right, "red_cup", "shelf"), put(right, "blue_spoon", "table")):
        assert verdicts((BOTH, ELSEWHERE), (YES, YES), wrong, moments=moments) == ["failed", "failed"]


def test_what_was_just_put_down_and_not_reported_may_count_as_delivered_or_not() -> None:
    moments = (Moment(world()), replace(one_delivered(), told=(told("accepted"),)))
    spoon = put(world(), "blue_spoon", "shelf")
    for right in (put(spoon, "red_cup", "table"), put(spoon, "red_cup", "shelf")):
        assert verdicts((BOTH, ELSEWHERE), (YES, YES), right, moments=moments) == ["executed", "executed"]


def test_what_is_cancelled_or_put_back_must_not_be_brought() -> None:
    moments = (Moment(world()), one_delivered())
    cup = put(world(), "red_cup", "table")
    cancel, back = Saying("cancel_object", "spoon"), Saying("put_back")
    assert verdicts((BOTH, cancel), (YES, YES), cup, moments=moments) == ["executed", "executed"]
    assert verdicts((BOTH, cancel), (YES, YES), put(cup, "blue_spoon", "table"), moments=moments)[1] == "failed"
    assert verdicts((BOTH, back), (YES, YES), put(world(), "blue_spoon", "table"), moments=moments)[1] == "executed"
    assert verdicts((BOTH, back), (YES, YES), put(cup, "blue_spoon", "table"), moments=moments)[1] == "failed"


def test_an_object_from_another_place_than_the_named_one_is_a_failure() -> None:
    cup = Saying("bring_me", "cup", source="cabinet")
    assert verdicts((cup,), (YES,), put(world(), "white_cup", "table")) == ["executed"]
    assert verdicts((cup,), (YES,), put(world(), "red_cup", "table")) == ["failed"]


def test_a_replacement_by_what_stands_there_already_takes_the_old_one_back() -> None:
    first, swap = Saying("bring_me", "glass"), Saying("replace_object", "bread", "glass", at=22)
    run = Player("symbolic", 0)(Permutation("every step", "bring_me", "younger", (first, swap)))
    assert [verdict.status for verdict in run.verdicts] == ["executed", "executed"]


@pytest.mark.parametrize(
    ("band", "sayings"),
    [
        ("older", (Saying("bring_me", "glass"), Saying("stop", at=27), Saying("carry_on", at="settled"))),
        ("younger", (Saying("setting_breakfast"), Saying("put_back", at=59))),
        (
            "older",
            (
                Saying("bring_me", "cup", source="cabinet", place="shelf"),
                Saying("change_location", place="countertop", at=27),
            ),
        ),
    ],
    ids=["carry on", "put back", "change location"],
)
def test_what_was_just_put_down_is_the_object_that_is_meant(band, sayings) -> None:
    run = Player("symbolic", 0)(Permutation("each other", sayings[-1].kind, band, sayings))
    assert {verdict.status for verdict in run.verdicts} == {"executed"}


def test_every_command_of_a_sample_is_executed_or_rightly_refused() -> None:
    evaluation = evaluate_planner("symbolic", sample=120)
    assert len(evaluation.runs) == 120
    assert evaluation.of_all > 5000
    assert failures(evaluation.runs) == ()
    data, text = to_data(evaluation), to_markdown(evaluation)
    assert sum(sum(row[s] for s in ("executed", "refused")) for row in data["results"]) == sum(
        len(run.verdicts) for run in evaluation.runs
    )
    assert "98 %" in text
    assert "92 %" in text


def test_the_command_writes_its_report(tmp_path) -> None:
    result = CliRunner().invoke(
        app, ["eval", "planner", "--sample", "4", "--jobs", "1", "--json", "--out", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    assert json.loads((tmp_path / "planner.json").read_text())["runs"] == 4
    assert json.loads(result.stdout)["robot"] == "symbolic"
    assert "# Planner test: symbolic robot" in (tmp_path / "planner.md").read_text()
