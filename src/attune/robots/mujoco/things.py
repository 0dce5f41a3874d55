"""The scene's objects as free MuJoCo bodies, each named after its object, the origin at its bottom centre.

Round things get a square foot a little inside their edge: MuJoCo is fast and steady with boxes that rest on boxes. The
handle of a mug is only looked at.
"""

from collections.abc import Sequence
from math import cos, pi, sin, tan

import mujoco

from attune.core.scene import Scene, SceneObject
from attune.core.shapes import COLORS, Shape
from attune.robots.mujoco.contact import FURNITURE, OBJECT, VISUAL_GROUP

FOOT = 0.003
"""Height of a round thing's foot [m]."""
WALLS = 12
"""Flat pieces that the wall of a bowl or plate is made of."""

Rgba = tuple[float, float, float, float]

_SOLID: dict[str, object] = {
    "contype": OBJECT, "conaffinity": FURNITURE | OBJECT, "friction": (0.8, 0.01, 0.0005), "condim": 4,
}  # fmt: skip
_LOOKS: dict[str, object] = {"contype": 0, "conaffinity": 0, "group": VISUAL_GROUP, "mass": 0.0}
_BOX = mujoco.mjtGeom.mjGEOM_BOX
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER


def free_joint(name: str) -> str:
    """The free joint of an object."""
    return f"{name}_free"


def add_things(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Add all objects of the scene where they are at first."""
    for thing in scene.objects:
        start = scene.starts[thing.name]
        body = spec.worldbody.add_body(
            name=thing.name,
            pos=(start.x, start.y, start.z + 0.0005),
            quat=(cos(start.yaw / 2), 0, 0, sin(start.yaw / 2)),
        )
        body.add_freejoint(name=free_joint(thing.name))
        _add_shape(body, thing, scene.shape(thing.name))


def _add_shape(body: mujoco.MjsBody, thing: SceneObject, shape: Shape) -> None:
    opacity = 0.55 if thing.type == "glass" else 1.0
    color = (*COLORS[thing.color], opacity)
    length, width, height = shape.extent
    if shape.form == "cylinder":
        _add_round(body, thing, shape, color)
    elif shape.form == "shell":
        _add_shell(body, shape, color)
    elif shape.form == "utensil":
        # The middle of the handle's pinched part is the origin; the head takes the last quarter.
        head = 0.27 * length
        _solid(
            body,
            (-head / 2, 0, height / 2),
            ((length - head) / 2, shape.handle / 2, height / 2),
            color,
            0.6 * shape.mass,
        )
        _solid(body, ((length - head) / 2, 0, height / 2), (head / 2, width / 2, height / 2), color, 0.4 * shape.mass)
    else:
        _solid(body, (0, 0, height / 2), (length / 2, width / 2, height / 2), color, shape.mass)
        if thing.type in ("milk", "cereal"):
            label = (0.95, 0.95, 0.93, 1)
            _looks(body, _BOX, (0, 0, 0.55 * height), (length / 2 + 0.0005, 0.3 * width, 0.12 * height), label)
            _looks(body, _BOX, (0, 0, 0.55 * height), (0.3 * length, width / 2 + 0.0005, 0.12 * height), label)


def _add_round(body: mujoco.MjsBody, thing: SceneObject, shape: Shape, color: Rgba) -> None:
    radius, height = shape.extent[0] / 2, shape.extent[2]
    foot = radius * 0.7
    _solid(body, (0, 0, FOOT), (foot, foot, FOOT), color, 0.3 * shape.mass)
    half = (height - FOOT) / 2
    body.add_geom(
        type=_CYLINDER, pos=(0, 0, FOOT + half), size=(radius, half, 0), rgba=color, mass=0.7 * shape.mass, **_SOLID
    )
    if thing.type in ("cup", "mug"):
        inside = (0.25 * color[0], 0.25 * color[1], 0.25 * color[2], 1.0)
        _looks(body, _CYLINDER, (0, 0, height), (radius - 0.005, 0.0005, 0), inside)
    if thing.type == "mug":
        for z in (0.3, 0.7):
            _looks(body, _BOX, (radius + 0.01, 0, z * height), (0.013, 0.005, 0.005), color)
        _looks(body, _BOX, (radius + 0.021, 0, 0.5 * height), (0.005, 0.005, 0.2 * height + 0.005), color)
    if thing.type == "juice":
        _looks(body, _CYLINDER, (0, 0, height), (0.4 * radius, 0.006, 0), (0.95, 0.95, 0.93, 1))


def _add_shell(body: mujoco.MjsBody, shape: Shape, color: Rgba) -> None:
    radius, height, wall = shape.extent[0] / 2, shape.extent[2], shape.wall
    foot = radius * 0.68
    _solid(body, (0, 0, wall / 2), (foot, foot, wall / 2), color, 0.5 * shape.mass)
    _looks(body, _CYLINDER, (0, 0, wall / 2 + 0.001), (radius - wall / 2, wall / 2, 0), color)
    middle = radius - wall / 2
    half = radius * tan(pi / WALLS)
    for piece in range(WALLS):
        turn = 2 * pi * piece / WALLS
        body.add_geom(
            type=_BOX,
            pos=(middle * cos(turn), middle * sin(turn), (FOOT + height) / 2),
            quat=(cos(turn / 2), 0, 0, sin(turn / 2)),
            size=(wall / 2, half, (height - FOOT) / 2),
            rgba=color,
            mass=0.5 * shape.mass / WALLS,
            **_SOLID,
        )


def _solid(body: mujoco.MjsBody, pos: Sequence[float], half: Sequence[float], color: Rgba, mass: float) -> None:
    body.add_geom(type=_BOX, pos=pos, size=half, rgba=color, mass=mass, **_SOLID)


def _looks(
    body: mujoco.MjsBody, kind: mujoco.mjtGeom, pos: Sequence[float], size: Sequence[float], color: Rgba
) -> None:
    body.add_geom(type=kind, pos=pos, size=size, rgba=color, **_LOOKS)
