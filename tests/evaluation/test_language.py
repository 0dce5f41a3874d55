import json
from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from typing import Any, Literal

import pytest

from attune.core.clock import VirtualClock, run
from attune.evaluation.language.hard_benchmark import hard_items
from attune.evaluation.language.items import Item, Meaning, ObjectSlots
from attune.evaluation.language.paper_benchmark import paper_items
from attune.evaluation.language.report import LanguageReport
from attune.evaluation.language.run import benchmark_items, evaluate
from attune.evaluation.language.scoring import Answer, score

TYPES = {"milk", "bowl", "cereal", "spoon", "cup", "plate", "bread", "knife", "fork", "glass", "juice", "mug"}
COLORS = {"", "red", "green", "blue", "white", "yellow", "black"}
PLACES = {"", "countertop", "table", "cabinet", "dishwasher", "drawer", "fridge", "shelf"}


def report(answer: Callable[[Item], Awaitable[dict[str, Any]]], items: tuple[Item, ...]) -> LanguageReport:
    clock = VirtualClock()

    async def respond(asked: Sequence[Item], receive: Callable[[dict[str, Any]], None]) -> None:
        for item in asked:
            await clock.sleep(0.01)
            receive(await answer(item))

    return run(lambda: evaluate("test", items, respond, clock, at_once=4), clock)


async def knows_all(item: Item) -> dict[str, Any]:
    return item.expected.model_dump()


def item(command: str, *add: ObjectSlots, remove: tuple[ObjectSlots, ...] = (), destination: str = "") -> Item:
    meaning = Meaning.model_validate({"command": command, "add": add, "remove": remove, "destination": destination})
    return Item("x", "hard", "group", "something", meaning)


def test_the_first_part_follows_the_papers_recipe() -> None:
    items = paper_items()
    assert Counter(entry.group for entry in items) == {"bring_me": 800, "replace_object": 1770, "setting_breakfast": 41}
    assert len({entry.utterance for entry in items}) == 2611
    assert not any("{" in entry.utterance for entry in items)
    added = [slots for entry in items for slots in entry.expected.add]
    assert {slots.type for slots in added} == {"milk", "bowl", "cereal", "spoon", "cup"}
    assert {slots.color for slots in added} == {"", "green", "blue", "red", "white"}
    assert {slots.size for slots in added} == {"", "small", "normal", "big"}
    assert {slots.location for slots in added} == {"", "countertop", "dishwasher", "cabinet"}
    assert {slots.location for entry in items for slots in entry.expected.remove} == {""}


@pytest.mark.parametrize(("part", "least"), [("hard", 400), ("fresh", 100)])
def test_the_harder_parts_keep_to_the_file_format(part: Literal["hard", "fresh"], least: int) -> None:
    items = hard_items(part)
    assert len(items) >= least
    assert len({entry.id for entry in items}) == len(items)
    for entry in items:
        meaning = entry.expected
        known = TYPES | {spec["type"] for spec in entry.context.get("scene", ())}
        for slots in (*meaning.add, *meaning.remove):
            assert slots.type in known, entry
            assert slots.color in COLORS, entry
            assert slots.location in PLACES, entry
        assert meaning.destination in PLACES, entry
        assert bool(meaning.add) == (meaning.command in ("bring_me", "replace_object")), entry
        assert bool(meaning.remove) == (meaning.command == "replace_object"), entry
        if meaning.command == "change_location":
            assert meaning.destination, entry
        json.dumps(dict(entry.context))


def test_right_answers_score_full_marks_in_every_column() -> None:
    result = score(report(knows_all, benchmark_items()).answers)
    assert result.whole.right == result.whole.of == 2611 + len(hard_items()) + len(hard_items("fresh"))
    assert all(tally.right == tally.of > 2000 for tally in result.add.values())
    assert all(tally.right == tally.of >= 1770 for tally in result.remove.values())
    assert result.false_commands.right == result.missed_stops.right == result.false_stops.right == 0


def test_a_robot_that_ignores_everybody_misses_each_stop_and_makes_no_false_command() -> None:
    async def ignores(item: Item) -> dict[str, Any]:
        return {"command": "other"}

    result = score(report(ignores, hard_items()).answers)
    assert result.missed_stops.right == result.missed_stops.of > 30
    assert result.false_commands.right == 0
    assert result.false_commands.of > 100


def test_each_property_is_judged_by_itself() -> None:
    expected = ObjectSlots(type="cup", color="red", size="big")
    found = Meaning(command="bring_me", add=(ObjectSlots(type="cup", color="blue", size="big"),))
    result = score([Answer(item("bring_me", expected), found)])
    assert {name: tally.right for name, tally in result.add.items()} == {
        "type": 1, "color": 0, "size": 1, "location": 1,
    }  # fmt: skip
    assert result.command.right == 1
    assert result.whole.right == 0


def test_an_object_that_is_missing_is_wrong_in_every_property() -> None:
    two = (ObjectSlots(type="cup"), ObjectSlots(type="fork"))
    result = score([Answer(item("bring_me", *two), Meaning(command="bring_me", add=two[:1]))])
    assert all(tally.right == 0 for tally in result.add.values())


def test_the_order_of_objects_does_not_matter() -> None:
    two = (ObjectSlots(type="cup"), ObjectSlots(type="fork"))
    assert score([Answer(item("bring_me", *two), Meaning(command="bring_me", add=two[::-1]))]).whole.right == 1


def test_a_wrong_destination_shows() -> None:
    answer = Answer(
        item("change_location", destination="table"), Meaning(command="change_location", destination="shelf")
    )
    assert answer.wrong == ("destination",)
    assert score([answer]).destination.right == 0


def test_a_stop_made_from_something_else_counts_as_false_stop_and_false_command() -> None:
    result = score([Answer(item("other"), Meaning(command="stop"))])
    assert (result.false_stops.right, result.false_commands.right) == (1, 1)


def test_an_answer_that_is_no_valid_line_counts_as_failed() -> None:
    async def broken(item: Item) -> dict[str, Any]:
        return {"error": "boom"}

    found = report(broken, hard_items()[:3])
    assert score(found.answers).failed.right == 3
    assert "command" in found.errors[0].note


def test_the_report_shows_the_papers_table_with_ours_and_lists_each_error() -> None:
    async def colour_blind(item: Item) -> dict[str, Any]:
        line = item.expected.model_dump()
        line["add"] = [slots | {"color": ""} for slots in line["add"]]
        return line

    found = report(colour_blind, benchmark_items(sample=100))
    text = found.to_markdown()
    assert "| paper, 1106 | 81.57 | 89.08 |" in text
    assert "| **test** | **100.00** | **100.00** |" in text
    assert text.count("expected:") == len(found.errors) > 20
    data = json.loads(json.dumps(found.to_data()))
    assert data["parts"]["paper"]["items"] == 100
    assert (
        data["parts"]["paper"]["score"]["add"]["color"]["count"]
        < data["parts"]["paper"]["score"]["add"]["type"]["count"]
    )
    assert len(data["errors"]) == len(found.errors)


@pytest.mark.parametrize("sample", [0, 7, 100, 5000])
def test_a_sample_is_spread_over_each_part(sample: int) -> None:
    items = benchmark_items(sample=sample)
    counts = Counter(entry.part for entry in items)
    sizes = {"paper": 2611, "hard": len(hard_items()), "fresh": len(hard_items("fresh"))}
    assert counts == {part: min(sample or size, size) for part, size in sizes.items()}
    assert {entry.group for entry in items if entry.part == "paper"} >= {"bring_me", "replace_object"}
