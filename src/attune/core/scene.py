"""The scene: what the kitchen is made of, read from one validated TOML file.

It is the map the robot is given, the vocabulary the speech recogniser and the interpreter start from, and what the
simulation is built of. Lengths in metres, angles in radians, map frame (x, y on the floor from one corner of the room,
z up).

    room = [5.8, 4.4]                # the floor reaches from 0, 0 to here
    robot_start = [2.0, 1.0, 0.0]    # x, y, yaw
    user = [5.2, 1.6]                # where the person is

    [[furniture]]                    # kinds and their keys: see attune.core.furniture
    kind = "table"
    name = "table"
    place = "table"                  # the kind of place people call it
    position = [4.2, 1.6]
    size = [0.8, 1.4, 0.72]

    [[objects]]
    name = "white_cup"
    type = "cup"                     # one of data/objects.toml, or of [types.NAME] here
    color = "white"
    size = "normal"
    at = "table"                     # name of a surface: furniture, drawer or compartment
    position = [0.1, -0.2]           # on that surface, from its middle; without it a free spot is taken
    yaw = 0.0
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from attune.core import furniture as pieces
from attune.core.errors import AttuneError
from attune.core.furniture import Container, Furniture, Surface
from attune.core.layout import lay_out, layout_problems
from attune.core.shapes import ObjectSize, ObjectType, Shape, standard_types

__all__ = ["Container", "Scene", "SceneError", "SceneObject", "StartPose", "Surface", "Vocabulary", "load_scene"]


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


class StartPose(NamedTuple):
    """Where an object is when the session begins: its bottom centre [m] and its turn [rad] in the map frame."""

    x: float
    y: float
    z: float
    yaw: float


_Named = TypeVar("_Named", Surface, Container, "SceneObject")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class SceneObject(_Strict):
    """An object of the kitchen."""

    name: str = Field(min_length=1)
    type: str
    color: str
    size: ObjectSize = "normal"
    at: str
    """Name of the surface it starts on: a piece of furniture, a drawer or another compartment."""
    position: tuple[float, float] | None = None
    """On that surface, from its middle, along its own axes [m]; None: wherever there is room."""
    yaw: float = 0.0
    """Turn relative to the surface [rad]."""


class Scene(_Strict):
    """A kitchen."""

    room: tuple[PositiveFloat, PositiveFloat] = (6.0, 6.0)
    """The floor reaches from x, y = 0, 0 to here [m]."""
    robot_start: tuple[float, float, float] = (1.0, 1.0, 0.0)
    """Where the robot stands at first: x, y [m], yaw [rad]."""
    user: tuple[float, float] = (5.0, 1.0)
    """Where the person is: x, y [m]."""
    furniture: tuple[Furniture, ...] = ()
    objects: tuple[SceneObject, ...] = ()
    types: dict[str, ObjectType] = {}
    """Types of objects beyond the standard ones, or in place of them."""

    @model_validator(mode="after")
    def _is_possible(self) -> "Scene":
        problems = layout_problems(self)
        if problems:
            raise PydanticCustomError("layout", "{problems}", {"problems": "; ".join(problems)})
        return self

    @cached_property
    def all_types(self) -> Mapping[str, ObjectType]:
        """The types of objects that can be used, by name."""
        return MappingProxyType({**standard_types(), **self.types})

    @cached_property
    def surfaces(self) -> tuple[Surface, ...]:
        """Everything that objects can stand on."""
        return tuple(surface for piece in self.furniture for surface in piece.surfaces)

    @cached_property
    def containers(self) -> tuple[Container, ...]:
        """Everything with a door or drawer."""
        return tuple(container for piece in self.furniture for container in piece.containers)

    @cached_property
    def starts(self) -> Mapping[str, StartPose]:
        """Where each object is at first, by name."""
        return MappingProxyType({name: StartPose(*pose) for name, pose in lay_out(self).items()})

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """The words this scene brings."""
        return Vocabulary(
            types=tuple(sorted({o.type for o in self.objects})),
            colors=tuple(sorted({o.color for o in self.objects})),
            sizes=tuple(sorted({o.size for o in self.objects})),
            places=tuple(sorted({surface.place for surface in self.surfaces})),
        )

    def surface(self, name: str) -> Surface:
        """The surface with this name.

        Raises:
            KeyError: There is none.
        """
        return _named(self.surfaces, name)

    def surfaces_at(self, place: str) -> tuple[Surface, ...]:
        """The surfaces that people call by this kind of place, in the file's order."""
        return tuple(surface for surface in self.surfaces if surface.place == place)

    def container(self, name: str) -> Container:
        """The container with this name.

        Raises:
            KeyError: There is none.
        """
        return _named(self.containers, name)

    def object(self, name: str) -> SceneObject:
        """The object with this name.

        Raises:
            KeyError: There is none.
        """
        return _named(self.objects, name)

    def shape(self, name: str) -> Shape:
        """The shape of the object with this name.

        Raises:
            KeyError: There is none.
        """
        thing = self.object(name)
        return self.all_types[thing.type].shape(thing.size)


