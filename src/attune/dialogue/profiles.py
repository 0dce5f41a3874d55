"""What is remembered about people: their wishes and their age band, only with their consent.

One SQLite file, readable by its owner alone. Nothing of what a person said is kept, only how the robot shall behave.
"""

import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs
from pydantic import BaseModel, ConfigDict, ValidationError

from attune.core.codec import describe, to_data
from attune.core.errors import AttuneError
from attune.core.messages import Band
from attune.dialogue.policies import Preferences

SELF = "me"
"""The person who is meant where nobody is named."""
VERSION = 2
_TABLE = """
create table profile (
    person text primary key not null check (person <> ''),
    consented_at text not null default (strftime('%Y-%m-%dT%H:%M:%SZ', 'now')),
    changed_at text not null default (strftime('%Y-%m-%dT%H:%M:%SZ', 'now')),
    preferences text not null default '{}',
    band text not null default 'unknown'
) strict
"""
_FROM_1 = (
    "alter table profile add column band text not null default 'unknown'",
    "update profile set band = coalesce(json_extract(age, '$.band'), 'unknown')",
    "alter table profile drop column age",
)
"""The first version kept whole age estimates."""


class ConsentError(AttuneError):
    """Something should be remembered about a person who did not agree to it."""

    def __init__(self, person: str) -> None:
        super().__init__(
            f"nothing is remembered about {person!r} without consent", 'They agree by saying "remember me"'
        )


class NoProfileError(AttuneError):
    """Nothing is remembered about this person."""

    def __init__(self, person: str, known: tuple[str, ...]) -> None:
        people = f"Profiles exist of: {', '.join(known)}" if known else "There are no profiles at all"
        super().__init__(f"nothing is remembered about {person!r}", people)


class DamagedProfilesError(AttuneError):
    """The file cannot be read; it was moved aside, not deleted."""

    def __init__(self, path: Path, aside: Path, why: str) -> None:
        super().__init__(
            f"the profiles in {path} are damaged ({why})",
            f"The file is kept as {aside}; put a copy in its place, or go on with no profiles",
        )


class UnreadableProfilesError(AttuneError):
    """The file is of another version, or the system refuses access."""

    def __init__(self, path: Path, why: str, remedy: str) -> None:
        super().__init__(f"the profiles in {path} cannot be used: {why}", remedy)


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """What is remembered about one person.

    Attributes:
        person: Their name, or `me`.
        preferences: What they have wished for.
        band: The age band that earlier talks came to; what the person stated is among the preferences.
        consented_at: When they agreed, UTC.
        changed_at: When something changed last, UTC.
    """

    person: str
    preferences: Preferences = Preferences()
    band: Band = "unknown"
    consented_at: str = ""
    changed_at: str = ""


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    preferences: Preferences
    band: Band


