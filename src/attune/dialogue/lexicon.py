"""The lexicon: which words people use for what Attune knows, read from one validated file and the scene."""

import tomllib
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from attune.core.codec import describe
from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec
from attune.dialogue.words import words

Group = Literal["type", "color", "size", "comparative", "place", "unknown"]


class LexiconError(AttuneError):
    """The lexicon file is wrong."""

    def __init__(self, path: str, errors: list[str]) -> None:
        super().__init__(f"the lexicon {path} is not valid: {'; '.join(errors)}", "Correct the named entries")


@dataclass(frozen=True, slots=True)
class Entry:
    """What a phrase means: a value of a group.

    Attributes:
        plural: The phrase names more than one.
    """

    group: Group
    value: str
    plural: bool = False


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Words(_Strict):
    mass: frozenset[str]
    adjectives: frozenset[str]
    robot: frozenset[str]
    people: frozenset[str]
    names: frozenset[str]
    not_objects: tuple[str, ...]


class Verbs(_Strict):
    """What people tell the robot to do with things; `bringing` and `brought` are forms of `fetch`, and so on."""

    fetch: tuple[str, ...]
    put: tuple[str, ...]
    bringing: tuple[str, ...]
    putting: tuple[str, ...]
    brought: tuple[str, ...]
    left: tuple[str, ...]
    swap: tuple[str, ...]
    swapping: tuple[str, ...]
    drop: tuple[str, ...]


class _File(_Strict):
    """The lexicon file: each group maps a canonical value to the phrases that people use for it."""

    types: dict[str, tuple[str, ...]]
    colors: dict[str, tuple[str, ...]]
    sizes: dict[Literal["small", "normal", "big"], tuple[str, ...]]
    comparatives: dict[Literal["small", "big"], tuple[str, ...]]
    places: dict[str, tuple[str, ...]]
    plurals: dict[str, str]
    numbers: dict[str, int]
    homophones: dict[str, str]
    words: _Words
    verbs: Verbs

    @field_validator("types", "colors", "sizes", "comparatives", "places")
    @classmethod
    def _phrases_are_plain_words(cls, group: Mapping[str, tuple[str, ...]]) -> Mapping[str, tuple[str, ...]]:
        seen: dict[str, str] = {}
        for value, phrases in group.items():
            for phrase in phrases:
                if not phrase or phrase != " ".join(phrase.lower().split()):
                    raise ValueError(f"{value}: {phrase!r} must be lower-case words with single spaces")
                if phrase in seen:
                    raise ValueError(f"{phrase!r} stands under both {seen[phrase]} and {value}")
                seen[phrase] = value
        return group


class Lexicon:
    """Phrases and what they mean.

    Args:
        file: The validated content of a lexicon file.
    """

    def __init__(self, file: _File) -> None:
        self._file = file
        self.verbs = file.verbs
        self.mass = file.words.mass
        self.adjectives = file.words.adjectives
        self.robot = file.words.robot
        self.people = file.words.people
        self.homophones: Mapping[str, str] = file.homophones
        self.names = file.words.names | _first_names()
        self.others = self.people | self.names
        """Whoever is called by one of these is not the robot."""
        self.numbers: Mapping[str, int] = file.numbers
        self.phrases: dict[tuple[str, ...], Entry] = {}
        groups: tuple[tuple[Group, Mapping[str, tuple[str, ...]]], ...] = (
            ("type", file.types), ("color", file.colors), ("size", {str(k): v for k, v in file.sizes.items()}),
            ("comparative", {str(k): v for k, v in file.comparatives.items()}), ("place", file.places),
            ("unknown", {phrase: (phrase,) for phrase in file.words.not_objects}),
        )  # fmt: skip
        for group, values in groups:
            for value, phrases in values.items():
                for phrase in phrases:
                    self._add(phrase, group, value)
        self.longest = max(len(key) for key in self.phrases)
        self.actions: Mapping[str, str] = {
            verb: kind for kind, verbs in reversed(file.verbs.model_dump().items()) for verb in verbs
        }
        self._parts = {word for phrase in self.phrases for word in phrase}
        self._parts |= {word for kind in file.verbs.model_dump().values() for phrase in kind for word in phrase.split()}

    def extended(self, objects: Iterable[ObjectSpec], places: Iterable[str] = ()) -> "Lexicon":
        """A lexicon that also knows the types, colours and places of these objects.

        A word that is already known keeps its meaning.
        """
        wider = copy(self)
        wider.phrases = dict(self.phrases)
        for spec in objects:
            wider._learn(spec.type, "type")
            wider._learn(spec.color, "color")
            wider._learn(spec.location, "place")
        for place in places:
            wider._learn(place, "place")
        wider.longest = max(len(key) for key in wider.phrases)
        return wider

    def knows(self, word: str) -> bool:
        """Whether a word is part of any phrase."""
        return word in self._parts or word in self.adjectives or word in self.numbers

    def values(self, group: Group) -> tuple[str, ...]:
        """The canonical values of a group."""
        return tuple(dict.fromkeys(entry.value for entry in self.phrases.values() if entry.group == group))

    def sayings(self, group: Group, value: str, *, plural: bool = False) -> tuple[str, ...]:
        """The phrases for a value, as people say them."""
        wanted = Entry(group, value, plural)
        return tuple(" ".join(words) for words, entry in self.phrases.items() if entry == wanted)

    def _learn(self, value: str, group: Group) -> None:
        phrase = " ".join(value.lower().replace("_", " ").replace("-", " ").split())
        known = self.phrases.get(tuple(phrase.split()))
        if phrase and (known is None or known.group == "unknown"):
            self._add(phrase, group, value)

    def _add(self, phrase: str, group: Group, value: str) -> None:
        words = tuple(phrase.split())
        self.phrases[words] = Entry(group, value)
        if group in {"type", "place"} and (plural := self._plural(words)):
            self.phrases.setdefault(plural, Entry(group, value, plural=True))

    def _plural(self, words: tuple[str, ...]) -> tuple[str, ...]:
        # In "carton of milk" the first noun takes the plural, in "coffee cup" the last.
        head = words.index("of") - 1 if "of" in words else len(words) - 1
        noun = words[head]
        if noun.endswith("s") and noun not in self._file.plurals and not noun.endswith("ss"):
            return ()  # "corn flakes" is one already
        return (*words[:head], self._file.plurals.get(noun, regular_plural(noun)), *words[head + 1 :])


def regular_plural(noun: str) -> str:
    """`cup` -> `cups`, `dish` -> `dishes`, `berry` -> `berries`."""
    if noun.endswith(("s", "x", "z", "ch", "sh")):
        return noun + "es"
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return noun[:-1] + "ies"
    return noun + "s"


@cache
def _first_names() -> frozenset[str]:
    text = (resources.files("attune.data") / "first_names.txt").read_text(encoding="utf-8")
    return words(" ".join(line for line in text.splitlines() if not line.startswith("#")))


@cache
def load_lexicon(path: Path | None = None) -> Lexicon:
    """Read a lexicon file; without a path, the one that comes with Attune.

    Raises:
        LexiconError: The file is missing, not TOML, or an entry is wrong; the message names it.
    """
    name = str(path) if path else "lexicon.toml"
    try:
        text = (path or resources.files("attune.data") / "lexicon.toml").read_text(encoding="utf-8")
        return Lexicon(_File.model_validate(tomllib.loads(text)))
    except OSError as error:
        raise LexiconError(name, [error.strerror or "cannot be read"]) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LexiconError(name, [str(error)]) from None
    except ValidationError as error:
        raise LexiconError(name, describe(error)) from None
