"""Exchanges as people have them with a whole session, typed, in virtual time: what is asked, answered and kept."""

from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, REPLY, VOICE_STATUS
from attune.core.clock import VirtualClock, run
from attune.core.config import load_config, with_values
from attune.dialogue.policies import Preferences
from attune.dialogue.profiles import ProfileStore
from attune.session.session import Session

OPTIONS: dict[str, dict[str, Any]] = {"robot": {"kind": "symbolic"}, "voice": {"output": "none"}}


class Talk:
    """What came of a talk: replies and commands, as words."""

    def __init__(self) -> None:
        self.replies: list[m.Reply] = []
        self.commands: list[m.Command] = []
        self.preferences = Preferences()

    @property
    def said(self) -> list[str]:
        return [reply.text for reply in self.replies if reply.urgency != "background"]

    def wanted(self) -> list[str]:
        return [str(spec) for command in self.commands if isinstance(command, m.BringMe) for spec in command.objects]


def hold(
    lines: Sequence[str | float],
    band: m.Band = "unknown",
    profiles: ProfileStore | None = None,
    statuses: list[m.VoiceStatus] | None = None,
    pause: float = 2.5,
    policies: str = "",
) -> Talk:
    """Say the lines one after the other; a number waits, "..." waits until the robot rests."""
    clock, talk = VirtualClock(), Talk()

    async def main() -> None:
        session = Session(
            with_values(load_config(environment={}), OPTIONS | {"dialogue": {"policies": policies}}),
            clock,
            profiles=profiles,
        )
        session.bus.on(REPLY, talk.replies.append)
        session.bus.on(COMMAND, talk.commands.append)
        session.bus.on(VOICE_STATUS, statuses.append if statuses is not None else lambda status: None)
        async with session.running():
            for line in lines:
                if isinstance(line, str) and line != "...":
                    session.say(line, m.AgeEstimate(band=band, confidence=1.0))
                    await clock.sleep(pause)
                elif isinstance(line, str):
                    await session.settled()
                else:
                    await clock.sleep(line)
        talk.preferences = session.dialogue.speaker.preferences

    run(main, clock)
    return talk


def test_a_question_stays_open_while_the_person_asks_something_else() -> None:
    talk = hold(["bring me the cup", "what are you doing?", "slower please", "the white one"])
    assert talk.said[0] in talk.said[1]
    assert talk.wanted() == ["white cup"]


def test_a_question_back_is_answered_and_taken_for_no_answer() -> None:
    talk = hold(["bring me a yellow cup", "what cups do you have?", "then the white one"])
    assert "four cups" in talk.said[1]
    assert talk.wanted() == ["white cup"]


def test_a_question_that_was_answered_before_it_was_spoken_is_not_asked_any_more() -> None:
    """Who types, or answers at once, is faster than the robot's voice."""
    statuses: list[m.VoiceStatus] = []
    talk = hold(
        ["hello", "bring me the cup", "what are you doing?", "the white one", 20.0], statuses=statuses, pause=0.2
    )
    asked = [reply.id for reply in talk.replies if reply.text.endswith("?") and "red cup" in reply.text]
    assert len(asked) == 2
    assert not [status for status in statuses if status.reply in asked and status.state in {"word", "finished"}]
    assert talk.wanted() == ["white cup"]


def test_the_answer_means_the_option_with_all_that_the_question_left_unsaid() -> None:
    assert hold(["bring me the red cup", "the small one"]).wanted() == ["small red cup"]
    (command,) = hold(["bring me the cup", "the red one"]).commands
    assert isinstance(command, m.BringMe)
    assert (command.objects[0].color, command.objects[0].size) == ("red", "normal")
    assert len(hold(["bring me the cup", "either"]).wanted()) == 1


def test_each_unclear_thing_is_asked_about_in_turn() -> None:
    talk = hold(["bring me the spoon and the cup and a plate", "the blue one", "the white one"])
    assert talk.wanted() == ["plate", "blue spoon", "white cup"]
    assert "spoon" in talk.said[0]
    assert "cup" in talk.said[-2]


