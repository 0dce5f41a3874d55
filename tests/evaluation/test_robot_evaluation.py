"""The robot's evaluation: the same seed gives the same tasks, impossible ones are told, and a trial can be judged."""

import json
from itertools import islice

import pytest
from typer.testing import CliRunner

from attune.cli.main import app
from attune.core.scene import load_scene
from attune.evaluation.robot import RobotEvaluation, Trial, Trier
from attune.evaluation.robot_draw import THING, Draw, draw, draws
from attune.evaluation.robot_report import to_data, to_markdown

SCENE = load_scene()


def trial(number: int, **changes: object) -> Trial:
    values = {
        "draw": Draw(number, "cup", "big", "counter", "fridge"), "problem": "", "error": 0.002, "retries": 0,
        "setbacks": (), "contacts": (), "cleared": (), "robot_time": 60.0, "computing_time": 3.0, "searches": (0.1,),
    }  # fmt: skip
    return Trial(**(values | changes))  # type: ignore[arg-type]


def test_the_same_seed_gives_the_same_tasks_and_another_gives_others() -> None:
    for number in range(6):
        assert draw(3, number) == draw(3, number)
    assert [draw(3, number).goal for number in range(30)] != [draw(4, number).goal for number in range(30)]


def test_the_draws_cover_all_types_and_all_surfaces() -> None:
    found = list(islice(draws(0), 130))
    assert {task.type for task in found} == set(SCENE.vocabulary.types)
    possible = [task for task in found if not task.why_not]
    assert {task.source for task in possible} == {surface.name for surface in SCENE.surfaces}
    assert {task.goal for task in possible} == {surface.name for surface in SCENE.surfaces}
    assert len(possible) > 60


def test_a_possible_draw_has_its_object_at_the_source_and_a_person_near_the_goal() -> None:
    for task in islice(draws(1), 20):
        if task.scene:
            assert task.scene.object(THING).at == task.source
            there = task.scene.surfaces_at(task.place)
            distances = {
                surface.name: sum((a - b) ** 2 for a, b in zip(surface.center, task.scene.user, strict=False))
                for surface in there
            }
            assert min(distances, key=distances.__getitem__) == task.goal


def test_a_draw_that_is_not_possible_says_why() -> None:
    refused = [task for task in islice(draws(0), 60) if task.why_not]
    assert refused
    assert all(task.scene is None and (task.source in task.why_not or task.goal in task.why_not) for task in refused)


@pytest.mark.slow
def test_what_stands_askew_in_a_compartment_is_taken_from_behind_its_open_door() -> None:
    # The box's broad side is to the front, so the hand must come along the back wall: few ways lead there.
    result = Trier(778)(254)
    assert isinstance(result, Trial)
    assert (result.problem, result.contacts) == ("", ())


def test_what_the_robots_own_arm_hides_is_not_run_into() -> None:
    # On the place stands bread that the carrying arm would hide from the camera if the robot stood anywhere.
    result = Trier(201)(31)
    assert isinstance(result, Trial)
    assert (result.problem, result.contacts) == ("", ())


def test_the_report_counts_successes_retries_and_contacts() -> None:
    trials = (trial(0), trial(1, retries=2, contacts=("arm touched cup",)), trial(2, problem="it is on the floor"))
    evaluation = RobotEvaluation(0, trials, (Draw(3, "bowl", "big", "counter", "cabinet", "cabinet is too low"),))
    data = to_data(evaluation)
    assert (data["succeeded"], data["retries"], data["forbidden_contacts"], data["without_retry"]) == (2, 2, 1, 1)
    assert data["to"] == {"fridge": {"trials": 3, "succeeded": 2, "retries": 2}}
    assert data["simulated_s_per_processor_s"] == 20.0
    text = to_markdown(evaluation)
    assert "it is on the floor" in text
    assert "cabinet is too low" in text


def test_a_trial_with_physics_is_played_and_reported(tmp_path) -> None:
    arguments = ["eval", "robot", "--trials", "1", "--seed", "8", "--jobs", "1", "--json", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    data = json.loads((tmp_path / "robot.json").read_text())
    assert data["trials"] == data["succeeded"] == 1, data
    assert data["placement_error_mm"]["max"] < 40
    assert data["grasp_search_ms"]["mean"] > 0
