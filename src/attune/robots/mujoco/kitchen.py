"""The scene's room and furniture as a MuJoCo model.

Names: each piece is a static body with its own name. Each container's moving part is a body `NAME_leaf` with a joint
`NAME_joint` (0 is closed, positive opens) and a handle, which is a geom and a site `NAME_handle`: a round bar along the
site's x, the site's z pointing away from the front.
"""

from collections.abc import Sequence
from math import cos, pi, sin

import mujoco

from attune.core.furniture import BOARD, DRAWER_WALL, TOP_THICKNESS, Counter, Cupboard, Drawer, Furniture, Material
from attune.core.scene import Scene
from attune.robots.mujoco.contact import FURNITURE, VISUAL_GROUP

HANDLE_RADIUS = 0.009
HANDLE_STANDOFF = 0.05
"""From a front to the middle of its handle's bar [m]."""
HANDLE_HALF_LENGTH = 0.09
WALLS = "walls"
"""The body of the room's walls."""
WALL_HEIGHT = 2.3
LOW_WALL_HEIGHT = 0.12
"""Of the walls that one looks over into the room."""

Rgba = tuple[float, float, float, float]

_COLORS: dict[Material, tuple[Rgba, Rgba]] = {
    "wood": ((0.72, 0.53, 0.34, 1), (0.80, 0.62, 0.43, 1)),
    "white": ((0.86, 0.86, 0.84, 1), (0.55, 0.42, 0.31, 1)),
    "grey": ((0.50, 0.53, 0.56, 1), (0.82, 0.81, 0.78, 1)),
    "dark": ((0.24, 0.24, 0.26, 1), (0.34, 0.34, 0.36, 1)),
    "steel": ((0.70, 0.72, 0.74, 1), (0.78, 0.80, 0.82, 1)),
}
"""Of the body, and of the top or front."""
_METAL: Rgba = (0.35, 0.36, 0.38, 1)
_INSIDE: Rgba = (0.93, 0.93, 0.92, 1)

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
_SOLID: dict[str, object] = {"contype": FURNITURE, "conaffinity": 0, "friction": (0.7, 0.005, 0.0001), "mass": 0.0}
_LOOKS: dict[str, object] = {"contype": 0, "conaffinity": 0, "group": VISUAL_GROUP, "mass": 0.0}


def handle_name(container: str) -> str:
    """The geom and the site of a container's handle."""
    return f"{container}_handle"


def joint_name(container: str) -> str:
    """The joint that opens a container."""
    return f"{container}_joint"


def leaf_name(container: str) -> str:
    """The body of a container's moving part."""
    return f"{container}_leaf"


