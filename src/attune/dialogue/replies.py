"""The robot's sentences, read from one file and varied."""

import random
import re
import string
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from attune.core.codec import describe
from attune.core.errors import AttuneError
from attune.dialogue.policies import Wording
from attune.dialogue.wording import be, sentence_case
from attune.dialogue.words import words

Situations = dict[str, dict[Wording, tuple[str, ...]]]
SLOTS = words(
    "objects object an_object old to to_now place where options nearest unknown thing done all wish "
    "doing question is kept "
    "Object Objects Options Place"
)


class ReplyFileError(AttuneError):
    """The file of replies is wrong."""

    def __init__(self, path: str, errors: list[str]) -> None:
        super().__init__(f"the replies in {path} are not valid: {'; '.join(errors)}", "Correct the named entries")


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    accept: Situations
    ask: Situations
    cannot: Situations
    talk: Situations
    doing: Situations
    announce: Situations
    done: Situations
    failed: Situations
    deferred: Situations

    @model_validator(mode="after")
    def _slots_are_known(self) -> "_File":
        for group, situations in self:
            for name, wordings in situations.items():
                for sentence in (text for texts in wordings.values() for text in texts):
                    unknown = {slot for _, slot, _, _ in string.Formatter().parse(sentence) if slot} - SLOTS
                    if unknown:
                        raise ValueError(f"{group}.{name}: unknown slot {sorted(unknown)[0]!r} in {sentence!r}")
        return self


class Phrasebook:
    """Chooses sentences; never the same twice in a row where there is a choice.

    Args:
        seed: Of the choice.
        path: A file in place of the one that comes with Attune.

    Raises:
        ReplyFileError: The file is missing or malformed.
    """

    def __init__(self, seed: int = 0, path: Path | None = None) -> None:
        self._file = _load(path)
        self._random = random.Random(seed)
        self._last: dict[tuple[str, str, Wording], str] = {}

    def has(self, group: str, situation: str, wording: Wording | None = None) -> bool:
        """Whether there is anything to say (in this very wording)."""
        wordings = getattr(self._file, group).get(situation)
        return bool(wordings) and (wording is None or wording in wordings)

    def say(self, group: str, situation: str, wording: Wording, **slots: str) -> str:
        """A sentence for the situation with its slots filled.

        Raises:
            KeyError: The file has no such situation, or the sentence needs a slot that was not given.
        """
        wordings: dict[Wording, tuple[str, ...]] = getattr(self._file, group)[situation]
        chosen = wording if wording in wordings else "normal" if "normal" in wordings else next(iter(wordings))
        key = (group, situation, chosen)
        texts = [text for text in wordings[chosen] if text != self._last.get(key)] or list(wordings[chosen])
        text = self._random.choice(texts)
        self._last[key] = text
        slots.setdefault("is", be(slots.get("object", "")))
        filled = text.format(**slots, **{name.capitalize(): sentence_case(value) for name, value in slots.items()})
        return sentence_case(re.sub(r"\s+([.,?!])", r"\1", " ".join(filled.split())))


def sentences(path: Path | None = None) -> Iterator[tuple[str, str, Wording, int]]:
    """Each group, situation and wording of the file, and how many sentences it has."""
    for group, situations in _load(path):
        for situation, wordings in situations.items():
            for wording, texts in wordings.items():
                yield group, situation, wording, len(texts)


@cache
def _load(path: Path | None) -> _File:
    name = str(path) if path else "replies.toml"
    try:
        text = (path or resources.files("attune.data") / "replies.toml").read_text(encoding="utf-8")
        return _File.model_validate(tomllib.loads(text))
    except OSError as error:
        raise ReplyFileError(name, [error.strerror or "cannot be read"]) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ReplyFileError(name, [str(error)]) from None
    except ValidationError as error:
        raise ReplyFileError(name, describe(error)) from None
