"""Messages survive every edge unchanged, and bad data is refused with the field's name."""

import dataclasses

import pytest

from attune.core import messages as m
from attune.core.bus import TOPICS
from attune.core.codec import MessageFormatError, from_data, from_json, to_data, to_json

CUP = m.ObjectSpec(type="cup", color="red", size="small", location="cabinet", name="red_cup")
COMMANDS: tuple[m.Command, ...] = (
    m.BringMe(time=1.0, cause="utterance-1", objects=(CUP, m.ObjectSpec(type="bowl")), destination="table"),
    m.SettingBreakfast(time=1.0, band="older"),
    m.ReplaceObject(time=1.0, remove=CUP, add=m.ObjectSpec(type="bowl")),
    m.ChangeLocation(time=1.0, destination="countertop"),
    m.CancelObject(time=1.0, object=CUP),
    m.PutBack(time=1.0),
    m.CarryOn(time=1.0),
    m.Stop(time=1.0),
)
OTHERS: tuple[m.Message, ...] = (
    m.Utterance(time=2.0, text="bring me a cup", alternatives=("bring me a cop",), age=m.AgeEstimate(band="older")),
    m.StopSignal(time=2.0, state="spotted", source="spotter", word="stop"),
    m.CommandOutcome(time=3.0, command="command-1", kind="bring_me", status="failed", reason="not_found"),
    m.RobotState(time=3.0, step="paused", holding=(CUP,), queue=(m.QueuedTask(object=CUP, destination="table"),)),
    m.WorldState(time=3.0, objects=(m.BelievedObject(spec=CUP, place="counter", position=(1.0, 2.0, 0.9), seen=2.5),)),
    m.PlanTree(time=3.0, root=m.PlanNode(name="transport", children=(m.PlanNode(name="search", status="running"),))),
    m.Reply(time=4.0, text="Here is the cup.", supersedes=("reply-1",)),
    m.Retraction(time=4.0, replies=("reply-1",)),
    m.Manner(time=4.0, warn_before_movement=6.0),
    m.VoiceStatus(time=4.0, reply="reply-1", state="word", spoken="Here is"),
)  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.kind)
def test_a_command_survives_the_trip_through_json_with_its_kind(command: m.Command) -> None:
    assert from_json(m.Command, to_json(command)) == command


@pytest.mark.parametrize("message", OTHERS, ids=lambda message: type(message).__name__)
def test_a_message_survives_the_trip_through_plain_data(message: m.Message) -> None:
    assert from_data(type(message), to_data(message)) == message


def test_each_message_has_an_id_of_its_own() -> None:
    first, second = m.Stop(time=0.0), m.Stop(time=0.0)
    assert first.id != second.id
    assert first.id.startswith("command-")


def test_a_message_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        CUP.type = "bowl"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ('{"time": 1, "kind": "bring_me", "objects": "cup"}', "objects"),
        ('{"time": "soon", "kind": "stop"}', "time"),
        ('{"time": 1, "kind": "bring_me", "objects": [{"size": "gigantic"}]}', "size"),
        ("{", "JSON"),
    ],
)
def test_data_that_does_not_fit_is_refused_and_named(text: str, named: str) -> None:
    with pytest.raises(MessageFormatError, match=named):
        from_json(m.Command, text)


def test_topics_have_distinct_names() -> None:
    names = [topic.name for topic in TOPICS]
    assert len(names) == len(set(names))


def test_an_object_is_named_as_people_name_it() -> None:
    assert str(CUP) == "small red cup"
    assert str(m.ObjectSpec(type="milk", size="normal")) == "milk"
    assert str(m.ObjectSpec(color="blue")) == "blue object"
