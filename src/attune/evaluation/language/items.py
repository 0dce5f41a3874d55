"""One item of the language benchmark, and one answer to it, in the file format of `attune understand`."""

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, field_validator

from attune.core.errors import AttuneError

CommandName = Literal["bring_me", "setting_breakfast", "replace_object", "change_location", "stop", "other"]
Part = Literal["paper", "hard", "fresh"]
"""The paper's recipe; harder sentences; and more of those, whose errors nobody has looked at while working on rules."""


class BenchmarkError(AttuneError):
    """A file of the benchmark is wrong."""

    def __init__(self, name: str, errors: list[str]) -> None:
        super().__init__(f"the benchmark {name} is not valid: {'; '.join(errors)}", "Correct the named entries")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ObjectSlots(BaseModel):
    """A described object; "" means not given."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    type: str = ""
    color: str = ""
    size: str = ""
    location: str = ""

    def __str__(self) -> str:
        words = " ".join(word for word in (self.size, self.color, self.type or "something") if word)
        return f"{words} from {self.location}" if self.location else words


class Meaning(BaseModel):
    """What an utterance means: the part of a line of `attune understand` that is judged."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    command: CommandName
    add: tuple[ObjectSlots, ...] = ()
    remove: tuple[ObjectSlots, ...] = ()
    destination: str = ""

    @field_validator("add", "remove", mode="before")
    @classmethod
    def _as_list(cls, value: object) -> object:
        """A single object counts as a list of one, null as none."""
        if value is None:
            return ()
        return (value,) if isinstance(value, dict | ObjectSlots) else value

    def __str__(self) -> str:
        add = f" {', '.join(map(str, self.add))}" if self.add else ""
        remove = f" instead of {', '.join(map(str, self.remove))}" if self.remove else ""
        return f"{self.command}{add}{remove}{f' to {self.destination}' if self.destination else ''}"


@dataclass(frozen=True, slots=True)
class Item:
    """Something said in a situation, and what it means.

    Attributes:
        group: What makes it what it is: the paper's command, or the difficulty of the harder part.
        context: The situation, as `attune understand` reads it.
    """

    id: str
    part: Part
    group: str
    utterance: str
    expected: Meaning
    context: "MappingProxyType[str, Any]" = field(default_factory=lambda: MappingProxyType({}))
