import json
import os
import sqlite3
import stat
import subprocess
import sys
from pathlib import Path

import anyio
import pytest
from typer.testing import CliRunner

from attune.cli.profile import profile_app
from attune.core.bus import REPLY, UTTERANCE, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import DialogueConfig
from attune.core.messages import AgeEstimate, Utterance
from attune.core.scene import load_scene
from attune.dialogue.bridge import DialogueBridge
from attune.dialogue.policies import Policy, Preferences
from attune.dialogue.profiles import (
    ConsentError,
    DamagedProfilesError,
    NoProfileError,
    ProfileStore,
    UnreadableProfilesError,
)

WISHES = Preferences(announce="results", rate_steps=-2)
OLDER = AgeEstimate(probabilities=(0.02,) * 5 + (0.225,) * 4, band="older", confidence=0.9, source="model")


@pytest.fixture
def store(tmp_path: Path) -> ProfileStore:
    return ProfileStore(tmp_path / "data" / "profiles.sqlite3")


def test_nothing_is_kept_without_consent(store: ProfileStore) -> None:
    with pytest.raises(ConsentError, match="without consent"):
        store.keep("Ada", WISHES)
    assert store.all() == ()


def test_what_a_person_agreed_to_is_there_in_the_next_session(store: ProfileStore) -> None:
    store.consent("Ada")
    store.keep("Ada", WISHES, "older")
    found = ProfileStore(store.path).get("Ada")
    assert found is not None
    assert found.preferences == WISHES
    assert found.band == "older"
    assert found.consented_at.endswith("Z")


def test_age_and_preferences_are_kept_independently(store: ProfileStore) -> None:
    store.consent()
    store.keep(preferences=WISHES)
    store.keep(band="older")
    found = store.get()
    assert found is not None
    assert found.preferences == WISHES
    assert found.band == "older"


def test_consenting_again_loses_nothing(store: ProfileStore) -> None:
    store.consent("Ada")
    store.keep("Ada", WISHES)
    assert store.consent("Ada").preferences == WISHES


def test_an_erased_person_is_gone_from_the_file_itself(store: ProfileStore) -> None:
    store.consent("Zebedee")
    store.consent("Ada")
    assert b"Zebedee" in store.path.read_bytes()
    assert store.erase("Zebedee")
    assert b"Zebedee" not in store.path.read_bytes()
    assert store.people() == ("Ada",)
    assert not store.erase("Zebedee")


def test_export_holds_everything_of_one_person_or_of_all(store: ProfileStore) -> None:
    store.consent("Ada")
    store.consent("Bob")
    store.keep("Bob", WISHES)
    (bob,) = store.export("Bob")
    assert bob["preferences"]["rate_steps"] == -2
    assert [entry["person"] for entry in json.loads(json.dumps(store.export()))] == ["Ada", "Bob"]
    with pytest.raises(NoProfileError, match="Ada, Bob"):
        store.export("Cleo")


def test_only_the_owner_may_read_the_file(store: ProfileStore) -> None:
    store.consent("Ada")
    assert stat.S_IMODE(store.path.stat().st_mode) == 0o600


def test_reading_makes_no_file(store: ProfileStore) -> None:
    assert store.all() == ()
    assert not store.erase("Ada")
    assert not store.path.exists()


@pytest.mark.parametrize("content", [b"this is no database" * 100, None])
def test_a_damaged_file_is_kept_aside_and_named(store: ProfileStore, content: bytes | None) -> None:
    store.consent("Ada")
    for name in ("Bob", "Cleo"):
        store.consent(name * 2000)
    if content is None:
        whole = bytearray(store.path.read_bytes())
        whole[4100:] = os.urandom(len(whole) - 4100)
        content = bytes(whole)
    store.path.write_bytes(content)
    with pytest.raises(DamagedProfilesError) as caught:
        store.all()
    (aside,) = store.path.parent.glob("*damaged*")
    assert str(aside) in str(caught.value)
    assert aside.read_bytes() == content
    assert store.consent("Ada").person == "Ada"


def test_a_row_that_was_tampered_with_counts_as_damage(store: ProfileStore) -> None:
    store.consent("Ada")
    with sqlite3.connect(store.path) as database:
        database.execute("update profile set band = 'ancient'")
    database.close()
    with pytest.raises(DamagedProfilesError, match="band"):
        store.get("Ada")


def test_of_an_age_only_the_band_is_kept(store: ProfileStore) -> None:
    talk(["Remember me, please.", "bring me the milk"], store, OLDER)
    (kept,) = store.export()
    assert kept["age"] == "older"
    assert "0.225" not in json.dumps(kept)
    assert b"0.225" not in store.path.read_bytes()


def test_whole_estimates_that_an_earlier_version_kept_are_cut_down_to_their_band(store: ProfileStore) -> None:
    store.consent("Ada")
    with sqlite3.connect(store.path) as database:
        database.execute("alter table profile drop column band")
        database.execute("alter table profile add column age text not null default '{}'")
        database.execute("""update profile set age = '{"band": "older", "probabilities": [0.225]}'""")
        database.execute("insert into profile (person) values ('Bob')")
        database.execute("pragma user_version = 1")
    database.close()
    assert [profile.band for profile in store.all()] == ["older", "unknown"]
    store.keep("Ada", band="younger")
    assert [profile.band for profile in ProfileStore(store.path).all()] == ["younger", "unknown"]
    assert b"0.225" not in store.path.read_bytes()


