"""What pointing words mean: "the other one", "a bigger one", "the blue one", "another one"."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.items import Thing, described

_SIZES = ("small", "normal", "big")


def fits(wanted: ObjectSpec, has: ObjectSpec) -> bool:
    """Whether every property of `wanted` is one of `has`, or unknown there."""
    return all(
        not w or not h or w == h
        for w, h in ((wanted.type, has.type), (wanted.color, has.color), (wanted.size, has.size))
    )


def is_described_by(wanted: ObjectSpec, has: ObjectSpec) -> bool:
    """Whether `has` is known to have every property of `wanted`."""
    return all(
        not w or w == h
        for w, h in (
            (wanted.type, has.type), (wanted.color, has.color), (wanted.size, has.size),
            (wanted.location, has.location or wanted.location),
        )
    )  # fmt: skip


def object_spoken_of(
    context: Context, wanted: ObjectSpec = ObjectSpec(), said: Sequence[ObjectSpec] = ()
) -> ObjectSpec | None:
    """The object that a correction is about: of the wanted type if there is one, else what is carried, and so on."""
    recent = [spec for spec in context.recent if not (spec.type == wanted.type and is_described_by(wanted, spec))]
    recent = recent or list(context.recent)
    same = [spec for spec in recent if wanted.type and spec.type == wanted.type]
    if same:
        return _plain(same[0])
    mentioned = [spec for spec in recent if any(fits(s, spec) and s.type == spec.type for s in said)]
    if context.carrying is None and mentioned:
        return _plain(mentioned[0])
    return _plain(recent[0]) if recent else None


def in_their_roles(
    add: Sequence[ObjectSpec], remove: Sequence[ObjectSpec], recent: Sequence[ObjectSpec]
) -> tuple[tuple[ObjectSpec, ...], tuple[ObjectSpec, ...]]:
    """What comes and what goes: what the robot is about already is not wanted anew by who wants something instead."""

    def about(spec: ObjectSpec) -> bool:
        return any(spec.type == has.type and is_described_by(replace(spec, location=""), has) for has in recent)

    old = tuple(spec for spec in add if about(spec))
    new = tuple(spec for spec in add if spec not in old)
    if old and new:
        return new, tuple(spec for spec in remove if spec not in new) or old
    if old and remove and not any(about(spec) for spec in remove):
        return tuple(remove), old
    return tuple(add), tuple(remove)


def resolve(  # noqa: PLR0911 - one rule per return
    thing: Thing, context: Context, before: Sequence[ObjectSpec], said: Sequence[ObjectSpec]
) -> ObjectSpec | None:
    """What a noun phrase without a noun means.

    Args:
        thing: The noun phrase.
        context: The situation.
        before: Nouns of the same utterance, nearest last.
        said: What the robot spoke of last.

    Returns:
        The description, or None when nothing fits.
    """
    spec = thing.spec
    if before:
        return replace(spec, type=before[-1].type, location=spec.location)
    base = _base(thing, context, said)
    if base is None:
        return _only_type(spec, context.scene)
    if thing.other:
        return _other(spec, base, context)
    if thing.compared:
        return _compared(spec, base, context)
    if thing.ordinal > 0 and len(said) >= thing.ordinal:
        return said[thing.ordinal - 1]
    if thing.ordinal < 0 and said:
        return said[-1]
    merged = described(base.type, spec.color or base.color, spec.size or base.size, spec.location)
    return _existing(merged, spec, base, context.scene)


def _base(thing: Thing, context: Context, said: Sequence[ObjectSpec]) -> ObjectSpec | None:
    recent = list(context.recent)
    if len(recent) > 1 and thing.spec.color:
        # "the blue one" is said of something that has another colour.
        recent.sort(key=lambda spec: not spec.color)
    if recent:
        types = {spec.type for spec in recent}
        if len(types) > 1 and context.carrying is None:
            for spec in recent:
                if any(s.type == spec.type for s in said):
                    return spec
        return recent[0]
    return said[-1] if said else None


def _existing(merged: ObjectSpec, named: ObjectSpec, base: ObjectSpec, scene: Sequence[ObjectSpec]) -> ObjectSpec:
    """Drop properties taken over from `base` that no such object of the scene has."""
    known = [has for has in scene if has.type == merged.type]
    if not known or any(is_described_by(replace(merged, location=""), has) for has in known):
        return merged
    matching = [has for has in known if is_described_by(described(merged.type, named.color, named.size), has)]
    if len(matching) == 1:
        return replace(merged, color=named.color or matching[0].color, size=named.size or matching[0].size)
    return merged


def _other(spec: ObjectSpec, base: ObjectSpec, context: Context) -> ObjectSpec:
    kind = spec.type or base.type
    others = _distinct(
        has for has in context.scene
        if has.type == kind and fits(spec, has) and not is_described_by(_plain(base), has)
    )  # fmt: skip
    if len(others) == 1:
        return described(kind, others[0].color, others[0].size, spec.location)
    return replace(spec, type=kind)


def _compared(spec: ObjectSpec, base: ObjectSpec, context: Context) -> ObjectSpec:
    kind = spec.type or base.type
    here = _SIZES.index(base.size or "normal")
    fitting = [
        has for has in context.scene
        if has.type == kind and has.size and (not spec.color or has.color == spec.color)
        and ((_SIZES.index(has.size) > here) if spec.size == "big" else (_SIZES.index(has.size) < here))
    ]  # fmt: skip
    same_color = [has for has in fitting if has.color == base.color]
    candidates = _distinct(same_color or fitting)
    if len(candidates) == 1:
        return described(kind, candidates[0].color, candidates[0].size, spec.location)
    return described(kind, spec.color or base.color, spec.size, spec.location)


def _only_type(spec: ObjectSpec, scene: Sequence[ObjectSpec]) -> ObjectSpec | None:
    types = {has.type for has in scene if is_described_by(spec, has)}
    return replace(spec, type=types.pop()) if len(types) == 1 and (spec.color or spec.size) else None


def _distinct(specs: Iterable[ObjectSpec]) -> list[ObjectSpec]:
    return list(dict.fromkeys(_plain(spec) for spec in specs))


def _plain(spec: ObjectSpec) -> ObjectSpec:
    return described(spec.type, spec.color, spec.size)
