"""How much the robot tells, and how: it starts from the age band and then follows the person's wishes."""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from attune.core.codec import describe
from attune.core.errors import AttuneError
from attune.core.messages import Band
from attune.dialogue.interpreter import StyleWish

Announce = Literal["everything", "steps", "results"]
Wording = Literal["full", "normal", "short"]


class PolicyError(AttuneError):
    """The file of policies is wrong."""

    def __init__(self, path: str, errors: list[str]) -> None:
        super().__init__(f"the policies in {path} are not valid: {'; '.join(errors)}", "Correct the named entries")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Policy(_Strict):
    """How the robot talks to one person now. The keys are explained in `data/policies.toml`."""

    announce: Announce
    wording: Wording
    restate: bool
    rate: int = Field(ge=60, le=400)
    loudness: float = Field(ge=0, le=1)
    destination: str = ""
    warn_before_movement: float = Field(ge=0, le=15)


class _Wishes(_Strict):
    rate_factor: float = Field(gt=0, lt=1)
    rate_least: int
    rate_most: int
    loudness_step: float = Field(gt=0, lt=1)
    loudness_least: float
    loudness_most: float


class Policies(_Strict):
    """The start of each age band, and what wishes change."""

    older: Policy
    younger: Policy
    unknown: Policy
    wishes: _Wishes

    def start(self, band: Band) -> Policy:
        """Where the talk with somebody of this age band begins."""
        return {"older": self.older, "younger": self.younger, "unknown": self.unknown}[band]


@cache
def load_policies(path: Path | None = None) -> Policies:
    """Read the policies; without a path, those that come with Attune.

    Raises:
        PolicyError: The file is missing or malformed; the message names the entry.
    """
    name = str(path) if path else "policies.toml"
    try:
        text = (path or resources.files("attune.data") / "policies.toml").read_text(encoding="utf-8")
        return Policies.model_validate(tomllib.loads(text))
    except OSError as error:
        raise PolicyError(name, [error.strerror or "cannot be read"]) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise PolicyError(name, [str(error)]) from None
    except ValidationError as error:
        raise PolicyError(name, describe(error)) from None


@dataclass(frozen=True, slots=True)
class Preferences:
    """What a person has wished for. It stays, whatever the age estimate says later.

    Attributes:
        announce: How much to tell; None follows the age band.
        rate_steps: How many times "faster" (positive) or "slower" (negative) was wished.
        loudness_steps: The same for "louder" and "quieter".
        band: The age band that the person stated; "unknown" when none was.
    """

    announce: Announce | None = None
    rate_steps: int = 0
    loudness_steps: int = 0
    band: Band = "unknown"

    def wish(self, wish: StyleWish) -> "Preferences":
        """With one more wish."""
        match wish:
            case "less" | "more":
                return replace(self, announce="results" if wish == "less" else "everything")
            case "slower" | "faster":
                return replace(self, rate_steps=self.rate_steps + (1 if wish == "faster" else -1))
            case "louder" | "quieter":
                return replace(self, loudness_steps=self.loudness_steps + (1 if wish == "louder" else -1))
            case "normal":
                return Preferences(band=self.band)
            case _:
                return self

    def applied(self, policies: Policies, estimated: Band) -> Policy:
        """The policy for this person, whose age was estimated as `estimated`."""
        start = policies.start(self.band if self.band != "unknown" else estimated)
        wishes = policies.wishes
        rate = round(start.rate / wishes.rate_factor**self.rate_steps)
        loudness = start.loudness + self.loudness_steps * wishes.loudness_step
        wording: Wording = start.wording
        if self.announce == "results":
            wording = "short" if start.wording == "short" else "normal"
        return start.model_copy(
            update={
                "announce": self.announce or start.announce,
                "wording": wording,
                "rate": min(max(rate, wishes.rate_least), wishes.rate_most),
                "loudness": round(min(max(loudness, wishes.loudness_least), wishes.loudness_most), 2),
            }
        )