def test_a_file_of_a_newer_version_is_left_alone(store: ProfileStore) -> None:
    store.consent("Ada")
    with sqlite3.connect(store.path) as database:
        database.execute("pragma user_version = 9")
    database.close()
    with pytest.raises(UnreadableProfilesError, match="version 9"):
        store.all()
    assert store.path.exists()


def test_a_process_killed_in_a_transaction_leaves_the_old_state(store: ProfileStore) -> None:
    store.consent("Ada")
    store.keep("Ada", WISHES)
    program = (
        "import os, sqlite3, sys\n"
        "d = sqlite3.connect(sys.argv[1]); d.execute('pragma cache_spill = 1'); d.execute('begin immediate')\n"
        "d.execute('update profile set preferences = ?', ('broken' * 100000,))\n"
        "os._exit(9)\n"
    )
    subprocess.run([sys.executable, "-c", program, str(store.path)], check=False)
    found = store.get("Ada")
    assert found is not None
    assert found.preferences == WISHES


def test_the_commands_list_show_export_and_erase(store: ProfileStore, tmp_path: Path) -> None:
    store.consent("Ada")
    store.keep("Ada", WISHES, "older")
    invoke = CliRunner().invoke
    place = ["--file", str(store.path)]
    assert "Ada" in invoke(profile_app, ["list", *place]).output
    shown = invoke(profile_app, ["show", "Ada", *place]).output
    assert "older" in shown
    assert "rate steps: -2" in shown
    out = tmp_path / "out.json"
    assert invoke(profile_app, ["export", "--out", str(out), *place]).exit_code == 0
    assert json.loads(out.read_text())[0]["person"] == "Ada"
    assert stat.S_IMODE(out.stat().st_mode) == 0o600
    assert invoke(profile_app, ["erase", "Ada", *place], input="n\n").exit_code == 1
    assert store.people() == ("Ada",)
    assert invoke(profile_app, ["erase", "Ada", "--yes", *place]).exit_code == 0
    assert store.people() == ()
    assert "Nothing is remembered" in invoke(profile_app, ["list", *place]).output


def test_erasing_an_unknown_person_names_who_is_known(store: ProfileStore) -> None:
    store.consent("Ada")
    result = CliRunner().invoke(profile_app, ["erase", "Bob", "--yes", "--file", str(store.path)])
    assert isinstance(result.exception, NoProfileError)
    assert "Ada" in str(result.exception)


def talk(texts: list[str], store: ProfileStore | None, age: AgeEstimate = AgeEstimate()) -> tuple[list[str], Policy]:
    """Hold a talk; returns what the robot said and how it speaks at the end."""
    clock, bus = VirtualClock(), Bus()
    said: list[str] = []

    async def main() -> Policy:
        bridge = DialogueBridge(bus, clock, load_scene(), DialogueConfig(), profiles=store)
        bus.on(REPLY, lambda reply: said.append(reply.text))
        async with anyio.create_task_group() as group:
            group.start_soon(bridge.run)
            await clock.sleep(0.1)
            for text in texts:
                now = clock.now()
                bus.publish(UTTERANCE, Utterance(time=now, text=text, start=now, end=now, age=age, typed=True))
                await clock.sleep(2)
            group.cancel_scope.cancel()
        return bridge.speaker.policy

    return said, run(main, clock)


def test_wishes_of_a_person_who_agreed_hold_in_the_next_talk(store: ProfileStore) -> None:
    said, policy = talk(
        ["You don't have to tell me everything.", "Remember me, please.", "Slower please."], store, OLDER
    )
    assert "remember" in said[1]
    _, next_policy = talk([], ProfileStore(store.path))
    assert next_policy == policy
    found = store.get()
    assert found is not None
    assert found.preferences.rate_steps == -1
    assert found.band == "older"


def test_without_consent_a_talk_leaves_nothing_behind(store: ProfileStore) -> None:
    talk(["Slower please.", "Tell me what you are doing."], store, OLDER)
    assert store.all() == ()
    assert not store.path.exists()


def test_what_is_remembered_is_told_to_who_asks(store: ProfileStore) -> None:
    said, _ = talk(["What do you know about me?", "remember me", "slower please", "talk less",
                    "I am seventy", "What do you remember about me?"], store)  # fmt: skip
    assert "nothing" in said[0]
    assert all(words in said[-1] for words in ("slower", "told little", "older"))


@pytest.mark.parametrize("words", ["Forget me.", "please forget everything about me", "Delete my data!"])
def test_forget_me_erases_the_profile(words: str, store: ProfileStore) -> None:
    said, _ = talk(["remember me", words, "louder please"], store)
    assert "forgotten" in said[1]
    assert store.all() == ()


@pytest.mark.parametrize(
    "words", ["Forget it.", "Forget the cup.", "Do you remember me?", "Remember the milk.", "don't forget the spoon"]
)
def test_other_things_to_remember_or_forget_touch_no_profile(words: str, store: ProfileStore) -> None:
    talk(["remember me", words], store)
    assert store.people() == ("me",)
    empty = ProfileStore(store.path.with_name("other.sqlite3"))
    talk([words], empty)
    assert empty.all() == ()


def test_where_nothing_can_be_kept_the_robot_says_so() -> None:
    said, _ = talk(["Remember me."], None)
    assert "nothing" in said[0]