def add_kitchen(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Add the room, its light and its furniture, all containers closed."""
    spec.compiler.degree = False
    _add_room(spec, *scene.room)
    for piece in scene.furniture:
        _add_piece(spec, piece)


def _add_room(spec: mujoco.MjSpec, width: float, depth: float) -> None:
    spec.add_texture(
        name="tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=(0.80, 0.77, 0.72),
        rgb2=(0.76, 0.73, 0.68),
        width=256,
        height=256,
    )
    tiles = spec.add_material(name="tiles", texrepeat=(1, 1), texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    world = spec.worldbody
    world.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=(width / 2, depth / 2, 0),
        size=(width / 2, depth / 2, 0.1),
        material="tiles",
        **(_SOLID | {"friction": (1.0, 0.005, 0.0001)}),
    )
    walls = world.add_body(name=WALLS)
    high, low = WALL_HEIGHT / 2, LOW_WALL_HEIGHT / 2
    for middle, half in (
        ((width / 2, depth + 0.05, high), (width / 2 + 0.1, 0.05, high)),
        ((-0.05, depth / 2, high), (0.05, depth / 2, high)),
        ((width / 2, -0.05, low), (width / 2 + 0.1, 0.05, low)),
        ((width + 0.05, depth / 2, low), (0.05, depth / 2, low)),
    ):
        _box(walls, middle, half, (0.88, 0.86, 0.80, 1))
    for x, y in ((0.3 * width, 0.35 * depth), (0.75 * width, 0.55 * depth)):
        world.add_light(
            pos=(x, y, 2.8),
            dir=(0, 0.2, -1),
            diffuse=(0.45, 0.44, 0.42),
            specular=(0.1, 0.1, 0.1),
            cutoff=80,
            castshadow=False,
        )
    spec.visual.headlight.ambient = (0.45, 0.45, 0.45)
    spec.visual.headlight.diffuse = (0.45, 0.45, 0.45)


def _add_piece(spec: mujoco.MjSpec, piece: Furniture) -> None:
    body = spec.worldbody.add_body(name=piece.name, pos=(*piece.position, piece.bottom), quat=_about_z(piece.yaw))
    if piece.kind == "counter":
        _add_counter(body, piece)
    elif piece.kind == "cupboard":
        _add_cupboard(body, piece)
    else:
        width, depth, height = piece.size
        side, top = _COLORS[piece.material]
        _box(body, (0, 0, height - TOP_THICKNESS / 2), (width / 2, depth / 2, TOP_THICKNESS / 2), top)
        legs = height - TOP_THICKNESS
        if piece.kind == "table":
            for x in (0.035 - width / 2, width / 2 - 0.035):
                for y in (0.035 - depth / 2, depth / 2 - 0.035):
                    _box(body, (x, y, legs / 2), (0.03, 0.03, legs / 2), side)
        else:
            for x in (BOARD / 2 - width / 2, width / 2 - BOARD / 2):
                _box(body, (x, 0, legs / 2), (BOARD / 2, depth / 2, legs / 2), side)
            _box(body, (0, 0, 0.12), (width / 2 - BOARD, depth / 2, BOARD / 2), side)
            _box(body, (0, depth / 2 - 0.005, legs / 2), (width / 2 - BOARD, 0.005, legs / 2), side)


def _add_counter(body: mujoco.MjsBody, counter: Counter) -> None:
    width, depth, height = counter.size
    side, top = _COLORS[counter.material]
    under = height - TOP_THICKNESS
    _box(body, (0, 0, under + TOP_THICKNESS / 2), (width / 2, depth / 2, TOP_THICKNESS / 2), top)
    left = -width / 2
    for drawer in sorted(counter.drawers, key=lambda drawer: drawer.x):
        start, end, floor = drawer.x - drawer.width / 2, drawer.x + drawer.width / 2, under - drawer.height
        _block(body, (left, start), depth, under, side)
        _block(body, (start, end), depth, floor, side)
        behind = depth - drawer.depth
        _box(body, (drawer.x, (depth - behind) / 2, under - drawer.height / 2),
             (drawer.width / 2, behind / 2, drawer.height / 2), side)  # fmt: skip
        _add_drawer(body, drawer, (drawer.x, -depth / 2, floor), top if counter.material == "white" else side)
        left = end
    _block(body, (left, width / 2), depth, under, side)
    if counter.sink:
        middle = (width - counter.sink.width) / 2 * (-1 if counter.sink.side == "left" else 1)
        half = counter.sink.width / 2 - 0.06
        _box(body, (middle, -0.02, height + 0.001), (half, depth / 2 - 0.1, 0.002), _METAL, **_LOOKS)
        _box(
            body, (middle, -0.02, height + 0.002), (half - 0.02, depth / 2 - 0.12, 0.002), (0.2, 0.2, 0.21, 1), **_LOOKS
        )
        tap = depth / 2 - 0.06
        _bar(body, (middle, tap, height), (middle, tap, height + 0.24), 0.014, _METAL)
        _bar(body, (middle, tap, height + 0.23), (middle, tap - 0.17, height + 0.23), 0.012, _METAL)


def _block(body: mujoco.MjsBody, span: tuple[float, float], depth: float, height: float, color: Rgba) -> None:
    """A solid part of a counter, with a front that looks like doors."""
    left, right = span
    if right - left < 1e-3:
        return
    middle, half = (left + right) / 2, (right - left) / 2
    _box(body, (middle, 0, height / 2), (half, depth / 2, height / 2), color)
    _box(body, (middle, -depth / 2, 0.05), (half, 0.002, 0.05), (0.15, 0.15, 0.16, 1), **_LOOKS)
    doors = max(1, round((right - left) / 0.5))
    for door in range(doors):
        x = left + (door + 0.5) * (right - left) / doors
        red, green, blue = (0.93 * part for part in color[:3])
        half_width = (right - left) / doors / 2 - 0.012
        if half_width > 0.05:
            _box(
                body,
                (x, -depth / 2, height / 2 + 0.05),
                (half_width, 0.003, height / 2 - 0.065),
                (red, green, blue, 1),
                **_LOOKS,
            )


def _add_drawer(body: mujoco.MjsBody, drawer: Drawer, corner: Sequence[float], color: Rgba) -> None:
    half, depth, height, wall = drawer.width / 2, drawer.depth, drawer.height, DRAWER_WALL
    leaf = _leaf(body, drawer.name, corner, mujoco.mjtJoint.mjJNT_SLIDE, (0, -1, 0), drawer.travel, 8.0, 1.5)
    sides = min(height - 0.05, 0.09)
    _box(leaf, (0, -0.009, height / 2), (half - 0.004, 0.009, height / 2 - 0.004), color, mass=1.2)
    _box(leaf, (0, depth / 2, 1.5 * wall), (half - wall, depth / 2 - wall / 2, wall / 2), _INSIDE, mass=0.8)
    _box(leaf, (0, depth - wall, sides / 2 + wall), (half - wall, wall / 2, sides / 2), _INSIDE, mass=0.2)
    for x in (wall * 1.5 - half, half - wall * 1.5):
        _box(leaf, (x, depth / 2, sides / 2 + wall), (wall / 2, depth / 2 - wall / 2, sides / 2), _INSIDE, mass=0.2)
    _handle(leaf, drawer.name, (0, -0.018, height / 2), upright=False)


def _add_cupboard(body: mujoco.MjsBody, cupboard: Cupboard) -> None:
    width, depth, height = cupboard.size
    side, front = _COLORS[cupboard.material]
    board, half = cupboard.board, (height - cupboard.board) / 2
    _box(body, (0, 0, board / 2), (width / 2, depth / 2, board / 2), side)
    for x in (BOARD / 2 - width / 2, width / 2 - BOARD / 2):
        _box(body, (x, 0, board + half), (BOARD / 2, depth / 2, half), side)
    _box(body, (0, depth / 2 - BOARD / 2, board + half), (width / 2 - BOARD, BOARD / 2, half), side)
    _box(body, (0, 0, height - BOARD / 2), (width / 2 - BOARD, depth / 2, BOARD / 2), side)
    _box(body, (0, depth / 2 - BOARD, board + half), (width / 2 - BOARD, 0.001, half - BOARD), _INSIDE, **_LOOKS)
    _box(body, (0, 0, board), (width / 2 - BOARD, depth / 2 - BOARD, 0.001), _INSIDE, **_LOOKS)
    if 0 < cupboard.above_floor <= 0.8:
        # What does not hang high on a wall stands on a plinth.
        stand = cupboard.above_floor / 2
        _box(body, (0, 0, -stand), (width / 2, depth / 2, stand), (0.86, 0.86, 0.84, 1))

    hinge = cupboard.hinge
    sideways = {"left": 1.0, "right": -1.0, "bottom": 0.0}[hinge]
    corner = (-sideways * width / 2, -depth / 2, 0.0)
    axis = (1, 0, 0) if hinge == "bottom" else (0, 0, -sideways)
    kind = mujoco.mjtJoint.mjJNT_HINGE
    leaf = _leaf(body, cupboard.name, corner, kind, axis, cupboard.travel, 1.0, 0.3)
    # A dishwasher's door is balanced by a spring; an upright one does not mind.
    leaf.gravcomp = 1.0
    panel = (sideways * width / 2, -0.011, height / 2)
    _box(leaf, panel, (width / 2 - 0.002, 0.01, height / 2 - 0.002), front, mass=3.0 + 4.0 * width * height)
    if hinge == "bottom":
        _handle(leaf, cupboard.name, (0, -0.021, height - 0.07), upright=False)
    else:
        at = min(max(1.05 - cupboard.above_floor, 0.14), height - 0.14)
        _handle(leaf, cupboard.name, (sideways * (width - 0.05), -0.021, at), upright=True)


def _leaf(
    body: mujoco.MjsBody, name: str, pos: Sequence[float], kind: mujoco.mjtJoint, axis: Sequence[float],
    travel: float, damping: float, friction: float,
) -> mujoco.MjsBody:  # fmt: skip
    leaf = body.add_body(name=leaf_name(name), pos=pos)
    leaf.add_joint(
        name=joint_name(name),
        type=kind,
        axis=axis,
        range=(0, travel),
        damping=damping,
        frictionloss=friction,
        armature=0.1,
    )
    return leaf


def _handle(leaf: mujoco.MjsBody, name: str, front: Sequence[float], *, upright: bool) -> None:
    bar = (front[0], front[1] - HANDLE_STANDOFF, front[2])
    along = (0.0, 0.0, HANDLE_HALF_LENGTH) if upright else (HANDLE_HALF_LENGTH, 0.0, 0.0)
    ends = [tuple(middle + sign * part for middle, part in zip(bar, along, strict=True)) for sign in (-1, 1)]
    _bar(leaf, ends[0], ends[1], HANDLE_RADIUS, _METAL, name=handle_name(name), mass=0.1, shape=_CAPSULE)
    for end in ends:
        _bar(leaf, end, (end[0], front[1], end[2]), HANDLE_RADIUS * 0.8, _METAL, **_LOOKS)
    # Site axes in the leaf's frame: x along the bar, z out of the front.
    quat = (0.5, 0.5, -0.5, 0.5) if upright else (cos(pi / 4), sin(pi / 4), 0.0, 0.0)
    leaf.add_site(name=handle_name(name), pos=bar, quat=quat, group=4)


_CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE


def _box(body: mujoco.MjsBody, pos: Sequence[float], half: Sequence[float], color: Rgba, **more: object) -> None:
    body.add_geom(type=_BOX, pos=pos, size=half, rgba=color, **(_SOLID | more))


def _bar(
    body: mujoco.MjsBody, start: Sequence[float], end: Sequence[float], radius: float, color: Rgba,
    shape: mujoco.mjtGeom = _CYLINDER, **more: object,
) -> None:  # fmt: skip
    body.add_geom(type=shape, fromto=(*start, *end), size=(radius, 0, 0), rgba=color, **(_SOLID | more))


def _about_z(yaw: float) -> tuple[float, float, float, float]:
    return cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)
