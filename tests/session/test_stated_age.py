"""Who says how old they are is believed, whatever their voice says: where things go, and how the robot talks."""

from typing import Any

import pytest

from attune.core import messages as m
from attune.core.bus import COMMAND, OUTCOME, REPLY, UTTERANCE
from attune.core.clock import VirtualClock, run
from attune.core.config import Config, with_values
from attune.dialogue.profiles import ProfileStore
from attune.evaluation.speakers import UserAudio, people
from attune.session.session import Session

SOUNDS_YOUNG = m.AgeEstimate(probabilities=(0.19,) * 5 + (0.0125,) * 4, band="younger", confidence=0.95, source="model")
SOUNDS_OLD = m.AgeEstimate(probabilities=(0.01,) * 5 + (0.2375,) * 4, band="older", confidence=0.95, source="model")


async def place_of_spoon(session: Session, age: m.AgeEstimate) -> str:
    """Where a spoon goes that is asked for without a place."""
    before = dict(session.robot.true_objects())  # type: ignore[attr-defined]
    session.say("bring me a spoon", age=age)
    await session.settled()
    after = session.robot.true_objects()  # type: ignore[attr-defined]
    (moved,) = [thing for name, thing in after.items() if thing.position != before[name].position]
    return session.scene.surface(moved.place).place


@pytest.mark.parametrize(
    ("words", "voice", "band", "place"),
    [
        (["I am seventy-five"], SOUNDS_YOUNG, "older", "table"),
        (["I'm 75 years old."], SOUNDS_YOUNG, "older", "table"),
        (["I am twenty"], SOUNDS_OLD, "younger", "countertop"),
        (["I am eighty", "no, I am thirty"], SOUNDS_OLD, "younger", "countertop"),
        (["I am fifty-nine"], SOUNDS_OLD, "younger", "countertop"),
        (["I am sixty"], SOUNDS_YOUNG, "older", "table"),
        ([], SOUNDS_OLD, "older", "table"),
    ],
)
def test_what_a_person_says_of_their_age_wins_over_their_voice(
    config: Config, words: list[str], voice: m.AgeEstimate, band: str, place: str
) -> None:
    commands: list[m.Command] = []
    replies: list[m.Reply] = []
    places: list[str] = []
    clock = VirtualClock()

    async def main() -> None:
        session = Session(config, clock)
        session.bus.on(COMMAND, commands.append)
        session.bus.on(REPLY, replies.append)
        async with session.running():
            for text in words:
                session.say(text, age=voice)
                await clock.sleep(2)
            places.append(await place_of_spoon(session, voice))

    run(main, clock)
    assert places == [place]
    assert [getattr(command, "band", None) for command in commands] == [band]
    assert replies[-1].style == band


@pytest.mark.parametrize(
    ("older_from", "words", "band"),
    [
        ("fifties", "I am fifty-five", "older"),
        ("fifties", "I am forty-nine", "younger"),
        ("seventies", "I am sixty-nine years old", "younger"),
        ("seventies", "I'm in my seventies", "older"),
    ],
)
def test_who_counts_as_older_is_a_matter_of_configuration(
    config: Config, older_from: str, words: str, band: str
) -> None:
    commands: list[m.Command] = []
    clock = VirtualClock()

    async def main() -> None:
        session = Session(with_values(config, {"speech": {"older_from": older_from}}), clock)
        session.bus.on(COMMAND, commands.append)
        async with session.running():
            for text in (words, "bring me a spoon"):
                session.say(text)
                await clock.sleep(2)

    run(main, clock)
    assert [getattr(command, "band", None) for command in commands] == [band]


def test_it_is_remembered_with_consent_and_wins_in_the_next_talk(config: Config, tmp_path: Any) -> None:
    profiles = ProfileStore(tmp_path / "profiles.sqlite3")
    places: list[str] = []
    for words in (["remember me", "I am seventy-five"], []):
        clock = VirtualClock()

        async def main(clock: VirtualClock = clock, words: list[str] = words) -> None:
            session = Session(config, clock, profiles=profiles)
            async with session.running():
                for text in words:
                    session.say(text, age=SOUNDS_YOUNG)
                    await clock.sleep(2)
                places.append(await place_of_spoon(session, SOUNDS_YOUNG))

        run(main, clock)
    assert places == ["table", "table"]


def test_spoken_aloud_it_counts_as_well(config: Config) -> None:
    """A synthetic voice says it; until then the norms say nothing of the voice, and the neutral style holds."""
    commands: list[m.Command] = []
    outcomes: list[m.CommandOutcome] = []
    heard: list[m.Utterance] = []
    clock = VirtualClock()
    anna = UserAudio(clock, people()[4])

    async def main() -> None:
        session = Session(config, clock, audio=anna)
        session.bus.on(COMMAND, commands.append)
        session.bus.on(OUTCOME, outcomes.append)
        session.bus.on(UTTERANCE, heard.append)
        async with session.running():
            await clock.sleep(0.5)
            for text in ("bring me a cup", "i am seventy five", "bring me a bowl"):
                await clock.sleep(anna.say(text) - clock.now() + 3)
                await session.settled()

    run(main, clock)
    assert {utterance.age.band for utterance in heard} == {"unknown"}
    assert [getattr(command, "band", None) for command in commands] == ["unknown", "older"]
    assert [outcome.status for outcome in outcomes].count("done") == 2
