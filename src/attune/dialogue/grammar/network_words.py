"""What the command network reads: an utterance and the situation, as plain words."""

import re
from collections.abc import Iterator

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.items import Spot, Thing
from attune.dialogue.grammar.tokens import tokenize

_CALLED = {"robot": ("robot", ","), "dear": ("dear", ","), "else": ("anna", ","), "": ()}
_PREPOSITIONS = {"from": "from", "to": "to", "at": "on", "": ""}
_PLACEHOLDER = re.compile(r"[TP]\d+")


def words_of(sentence: Sentence) -> list[str]:
    """The words of an utterance, with who is called before them, and each thing and place by its plainest name."""
    words = list(_CALLED[sentence.called])
    for word in sentence.skeleton.split():
        if not _PLACEHOLDER.fullmatch(word):
            words.append(word)
        elif word[0] == "T":
            words.extend(_thing(sentence.things[int(word[1:])]))
        else:
            words.extend(_spot(sentence.spots[int(word[1:])]))
    return words


def words_about(context: Context) -> list[str]:
    """The situation in words: what the robot does, holds and has brought, and what it asked or said last."""
    words: list[str] = []
    if context.task:
        words += ["busy", *context.task.command.split("_")]
        words += [word for spec in context.task.objects for word in _described(spec)]
        words += ["to", context.task.destination] if context.task.destination else []
    if context.carrying:
        words += ["carrying", *_described(context.carrying)]
    if context.delivered:
        words += ["delivered", *(word for spec in context.delivered for word in _described(spec))]
    if context.pending_question:
        words += ["asked", *(token.text for token in tokenize(context.pending_question))]
    elif context.last_robot_utterance:
        words += ["said", *(token.text for token in tokenize(context.last_robot_utterance))]
    return words or ["idle"]


def _described(spec: ObjectSpec) -> Iterator[str]:
    return (word for word in (spec.size, spec.color, *spec.type.split()) if word)


def _thing(thing: Thing) -> list[str]:
    spec = thing.spec
    size = {"big": "bigger", "small": "smaller"}.get(spec.size, spec.size) if thing.compared else spec.size
    named = spec.type or ("something" if thing.unknown else "one" if thing.head == "one" else "")
    words = (
        "the" if thing.definite and not thing.another else "a" if thing.article else "",
        str(thing.count) if thing.count > 1 else "",
        "another" if thing.another else "",
        "other" if thing.other else "",
        size, spec.color, named, "thing" if thing.unknown and spec.type else "",
    )  # fmt: skip
    return " ".join(words).split()


def _spot(spot: Spot) -> list[str]:
    return f"{_PREPOSITIONS[spot.role]} {'the' if spot.definite else ''} {spot.place}".split()
