"""What goes wrong is noticed and handled; what cannot be done is told with its reason."""

import pytest

from attune.core.messages import BringMe, ChangeLocation, ObjectSpec, PutBack
from attune.robots.interface import (
    BasePose,
    Collision,
    ContainerStuck,
    GraspMissed,
    ObjectLost,
    ObjectNotThere,
    PathBlocked,
    PlacementFailed,
    RobotFailure,
    Unreachable,
)

ANYWHERE = BasePose(0.0, 0.0, 0.0)


def bring(name: str, **fields: str) -> BringMe:
    return BringMe(time=0.0, objects=(ObjectSpec(name=name),), **fields)  # type: ignore[arg-type]


FAILURES = [
    ("navigate", PathBlocked(ANYWHERE)),
    ("navigate", Collision("base", "chair")),
    ("pick", GraspMissed("red_cup", "right")),
    ("pick", ObjectNotThere("red_cup")),
    ("pick", Unreachable("red_cup")),
    ("pick", Collision("arm", "shelf")),
    ("place", Unreachable("the spot")),
    ("place", PlacementFailed("red_cup", "leans")),
    ("place", ObjectLost("red_cup", "right")),
    ("place", Collision("arm", "milk")),
]


@pytest.mark.parametrize(("action", "failure"), FAILURES, ids=lambda value: str(value)[:24])
@pytest.mark.parametrize("times", [1, 2])
def test_a_failure_that_passes_does_not_keep_the_object_from_coming(make_kitchen, action, failure: RobotFailure, times):
    kitchen = make_kitchen()
    command = bring("red_cup")

    async def script():
        kitchen.robot.fail_next(action, failure, times)
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    assert kitchen.of(command) == [("accepted", ""), ("done", "")]
    kitchen.check_nothing_lost()