class ProfileStore:
    """The profiles of all people.

    Each call is one transaction of a few milliseconds: it happens wholly or not at all, whatever fails meanwhile.

    Args:
        path: The file, made when something is first kept; None takes the user's data directory.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path or Path(platformdirs.user_data_dir("attune", appauthor=False)) / "profiles.sqlite3"

    def people(self) -> tuple[str, ...]:
        """Names of everybody about whom something is kept, sorted."""
        return tuple(profile.person for profile in self.all())

    def all(self) -> tuple[Profile, ...]:
        """All profiles, by name.

        Raises:
            DamagedProfilesError: The file is damaged; it was moved aside.
            UnreadableProfilesError: The file is of a newer version, or may not be read.
        """
        if not self.path.exists():
            return ()
        with self._open() as database:
            return tuple(self._profile(row) for row in database.execute("select * from profile order by person"))

    def get(self, person: str = SELF) -> Profile | None:
        """The profile of a person, or None without their consent."""
        return next((profile for profile in self.all() if profile.person == person), None)

    def consent(self, person: str = SELF) -> Profile:
        """Note that a person agreed to be remembered. Agreeing again changes nothing."""
        with self._open() as database:
            database.execute("insert into profile (person) values (?) on conflict do nothing", (person,))
        return self._existing(person)

    def keep(
        self,
        person: str = SELF,
        preferences: Preferences | None = None,
        band: Band | None = None,
    ) -> Profile:
        """Remember wishes (in place of the earlier ones), the age band, or both.

        Raises:
            ConsentError: The person did not agree.
        """
        if self.get(person) is None:
            raise ConsentError(person)
        wishes = None if preferences is None else json.dumps(to_data(preferences))
        with self._open() as database:
            database.execute(
                "update profile set preferences = coalesce(?, preferences), band = coalesce(?, band), "
                "changed_at = strftime('%Y-%m-%dT%H:%M:%SZ', 'now') where person = ?",
                (wishes, band, person),
            )
        return self._existing(person)

    def export(self, person: str | None = None) -> list[dict[str, Any]]:
        """Everything that is kept, of one person or of everybody, as JSON can hold it.

        Raises:
            NoProfileError: Nothing is kept about the person.
        """
        profiles = self.all() if person is None else (self._existing(person),)
        return [
            {
                "person": profile.person,
                "consented_at": profile.consented_at,
                "changed_at": profile.changed_at,
                "preferences": to_data(profile.preferences),
                "age": profile.band,
            }
            for profile in profiles
        ]

    def erase(self, person: str = SELF) -> bool:
        """Forget a person; the bytes on disk are overwritten. Returns whether there was anything to forget."""
        if not self.path.exists():
            return False
        with self._open() as database:
            return database.execute("delete from profile where person = ?", (person,)).rowcount > 0

    def _existing(self, person: str) -> Profile:
        profile = self.get(person)
        if profile is None:
            raise NoProfileError(person, self.people())
        return profile

    def _profile(self, row: sqlite3.Row) -> Profile:
        try:
            kept = _Row.model_validate_json(
                f'{{"preferences": {row["preferences"]}, "band": {json.dumps(row["band"])}}}', strict=False
            )
        except ValidationError as error:
            raise self._damaged(describe(error)[0]) from None
        return Profile(
            person=row["person"],
            preferences=kept.preferences,
            band=kept.band,
            consented_at=row["consented_at"],
            changed_at=row["changed_at"],
        )

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            # Made before SQLite does, so that nobody else can read it even for a moment.
            os.close(os.open(self.path, os.O_CREAT | os.O_RDWR, 0o600))
            self.path.chmod(0o600)
        except OSError as error:
            raise UnreadableProfilesError(self.path, error.strerror or str(error), "Check who owns the file") from None
        try:
            with closing(sqlite3.connect(self.path, timeout=5.0)) as database, database:
                database.row_factory = sqlite3.Row
                database.execute("pragma secure_delete = on")
                self._prepare(database)
                yield database
        except sqlite3.OperationalError as error:
            raise UnreadableProfilesError(self.path, str(error), "Close other programs that use it") from None
        except sqlite3.DatabaseError as error:
            raise self._damaged(str(error)) from None

    def _prepare(self, database: sqlite3.Connection) -> None:
        (version,) = database.execute("pragma user_version").fetchone()
        if version > VERSION:
            raise UnreadableProfilesError(
                self.path, f"it is of version {version}, this program knows {VERSION}", "Update Attune"
            )
        if version == 0:
            database.execute(_TABLE)
        if version == 1:
            for change in _FROM_1:
                database.execute(change)
        if version < VERSION:
            database.execute(f"pragma user_version = {VERSION}")
        (state,) = database.execute("pragma quick_check(1)").fetchone()
        if state != "ok":
            raise self._damaged(str(state))

    def _damaged(self, why: str) -> DamagedProfilesError:
        numbers = range(1, 1000)
        names = (self.path.with_suffix(f".damaged-{number}{self.path.suffix}") for number in numbers)
        aside = next(name for name in names if not name.exists())
        self.path.rename(aside)
        return DamagedProfilesError(self.path, aside, why)