def test_no_answers_a_question_and_an_old_question_is_no_question_any_more() -> None:
    assert hold(["bring me the red plate", "no", "yes"]).commands == []
    assert hold(["bring me the red plate", 25.0, "yes"]).commands == []


@pytest.mark.parametrize(
    ("lines", "refusal"),
    [
        (["carry on"], "carry on"),
        (["put it back"], "put back"),
        (["cancel the cup"], "wasn't"),
        (["bring me the red glass to the table", "...", "bring me the red glass to the table"], "already"),
        (["set the table", 3.0, "set the table"], "already"),
        (["bring me the big white spoon to the fridge"], "no room"),
    ],
)
def test_what_is_refused_is_not_first_promised(lines: list[str | float], refusal: str) -> None:
    before = hold(lines[:-1]).said
    (answer,) = hold(lines).said[len(before) :]
    assert refusal in answer


def test_more_than_there_is_is_neither_promised_nor_passed_over() -> None:
    said = hold(["bring me three spoons"]).said
    assert "two spoons" in said[0]
    assert "no further spoon" in said[1]


def test_where_my_cup_is_means_the_one_that_was_just_brought() -> None:
    talk = hold(["bring me the blue cup", "...", "where is my cup?"])
    assert "blue cup" in talk.said[-1]
    assert "on the table" in talk.said[-1]


def test_what_there_is_is_counted() -> None:
    assert "four cups" in hold(["how many cups are there?"]).said[0]
    assert "are" in hold(["where are the spoons?"]).said[0]


def test_a_wish_that_cannot_go_further_is_said_so_and_one_step_back_is_heard() -> None:
    talk = hold(["speak up"] * 4 + ["quieter"], band="older")
    loud = [reply.loudness for reply in talk.replies]
    assert loud[:2] == [1.0, 1.0]
    assert "louder than this" in talk.said[2]
    assert loud[-1] < 1.0


WISHES: dict[str, tuple[str, float]] = {
    "slower please": ("rate", -1), "faster": ("rate", 1), "speak up": ("loudness", 1), "quieter": ("loudness", -1),
}  # fmt: skip


@pytest.mark.parametrize("wish", WISHES)
@pytest.mark.parametrize("band", ["older", "younger", "unknown"])
def test_a_wish_is_heard_in_the_next_reply_stays_for_the_talk_and_ends_with_normal(wish: str, band: m.Band) -> None:
    field, direction = WISHES[wish]
    talk = hold(["hello", wish, *["thank you"] * 20, "normal", "hello"], band=band)
    heard = [getattr(reply, field) for reply in talk.replies]
    assert (heard[1] - heard[0]) * direction > 0
    assert set(heard[1:-2]) == {heard[1]}
    assert heard[-1] == heard[0]


@pytest.mark.parametrize("band", ["older", "younger", "unknown"])
def test_how_much_is_told_follows_the_wish_and_not_the_age(band: m.Band) -> None:
    def announcements(*wishes: str) -> int:
        return sum(r.urgency == "background" for r in hold([*wishes, "bring me a spoon", "..."], band=band).replies)

    assert announcements("tell me what you are doing") >= 6
    assert announcements("you don't have to tell me everything") == 0
    assert announcements("talk less") == 0


def test_how_to_speak_to_whom_is_data(tmp_path: Path) -> None:
    """A file of policies of one's own: how a change is confirmed, how fast, where things go, and whether they wait."""
    standard = (resources.files("attune.data") / "policies.toml").read_text()
    changed = {
        "restate = true": "restate = false",
        "rate = 165": "rate = 222",
        'destination = ""': 'destination = "countertop"',
    }
    for old, new in changed.items():
        standard = standard.replace(old, new)
    file = tmp_path / "policies.toml"
    file.write_text(standard)
    lines = ["bring me the white plate", "a bowl instead"]
    talk, usual = hold(lines, policies=str(file)), hold(lines)
    assert "bowl" in usual.said[-1]
    assert "bowl" not in talk.said[-1]
    assert {reply.rate for reply in talk.replies} == {222}
    assert getattr(talk.commands[0], "destination", "") == "countertop"


