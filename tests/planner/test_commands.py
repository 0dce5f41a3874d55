"""Each command alone, from a robot at rest."""

import pytest

from attune.core.config import PlannerConfig
from attune.core.messages import (
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    Command,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    Stop,
)


def spec(text: str) -> ObjectSpec:
    words = text.split()
    sizes = [word for word in words if word in {"small", "normal", "big"}]
    colors = [word for word in words if word in {"red", "green", "blue", "white", "yellow", "black", "purple"}]
    return ObjectSpec(type=words[-1], color="".join(colors), size="".join(sizes))  # type: ignore[arg-type]


def bring(*texts: str, to: str = "", **fields: object) -> BringMe:
    return BringMe(time=0.0, objects=tuple(spec(text) for text in texts), destination=to, **fields)  # type: ignore[arg-type]


def test_bring_me_delivers_the_object_and_tells_so(make_kitchen):
    kitchen = make_kitchen()
    command = bring("red cup")

    async def script():
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    assert kitchen.of(command) == [("accepted", ""), ("done", "")]
    kitchen.check_nothing_lost()


@pytest.mark.parametrize(
    "name", [item.name for item in __import__("attune.core.scene", fromlist=["x"]).load_scene().objects]
)
def test_every_object_can_be_brought_and_put_back(make_kitchen, name):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(name=name),), destination="table"))
        await kitchen.settle()
        assert kitchen.where(name) == "table"
        kitchen.say(PutBack(time=0.0, object=ObjectSpec(name=name)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {}
    kitchen.check_nothing_lost()


@pytest.mark.parametrize(("band", "surface"), [("younger", "island"), ("older", "table"), ("unknown", "table")])
def test_the_default_destination_follows_the_age_band(make_kitchen, band, surface):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("blue milk", band=band))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_milk": surface}


def test_several_objects_come_one_after_the_other_and_the_command_ends_once(make_kitchen):
    kitchen = make_kitchen()
    command = bring("green cereal", "blue spoon", "yellow juice", to="table")

    async def script():
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert set(kitchen.moved()) == {"green_cereal", "blue_spoon", "yellow_juice"}
    told = [(o.status, o.object.type) for o in kitchen.outcomes]
    assert told == [("accepted", ""), ("done", "cereal"), ("done", "spoon"), ("done", "juice"), ("done", "")]
    assert kitchen.states[-1].progress == 1.0
    kitchen.check_nothing_lost()


def test_an_object_comes_from_the_place_that_was_named(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", location="cabinet"),)))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_cup": "table"}


def test_things_can_be_put_into_a_container(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("blue milk", to="fridge"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_milk": "fridge"}
    kitchen.check_nothing_lost()


def test_breakfast_is_the_configured_set(make_kitchen):
    kitchen = make_kitchen(config=PlannerConfig(breakfast=("bowl", "milk", "spoon")))
    command = SettingBreakfast(time=0.0)

    async def script():
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.at("table") == {"bowl", "milk", "spoon"}
    assert kitchen.of(command)[-1] == ("done", "")


def test_breakfast_brings_nothing_twice(make_kitchen):
    kitchen = make_kitchen()
    again = SettingBreakfast(time=0.0)

    async def script():
        kitchen.say(bring("white bowl"))
        await kitchen.settle()
        kitchen.say(SettingBreakfast(time=0.0))
        await kitchen.settle()
        kitchen.say(again)
        await kitchen.settle()

    kitchen.play(script)
    assert sorted(kitchen.scene.object(name).type for name in kitchen.moved()) == ["bowl", "cereal", "milk", "spoon"]
    assert kitchen.of(again) == [("refused", "already_there")]


def test_what_was_delivered_is_exchanged(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red cup"))
        await kitchen.settle()
        kitchen.say(ReplaceObject(time=0.0, remove=spec("cup"), add=spec("white bowl")))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"white_bowl": "table"}
    kitchen.check_nothing_lost()


def test_what_was_delivered_is_moved_to_the_new_place(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red cup"))
        await kitchen.settle()
        kitchen.say(ChangeLocation(time=0.0, destination="shelf"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "shelf"}
    kitchen.check_nothing_lost()


def test_put_back_returns_what_was_delivered_last(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red cup"))
        await kitchen.settle()
        kitchen.say(bring("white bowl"))
        await kitchen.settle()
        kitchen.say(PutBack(time=0.0))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        (bring("unicorn"), "unknown_object"),
        (bring("purple cup"), "not_found"),
        (bring("red cup", to="moon"), "unknown_place"),
        (BringMe(time=0.0, objects=(ObjectSpec(type="cup", location="moon"),)), "unknown_place"),
        (BringMe(time=0.0, objects=()), "nothing_to_do"),
        (BringMe(time=0.0, objects=(ObjectSpec(),)), "unknown_object"),
        (ReplaceObject(time=0.0, remove=spec("cup"), add=spec("purple bowl")), "not_found"),
        (ChangeLocation(time=0.0, destination="table"), "nothing_to_do"),
        (ChangeLocation(time=0.0, destination="moon"), "unknown_place"),
        (CancelObject(time=0.0, object=spec("cup")), "nothing_to_do"),
        (PutBack(time=0.0), "nothing_to_do"),
        (PutBack(time=0.0, object=spec("cup")), "already_there"),
        (CarryOn(time=0.0), "nothing_to_do"),
    ],
    ids=lambda value: value if isinstance(value, str) else value.kind,
)
def test_what_cannot_be_done_is_refused_with_its_reason(make_kitchen, command: Command, reason):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(command)
        await kitchen.clock.sleep(5.0)

    kitchen.play(script)
    assert kitchen.of(command) == [("refused", reason)]
    assert kitchen.moved() == {}


def test_what_is_expected_to_stand_there_is_looked_at_and_not_moved(make_kitchen):
    kitchen = make_kitchen()
    command, again = bring("yellow bread", to="countertop"), bring("yellow bread", to="countertop")

    async def script():
        kitchen.say(command)
        await kitchen.settle()
        kitchen.say(again)
        await kitchen.clock.sleep(1.0)

    kitchen.play(script)
    assert kitchen.moved() == {}
    assert kitchen.of(command) == [("accepted", ""), ("done", "already_there")]
    assert kitchen.of(again) == [("refused", "already_there")]
    assert kitchen.states[-1].step == "already_done"


def test_a_refusal_offers_the_nearest_thing_that_exists(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("purple small cup"))
        await kitchen.clock.sleep(1.0)

    kitchen.play(script)
    alternative = kitchen.outcomes[-1].alternative
    assert alternative is not None
    assert (alternative.type, alternative.size) == ("cup", "small")


def test_one_unknown_object_does_not_keep_the_others_from_coming(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red cup", "purple unicorn"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "table"}
    assert [(o.status, o.reason) for o in kitchen.outcomes] == [
        ("accepted", ""),
        ("refused", "unknown_object"),
        ("done", ""),
    ]


def test_a_second_cup_is_another_cup(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("cup"), bring("cup"))
        await kitchen.settle()
        kitchen.say(bring("cup"))
        await kitchen.settle()

    kitchen.play(script)
    assert sorted(kitchen.scene.object(name).type for name in kitchen.moved()) == ["cup", "cup", "cup"]


def test_stop_at_rest_is_accepted_and_nothing_moves(make_kitchen):
    kitchen = make_kitchen()
    command = Stop(time=0.0)

    async def script():
        kitchen.signal("confirmed")
        kitchen.say(command)
        await kitchen.clock.sleep(2.0)

    kitchen.play(script)
    assert kitchen.of(command) == [("accepted", ""), ("done", "stopped")]
    assert kitchen.states[-1].step == "stopped"
    assert kitchen.robot.status().halted


def test_what_was_delivered_stays_there_when_its_move_is_cancelled_while_the_fingers_close(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("blue spoon"))
        await kitchen.settle()
        kitchen.say(ChangeLocation(time=0.0, destination="shelf"))
        await kitchen.until(lambda state: not state.interruptible)
        kitchen.say(CancelObject(time=0.0, object=spec("spoon")))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_spoon": "table"}
    kitchen.check_nothing_lost()