def _named(things: tuple[_Named, ...], name: str) -> _Named:
    found = next((thing for thing in things if thing.name == name), None)
    if found is None:
        raise KeyError(f"{name!r}; known: {', '.join(thing.name for thing in things)}")
    return found


def load_scene(path: Path | None = None) -> Scene:
    """Read a scene file; without a path, the kitchen that comes with Attune.

    Raises:
        SceneError: The file is missing, not TOML, or an entry is wrong; the message names it.
    """
    name = str(path) if path else "kitchen.toml"
    data: dict[str, Any] = {}
    try:
        text = (path or resources.files("attune.data") / "kitchen.toml").read_text(encoding="utf-8")
        data = tomllib.loads(text)
        return Scene.model_validate(data)
    except OSError as error:
        raise SceneError(name, [error.strerror or "cannot be read"]) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneError(name, [f"not TOML: {error}"]) from None
    except ValidationError as error:
        raise SceneError(name, [_explain(dict(item), data) for item in error.errors()]) from None


def _explain(item: dict[str, Any], data: dict[str, Any]) -> str:
    """One wrong entry in words: which entry, which key, what is wrong, the value, and what is allowed."""
    if item["type"] == "layout":
        return str(item["msg"])
    location = list(item["loc"])
    known: tuple[str, ...] = tuple(Scene.model_fields)
    subject = ""
    if len(location) >= 2 and location[0] in ("furniture", "objects") and isinstance(location[1], int):
        entry = data[location[0]][location[1]]
        named = entry.get("name") if isinstance(entry, dict) else None
        kind = "object" if location[0] == "objects" else "furniture"
        subject = f"{kind} {named!r}: " if named else f"{kind} number {location[1] + 1}: "
        fields = SceneObject.model_fields if kind == "object" else {}
        if kind == "furniture" and len(location) > 2:
            model = next(piece for piece in pieces.KINDS if piece.__name__.lower() == location[2])
            fields = model.model_fields
            del location[2]
        known = tuple(fields)
        del location[:2]
        if len(location) > 1 and location[0] in ("drawers", "sink"):
            known = tuple((pieces.Drawer if location[0] == "drawers" else pieces.Sink).model_fields)
    elif location and location[0] == "types":
        known = tuple(ObjectType.model_fields) if len(location) == 3 else ("extent", "mass")
    key = ".".join(str(part) for part in location)
    if item["type"] == "extra_forbidden":
        return f"{subject}unknown key {key!r} (value {item['input']!r:.60}); allowed: {', '.join(known)}"
    if item["type"] == "union_tag_not_found":
        kinds = ", ".join(piece.__name__.lower() for piece in pieces.KINDS)
        return f"{subject}key 'kind' is missing; allowed: {kinds}"
    if item["type"] == "missing":
        return f"{subject}key {key!r} is missing"
    message = str(item["msg"]).removeprefix("Value error, ")
    got = "" if isinstance(item["input"], dict) else f" (got {item['input']!r:.60})"
    return f"{subject}{key + ': ' if key else ''}{message}{got}"
