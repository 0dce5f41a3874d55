import json
import os
import sqlite3
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from attune.cli.profile import profile_app
from attune.core.messages import AgeEstimate
from attune.dialogue.policies import Preferences
from attune.dialogue.profiles import (
    ConsentError,
    DamagedProfilesError,
    NoProfileError,
    ProfileStore,
    UnreadableProfilesError,
)

WISHES = Preferences(announce="results", rate_steps=-2)
OLDER = AgeEstimate(band="older", confidence=0.9, source="profile")


@pytest.fixture
def store(tmp_path: Path) -> ProfileStore:
    return ProfileStore(tmp_path / "data" / "profiles.sqlite3")


def test_nothing_is_kept_without_consent(store: ProfileStore) -> None:
    with pytest.raises(ConsentError, match="without consent"):
        store.keep("Ada", WISHES)
    assert store.all() == ()


def test_what_a_person_agreed_to_is_there_in_the_next_session(store: ProfileStore) -> None:
    store.consent("Ada")
    store.keep("Ada", WISHES, OLDER)
    found = ProfileStore(store.path).get("Ada")
    assert found is not None
    assert found.preferences == WISHES
    assert found.age == OLDER
    assert found.consented_at.endswith("Z")


def test_age_and_preferences_are_kept_independently(store: ProfileStore) -> None:
    store.consent()
    store.keep(preferences=WISHES)
    store.keep(age=OLDER)
    found = store.get()
    assert found is not None
    assert found.preferences == WISHES
    assert found.age.band == "older"


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
        database.execute('update profile set age = \'{"band": "ancient"}\'')
    database.close()
    with pytest.raises(DamagedProfilesError, match="band"):
        store.get("Ada")


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
    store.keep("Ada", WISHES, OLDER)
    run = CliRunner().invoke
    place = ["--file", str(store.path)]
    assert "Ada" in run(profile_app, ["list", *place]).output
    shown = run(profile_app, ["show", "Ada", *place]).output
    assert "older" in shown
    assert "rate steps: -2" in shown
    out = tmp_path / "out.json"
    assert run(profile_app, ["export", "--out", str(out), *place]).exit_code == 0
    assert json.loads(out.read_text())[0]["person"] == "Ada"
    assert stat.S_IMODE(out.stat().st_mode) == 0o600
    assert run(profile_app, ["erase", "Ada", *place], input="n\n").exit_code == 1
    assert store.people() == ("Ada",)
    assert run(profile_app, ["erase", "Ada", "--yes", *place]).exit_code == 0
    assert store.people() == ()
    assert "Nothing is remembered" in run(profile_app, ["list", *place]).output


def test_erasing_an_unknown_person_names_who_is_known(store: ProfileStore) -> None:
    store.consent("Ada")
    result = CliRunner().invoke(profile_app, ["erase", "Bob", "--yes", "--file", str(store.path)])
    assert isinstance(result.exception, NoProfileError)
    assert "Ada" in str(result.exception)
