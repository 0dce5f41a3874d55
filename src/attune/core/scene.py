"""The scene: what the kitchen is made of, read from one validated TOML file.

It is the map the robot is given, the vocabulary the speech recogniser and the interpreter start from, and what the
simulation is built of. Lengths in metres, angles in radians, map frame (x, y on the floor, z up).
"""

import tomllib
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from attune.core.codec import describe
from attune.core.errors import AttuneError


class SceneError(AttuneError):
    """The scene file is wrong."""

    def __init__(self, path: str, errors: list[str]) -> None:
        super().__init__(f"the scene {path} is not valid: {'; '.join(errors)}", "Correct the named entries")


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """The words a scene brings: sorted, without duplicates."""

    types: tuple[str, ...]
    colors: tuple[str, ...]
    sizes: tuple[str, ...]
    places: tuple[str, ...]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SceneObject(_Strict):
    """An object of the kitchen."""

    name: str
    type: str
    color: str
    size: Literal["small", "normal", "big"] = "normal"
    at: str
    """Name of the furniture or compartment it starts on or in."""


class Furniture(_Strict):
    """A piece of furniture."""

    name: str
    place: str
    """The kind of place people call it: countertop, table, cabinet, dishwasher, drawer, fridge, shelf."""


class Scene(_Strict):
    """A kitchen."""

    furniture: tuple[Furniture, ...] = ()
    objects: tuple[SceneObject, ...] = ()

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """The words this scene brings."""
        return Vocabulary(
            types=tuple(sorted({o.type for o in self.objects})),
            colors=tuple(sorted({o.color for o in self.objects})),
            sizes=tuple(sorted({o.size for o in self.objects})),
            places=tuple(sorted({f.place for f in self.furniture})),
        )


def load_scene(path: Path | None = None) -> Scene:
    """Read a scene file; without a path, the kitchen that comes with Attune.

    Raises:
        SceneError: The file is missing, not TOML, or an entry is wrong; the message names it.
    """
    name = str(path) if path else "kitchen.toml"
    try:
        text = (path or resources.files("attune.data") / "kitchen.toml").read_text(encoding="utf-8")
        return Scene.model_validate(tomllib.loads(text))
    except OSError as error:
        raise SceneError(name, [error.strerror or "cannot be read"]) from None
    except tomllib.TOMLDecodeError as error:
        raise SceneError(name, [str(error)]) from None
    except ValidationError as error:
        raise SceneError(name, describe(error)) from None