@pytest.mark.parametrize("action", ["open", "close"])
@pytest.mark.parametrize("times", [1, 2])
def test_a_stuck_drawer_is_tried_again(make_kitchen, action, times):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.fail_next(action, ContainerStuck("drawer"), times)
        kitchen.say(bring("blue_spoon"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_spoon": "table"}


@pytest.mark.parametrize(
    ("action", "failure", "reason"),
    [
        ("navigate", PathBlocked(ANYWHERE), "blocked"),
        ("pick", GraspMissed("red_cup", "right"), "grasp_failed"),
        ("pick", Unreachable("red_cup"), "unreachable"),
    ],
    ids=lambda value: str(value)[:24],
)
def test_a_failure_that_stays_is_told_and_the_next_object_comes(make_kitchen, action, failure, reason):
    kitchen = make_kitchen()
    hopeless, feasible = bring("red_cup"), bring("white_bowl")

    async def script():
        kitchen.robot.fail_next(action, failure, 1000)
        kitchen.say(hopeless)
        await kitchen.until(lambda state: state.step == "failed")
        kitchen.robot.heal()
        kitchen.say(feasible)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(hopeless) == [("accepted", ""), ("failed", reason)]
    alternative = next(outcome.alternative for outcome in kitchen.outcomes if outcome.status == "failed")
    assert (alternative.type if alternative else "") == ("" if reason == "blocked" else "cup")
    assert kitchen.moved() == {"white_bowl": "table"}
    kitchen.check_nothing_lost()


def test_a_command_of_which_not_all_arrived_ends_as_failed_and_tells_how_many(make_kitchen):
    kitchen = make_kitchen()
    command = BringMe(time=0.0, objects=(ObjectSpec(name="red_cup"), ObjectSpec(name="white_bowl")))

    async def script():
        kitchen.robot.remove_object("red_cup")
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    last = [outcome for outcome in kitchen.outcomes if outcome.command == command.id][-1]
    assert (last.status, last.detail, last.object.name) == ("failed", "1 of 2 arrived", "")


def test_what_cannot_be_put_down_there_goes_home(make_kitchen):
    kitchen = make_kitchen()
    command = bring("red_cup")

    async def script():
        kitchen.say(command)
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.robot.fail_next("place", Unreachable("the spot"), 1000)
        await kitchen.until(lambda state: state.step == "failed")
        kitchen.robot.heal()
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(command)[-1] == ("failed", "unreachable")
    assert kitchen.moved() == {}
    kitchen.check_nothing_lost()


def test_what_can_be_put_down_nowhere_stays_in_the_hand_and_is_told(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.robot.fail_next("place", Unreachable("the spot"), 1000)
        await kitchen.settle()
        assert kitchen.where("red_cup") == "hand"
        kitchen.robot.heal()
        kitchen.say(PutBack(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert [outcome.status for outcome in kitchen.outcomes].count("failed") == 2
    assert kitchen.moved() == {}


def test_an_object_that_somebody_moved_is_found_elsewhere(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.move_object("red_cup", "shelf")
        kitchen.say(bring("red_cup"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.where("red_cup") == "table"
    kitchen.check_nothing_lost()


def test_an_object_moved_into_a_cupboard_is_found_there(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.move_object("red_cup", "dishwasher")
        kitchen.say(bring("red_cup"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.where("red_cup") == "table"
    kitchen.check_nothing_lost()


def test_an_object_moved_at_the_last_moment_is_taken_where_it_is(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: state.step == "transporting_fetch" and state.move_arm)
        kitchen.robot.move_object("red_cup", "counter")
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    kitchen.check_nothing_lost()


def test_another_of_the_same_kind_comes_when_the_first_is_gone(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.remove_object("red_cup")
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", color="red"),)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"small_red_cup": "table"}


def test_an_object_that_is_nowhere_is_told_with_the_nearest_alternative(make_kitchen):
    kitchen = make_kitchen()
    command = BringMe(time=0.0, objects=(ObjectSpec(type="bowl", color="white"),))

    async def script():
        kitchen.robot.remove_object("white_bowl")
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(command) == [("accepted", ""), ("failed", "not_found")]
    alternative = kitchen.outcomes[-1].alternative
    assert alternative is not None
    assert alternative.name == "green_bowl"
    kitchen.check_nothing_lost()


def test_an_object_that_was_added_can_be_asked_for_once_it_was_seen(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.add_object("purple_cup", "cup", "purple", "normal", "counter")
        kitchen.say(bring("white_bowl"))
        await kitchen.settle()
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", color="purple"),)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.where("purple_cup") == "table"


def test_an_object_that_only_the_person_knows_of_is_looked_for_where_they_say(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.robot.add_object("purple_cup", "cup", "purple", "normal", "shelf")
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", color="purple", location="shelf"),)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.where("purple_cup") == "table"


def test_what_is_taken_out_of_the_gripper_is_noticed_and_found(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding) and state.move_base)
        await kitchen.clock.sleep(1.0)
        kitchen.robot.move_object("red_cup", "island")
        await kitchen.clock.sleep(1.0)
        assert not kitchen.states[-1].holding
        await kitchen.settle()
        assert kitchen.where("red_cup") == "table"
        kitchen.say(PutBack(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {}
    kitchen.check_nothing_lost()


def test_what_was_taken_from_the_named_place_is_looked_for_everywhere_when_it_is_lost(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", location="cabinet"),)))
        await kitchen.until(lambda state: bool(state.holding) and state.move_base)
        kitchen.robot.move_object("white_cup", "island")
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_cup": "table"}


def test_what_is_taken_out_of_the_gripper_for_good_is_told(make_kitchen):
    kitchen = make_kitchen()
    command = bring("red_cup")

    async def script():
        kitchen.say(command)
        await kitchen.until(lambda state: bool(state.holding) and state.move_base)
        kitchen.robot.remove_object("red_cup")
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(command)[-1][0] == "failed"


def test_a_place_that_is_full_is_told_and_the_object_goes_home(make_kitchen):
    kitchen = make_kitchen()
    command = bring("green_cereal", destination="cabinet")

    async def script():
        for index in range(6):
            kitchen.robot.add_object(f"extra_{index}", "plate", "white", "big", "cabinet")
        kitchen.say(bring("white_cup"))
        await kitchen.settle()
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(command)[-1] == ("failed", "no_space")
    assert kitchen.where("green_cereal") == "counter"


def test_a_camera_that_misses_things_only_costs_time(make_kitchen):
    kitchen = make_kitchen(miss_rate=0.3)

    async def script():
        kitchen.say(bring("red_cup"), bring("blue_spoon"), bring("red_milk"))
        await kitchen.settle()
        kitchen.say(ChangeLocation(time=0.0, destination="countertop"))
        await kitchen.settle()

    kitchen.play(script)
    assert {kitchen.where(name) for name in ("red_cup", "blue_spoon", "red_milk")} <= {"table", "island"}
