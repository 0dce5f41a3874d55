"""Types of objects: their form, their dimensions in each size, and how a two-finger gripper can hold them.

Read from `data/objects.toml`; a scene file may add types or replace them. An object's own frame has its origin at the
centre of its footprint, at the bottom; x and y are the sides of its bounding box, z is up. Lengths in metres.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from math import inf
from types import MappingProxyType
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, TypeAdapter, field_validator, model_validator

Form = Literal["cylinder", "box", "shell", "utensil"]
"""`shell` is open at the top and has a rim (bowl, plate); `utensil` is flat with a narrow handle along x."""
GraspKind = Literal["side", "top", "rim"]
"""`side`: the hand comes from the side; `top`: from above over the middle; `rim`: from above, one finger inside."""
ObjectSize = Literal["small", "normal", "big"]
Rgb = tuple[float, float, float]

WIDEST_GRIP = 0.08
"""Thickest that the fingers can close on [m]."""

COLORS: Mapping[str, Rgb] = MappingProxyType(
    {
        "red": (0.80, 0.12, 0.10),
        "green": (0.15, 0.60, 0.22),
        "blue": (0.13, 0.33, 0.78),
        "white": (0.93, 0.93, 0.90),
        "yellow": (0.95, 0.78, 0.15),
        "black": (0.10, 0.10, 0.11),
        "orange": (0.95, 0.50, 0.12),
        "brown": (0.45, 0.28, 0.15),
        "grey": (0.55, 0.56, 0.58),
        "pink": (0.92, 0.55, 0.65),
        "purple": (0.45, 0.20, 0.60),
        "silver": (0.75, 0.77, 0.79),
    }
)
"""The colours an object can have, as they look."""

_GRASPS_OF: Mapping[Form, tuple[GraspKind, ...]] = MappingProxyType(
    {"cylinder": ("side", "top"), "box": ("side", "top"), "shell": ("rim",), "utensil": ("top",)}
)


@dataclass(frozen=True, slots=True)
class Shape:
    """The shape of one object.

    Attributes:
        extent: Size of the bounding box along the object's own axes [m].
        mass: [kg].
        wall: Thickness of a shell's wall [m].
        handle: Width of a utensil's handle [m].
        grasps: How it may be held, the best first.
    """

    form: Form
    extent: tuple[float, float, float]
    mass: float
    wall: float
    handle: float
    grasps: tuple[GraspKind, ...]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Dimensions(_Strict):
    """One size of a type."""

    extent: tuple[PositiveFloat, PositiveFloat, PositiveFloat]
    """Size of the bounding box [m]."""
    mass: float = Field(gt=0, le=2)
    """[kg]; what one arm can hold out."""


class ObjectType(_Strict):
    """A type of object."""

    form: Form
    grasps: tuple[GraspKind, ...] = Field(min_length=1)
    """How it may be held, the best first."""
    sizes: dict[ObjectSize, Dimensions] = Field(min_length=1)
    wall: float = Field(0.007, gt=0.002, lt=0.02)
    """Thickness of a shell's wall [m]."""
    handle: float = Field(0.015, gt=0.005, lt=0.05)
    """Width of a utensil's handle [m]."""

    @field_validator("sizes")
    @classmethod
    def _low_enough(cls, sizes: dict[ObjectSize, Dimensions]) -> dict[ObjectSize, Dimensions]:
        for name, size in sizes.items():
            if max(size.extent) > 0.35:
                raise ValueError(f"{name}: no side may be longer than 0.35 m")
        return sizes

    @model_validator(mode="after")
    def _can_be_held(self) -> "ObjectType":
        allowed = _GRASPS_OF[self.form]
        wrong = [kind for kind in self.grasps if kind not in allowed]
        if wrong:
            raise ValueError(f"grasps: a {self.form} cannot be held by {wrong[0]!r}; allowed: {', '.join(allowed)}")
        for name, size in self.sizes.items():
            if self.form in ("cylinder", "shell") and size.extent[0] != size.extent[1]:
                raise ValueError(f"sizes.{name}.extent: a {self.form} is round, so x and y must be equal")
            if self._thickness(size.extent) > WIDEST_GRIP:
                raise ValueError(f"sizes.{name}.extent: too thick for the gripper, which holds {WIDEST_GRIP} m")
        return self

    def shape(self, size: ObjectSize) -> Shape:
        """The shape in one of its sizes."""
        dimensions = self.sizes[size]
        return Shape(self.form, dimensions.extent, dimensions.mass, self.wall, self.handle, self.grasps)

    def _thickness(self, extent: tuple[float, float, float]) -> float:
        """What must fit between the fingers [m]."""
        if self.form == "shell":
            return self.wall
        return self.handle if self.form == "utensil" else min(extent[0], extent[1])


TYPES: TypeAdapter[dict[str, ObjectType]] = TypeAdapter(dict[str, ObjectType])


@cache
def standard_types() -> Mapping[str, ObjectType]:
    """The types that come with Attune, by name."""
    text = (resources.files("attune.data") / "objects.toml").read_text(encoding="utf-8")
    return MappingProxyType(TYPES.validate_python(tomllib.loads(text)))


def clearance_needed(shape: Shape) -> float:
    """Free height that an object needs where it stands, so that it can be taken [m]."""
    return shape.extent[2] + 0.05 if "side" in shape.grasps else inf
