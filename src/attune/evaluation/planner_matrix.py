"""The permutations of the planner test: which commands, in which order, interrupting each other at which step.

The paper's own part has each command of its two scenarios once, for each object type, each ordered pair of types and
both age groups. The parts beyond have the interruption at every step of the interrupted plan: at each change of the
robot's published state.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace

from attune.core.messages import Band
from attune.core.scene import Scene
from attune.evaluation.planner_sayings import Moment, Permutation, Saying

BANDS: tuple[Band, ...] = ("younger", "older")


def paper_permutations(scene: Scene) -> Iterator[Permutation]:
    """The paper's: each command once for each object type or ordered pair of types, and both age groups."""
    types = scene.vocabulary.types
    for band in BANDS:
        for first in types:
            yield Permutation("paper", "bring_me", band, (_bring(first),))
            for second in types:
                if second != first:
                    swap = Saying("replace_object", second, first, at="carrying")
                    yield Permutation("paper", "bring_me", band, (_bring(first), swap))
        breakfast = Saying("setting_breakfast")
        yield Permutation("paper", "setting_breakfast", band, (breakfast,))
        for also in types:
            extra, stop = _bring(also, "carrying"), Saying("stop", at="carrying")
            yield Permutation("paper", "setting_breakfast", band, (breakfast, extra))
            yield Permutation("paper", "setting_breakfast", band, (breakfast, extra, stop))


def undisturbed(scene: Scene) -> Iterator[Permutation]:
    """The runs whose state changes are the moments of the parts beyond the paper."""
    for band in BANDS:
        yield Permutation("every step", "setting_breakfast", band, (Saying("setting_breakfast"),))
        for first in scene.vocabulary.types:
            yield Permutation("every step", "bring_me", band, (_bring(first),))
    yield from _each_other()


def _each_other() -> Iterator[Permutation]:
    """Each command at work: alone, or interrupting the delivery of an object, or after that."""
    spoon, juice = _bring("spoon"), _bring("juice")
    shelf = Saying("change_location", place="shelf")
    tasks: tuple[tuple[Saying, ...], ...] = (
        (Saying("bring_me", "bowl", also="spoon"),),
        (Saying("bring_me", "cup", source="cabinet", place="shelf"),),
        (Saying("setting_breakfast"),),
        (spoon, Saying("replace_object", "juice", "spoon", at="carrying")),
        (spoon, Saying("replace_object", "bowl", "spoon", at="settled")),
        (juice, replace(shelf, at="carrying")),
        (spoon, replace(shelf, at="settled")),
        (Saying("bring_me", "juice", also="spoon"), Saying("cancel_object", "juice", at="carrying")),
        (spoon, Saying("put_back", at="carrying")),
        (juice, Saying("put_back", at="settled")),
        (spoon, Saying("stop", at="carrying"), Saying("carry_on", at="settled")),
    )
    for index, sayings in enumerate(tasks):
        yield Permutation("each other", sayings[-1].kind, BANDS[index % 2], sayings)


def interrupted(scene: Scene, alone: Permutation, changes: int) -> Iterator[Permutation]:
    """An undisturbed run, interrupted by each command at each of its state changes.

    Args:
        scene: Names the object types.
        alone: The run.
        changes: How many states it publishes after its last command.
    """
    for step in range(changes + 1):
        stop = Saying("stop", at=step)
        for sayings in (
            _others(alone, step) if alone.part == "each other" else _the_papers(scene, alone, step),
            [(stop,), (stop, Saying("carry_on", at="settled"))],
        ):
            for more in sayings:
                yield replace(alone, sayings=(*alone.sayings, *more))


def _the_papers(scene: Scene, alone: Permutation, step: int) -> list[tuple[Saying, ...]]:
    """Each ordered pair of types for one age group.

    For the other, whose plans differ little, and in the breakfast, where much is the same at each step, one type after
    the other.
    """
    (first,) = alone.sayings
    types = [type_ for type_ in scene.vocabulary.types if type_ != first.type]
    breakfast = first.kind == "setting_breakfast"
    if breakfast or alone.band != BANDS[-1]:
        types = [types[step % len(types)]]
    if breakfast:
        return [(_bring(type_, step),) for type_ in types]
    return [(Saying("replace_object", type_, first.type, at=step),) for type_ in types]


def _others(alone: Permutation, step: int) -> list[tuple[Saying, ...]]:
    """Every other command. What they are about is what the first command asked for, or what nobody asked for."""
    first = alone.sayings[0]
    own = first.type or "milk"
    elsewhere = "table" if alone.band == "younger" else "countertop"
    new = _bring("knife", step)
    return [
        (new,),
        (Saying("bring_me", "mug", also="fork", source="cabinet", place=elsewhere, at=step),),
        (Saying("setting_breakfast", at=step),),
        (Saying("replace_object", "knife", own, at=step),),
        (Saying("change_location", place=elsewhere, at=step),),
        (Saying("change_location", own, place="table" if first.place else "shelf", at=step),),
        (Saying("cancel_object", own, at=step),),
        (Saying("put_back", at=step),),
        (Saying("stop", at=step), replace(new, at="settled")),
    ]


def sample(permutations: Sequence[Permutation], count: int, seed: int) -> tuple[Permutation, ...]:
    """At most `count` of them, chosen at random, in their order."""
    chosen = random.Random(seed).sample(range(len(permutations)), min(count, len(permutations)))
    return tuple(permutations[index] for index in sorted(chosen))


def _bring(type_: str, at: Moment = 0) -> Saying:
    return Saying("bring_me", type_, at=at)
