"""Checks what is asked for against what the robot believes to exist."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from attune.core.messages import BelievedObject, ObjectSpec
from attune.core.scene import Scene

Finding = Literal["unique", "any", "ambiguous", "absent", "elsewhere", "unknown_place", "unknown"]
_MOST_OPTIONS = 4


@dataclass(frozen=True, slots=True)
class Grounding:
    """What one description means in this kitchen.

    Attributes:
        finding: `unique`: one object fits; `any`: several do and any will do; `ambiguous`: several differ and the
            person meant one; `absent`: none fits, but `options` are near; `elsewhere`: none is at the place that was
            named, but `options` are somewhere else; `unknown_place`: the kitchen has no such place; `unknown`:
            nothing of this kind is known, the robot may look for it.
        options: What can be offered, the best first.
    """

    spec: ObjectSpec
    finding: Finding
    options: tuple[ObjectSpec, ...] = ()


def believed(world: Sequence[BelievedObject], scene: Scene) -> tuple[ObjectSpec, ...]:
    """The objects believed to exist; what the scene says, as long as the robot has told nothing."""
    if world:
        return tuple(item.spec for item in world)
    places = {surface.name: surface.place for surface in scene.surfaces}
    return tuple(
        ObjectSpec(type=o.type, color=o.color, size=o.size, location=places.get(o.at, ""), name=o.name)
        for o in scene.objects
    )


def ground(  # noqa: PLR0911 - one rule per return
    spec: ObjectSpec,
    definite: bool,
    known: Sequence[ObjectSpec],
    places: Sequence[str],
    busy_with: Sequence[ObjectSpec] = (),
) -> Grounding:
    """What `spec` means.

    Args:
        spec: What was asked for.
        definite: Whether the person meant a particular one ("the cup").
        known: Objects believed to exist.
        places: The kinds of place in this kitchen.
        busy_with: Objects the robot brings or has brought already: the person means another one.
    """
    if spec.location and spec.location not in places:
        return Grounding(spec, "unknown_place")
    fitting = [item for item in known if _is(spec, item) and spec.location in {"", item.location}]
    if not fitting:
        elsewhere = [item for item in known if spec.location and _is(spec, item)]
        if elsewhere:
            return Grounding(spec, "elsewhere", _distinct(elsewhere)[:1])
        kin = [item for item in known if item.type == spec.type and spec.type]
        if not kin:
            return Grounding(spec, "unknown")
        return Grounding(spec, "absent", _distinct(sorted(kin, key=lambda item: _differences(spec, item)))[:1])
    free = [item for item in fitting if not any(_is(_shown(item), other) for other in busy_with)] or fitting
    kinds = _distinct(free)
    if len(kinds) == 1:
        return Grounding(spec, "unique" if len(free) == 1 else "any", kinds)
    if definite:
        return Grounding(spec, "ambiguous", kinds[:_MOST_OPTIONS])
    return Grounding(spec, "any", kinds)


def _is(spec: ObjectSpec, item: ObjectSpec) -> bool:
    return all(
        not wanted or wanted == has
        for wanted, has in (
            (spec.name, item.name),
            (spec.type, item.type),
            (spec.color, item.color),
            (spec.size, item.size),
        )
    )


def _differences(spec: ObjectSpec, item: ObjectSpec) -> int:
    # A wrong colour is worse than a wrong size: people name colours to tell things apart.
    color = 2 if spec.color and spec.color != item.color else 0
    return color + (1 if spec.size and spec.size != item.size else 0)


def _shown(item: ObjectSpec) -> ObjectSpec:
    return replace(item, location="", name="")


def _distinct(items: Sequence[ObjectSpec]) -> tuple[ObjectSpec, ...]:
    return tuple(dict.fromkeys(_shown(item) for item in items))