def test_bring_it_means_what_the_robot_has_just_spoken_of() -> None:
    assert hold(["do you have juice?", "bring it"]).wanted() == ["juice"]
    unclear = hold(["do you have a red cup?", "bring it"])
    assert unclear.commands == []
    assert unclear.said[-1].endswith("?")


def test_a_question_about_a_blue_one_is_about_the_kind_that_was_named_before() -> None:
    assert "blue cup" in hold(["bring me the red cup", "do you have a blue one?"]).said[-1]
    assert "blue plate" in hold(["do you have a red plate?", "do you have a blue one?"]).said[-1]


@pytest.mark.parametrize("opening", ["robot", "hey, robot!", "bring me", "robot, could you get me"])
def test_who_calls_the_robot_or_breaks_off_is_asked_what_it_shall_do(opening: str) -> None:
    talk = hold([opening, 6.0, "the white plate"])
    assert talk.said[0].startswith("Yes?")
    assert talk.wanted() == ["white plate"]


def test_another_place_for_one_thing_of_several_leaves_the_others_where_they_belong() -> None:
    commands = hold(["set the table", 8.0, "bring the cereal to the counter"]).commands
    (moved,) = [command for command in commands if isinstance(command, m.ChangeLocation)]
    assert [spec.type for spec in moved.objects] == ["cereal"]
    assert len(commands) == 2


def test_whether_it_is_done_is_answered_at_rest_and_at_work() -> None:
    assert "done" in hold(["bring me the blue cup", "...", "are you done?"]).said[-1]
    assert "Not yet" in hold(["bring me the blue cup", "are you done?"]).said[-1]


def test_what_was_said_about_a_stop_is_cut_short_when_the_robot_goes_on() -> None:
    statuses: list[m.VoiceStatus] = []
    talk = hold(["bring me the white plate", 6.0, "stop", "carry on", 6.0], "older", statuses=statuses, pause=0.8)
    (stopped,) = [reply.id for reply in talk.replies if "stopped" in reply.text]
    assert [status.state for status in statuses if status.reply == stopped][-1] == "interrupted"
    assert not [status for status in statuses if status.reply == stopped and "carry on" in status.spoken]


DOUBTFUL = "bring the white plate home tonight"


def test_where_it_is_doubtful_whether_the_robot_was_asked_it_asks_before_it_moves() -> None:
    asked = hold([DOUBTFUL])
    assert asked.commands == []
    assert "white plate" in asked.said[0]
    assert asked.said[0].endswith("?")
    assert hold([DOUBTFUL, "yes"]).wanted() == ["white plate"]
    assert hold([DOUBTFUL, "no"]).commands == []
    assert hold([DOUBTFUL, "a spoon, please"]).wanted() == ["spoon"]


def test_what_is_on_its_way_goes_elsewhere_when_it_is_named_with_a_place_and_is_fetched_once() -> None:
    talk = hold(["bring me the blue cup and the milk", 4.0, "the cup can go on the counter", "..."])
    assert [command.kind for command in talk.commands] == ["bring_me", "change_location"]
    moved = talk.commands[1]
    assert isinstance(moved, m.ChangeLocation)
    assert [str(spec) for spec in moved.objects] == ["blue cup"]
    assert moved.destination == "countertop"


def test_who_agrees_to_a_doubtful_order_may_name_another_place() -> None:
    doubtful = "put the milk back on the counter of the shop tonight"
    agreed = hold([doubtful, "yes, but put it on the table"])
    assert "counter" in agreed.said[0]
    assert [(command.kind, command.destination) for command in agreed.commands if isinstance(command, m.BringMe)] == [
        ("bring_me", "table")
    ]


def test_forget_me_forgets_the_wishes_of_this_talk_too(tmp_path: Path) -> None:
    profiles = ProfileStore(tmp_path / "profiles.sqlite3")
    talk = hold(["remember me", "I am seventy five", "slower please", "forget me", "hello"], profiles=profiles)
    assert talk.preferences == Preferences()
    assert talk.replies[-1].style == "unknown"
    assert profiles.all() == ()
