"""What the robot itself asked, and what may answer it."""

import re
from dataclasses import dataclass, replace
from typing import Literal

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence, skeleton
from attune.dialogue.grammar.phrases import PhraseReader
from attune.dialogue.grammar.tokens import tokenize

_STOP_QUESTION = re.compile(r"\b(?:stop|cancel|give up|abort|pause)\b")
_GO_ON_QUESTION = re.compile(r"\b(?:carry on|continue|go on|keep going|resume)\b")


@dataclass(frozen=True, slots=True)
class Question:
    """What the robot asked.

    Attributes:
        kind: What an answer means: a choice among objects, a place, or a plain yes or no to something.
        options: The objects offered.
        places: The places offered.
    """

    kind: Literal["object", "place", "breakfast", "stop", "go_on", "repair"]
    options: tuple[ObjectSpec, ...] = ()
    places: tuple[str, ...] = ()


def read_question(text: str, context: Context, reader: PhraseReader) -> Question:
    """Understand the robot's own question."""
    sentences = [part for part in re.split(r"(?<=[.?!])\s+", text) if part.strip()]
    asked = [part for part in sentences if "?" in part] or sentences
    lowered = " ".join(asked).lower()
    if "breakfast" in lowered and not _things(" ".join(asked), reader).things:
        return Question("breakfast")
    found = _options(" ".join(asked), context, reader, text)
    if not found and asked != sentences:
        found = _options(" ".join(sentences), context, reader, text)
    places = tuple(dict.fromkeys(spot.place for spot in _things(" ".join(asked), reader).spots if spot.role != "from"))
    is_where = re.match(r"\W*(?:where|which place|on which|to which)", lowered) is not None or re.search(
        r"\bwhere (?:should|shall|do|would)", lowered
    )
    puts = re.search(
        r"\b(?:put|place|leave|deliver|take|bring|set)\b(?: \w+){0,4}? (?:on|to|onto|in|"
        r"into)\b",
        lowered,
    )
    if is_where or (places and puts and not re.search(r"\bbring you\b|\bwould you like (?:the|a)\b", lowered)):
        return Question("place", found, places)
    if not found and _STOP_QUESTION.search(lowered):
        return Question("stop")
    if not found and _GO_ON_QUESTION.search(lowered):
        return Question("go_on")
    if re.match(r"\W*(?:sorry, |pardon, )?did you (?:say|mean)", lowered):
        return Question("repair", found, places)
    return Question("object", found, places)


def _things(text: str, reader: PhraseReader) -> Sentence:
    return skeleton(reader.items(tokenize(text)))


def _options(text: str, context: Context, reader: PhraseReader, whole: str) -> tuple[ObjectSpec, ...]:
    sentence = _things(text, reader)
    nouns = [thing.spec for thing in _things(whole, reader).things if thing.head == "noun"]
    options: list[ObjectSpec] = []
    for number, thing in enumerate(sentence.things):
        before = sentence.skeleton[: sentence.skeleton.index(f"T{number}")].rstrip()
        if re.search(r"\b(?:no|not (?:find|see|have|get)|instead of|rather than|no more|is no)$", before):
            continue
        spec = thing.spec
        if not spec.type:
            source = nouns[-1] if nouns else next(iter(context.recent), None)
            if source is None:
                continue
            spec = replace(spec, type=source.type)
            if options and options[-1].type == spec.type and options[-1].size and spec.size and not spec.color:
                # "The big white plate or the small one?": that one is white too.
                spec = replace(spec, color=options[-1].color)
        located = re.search(rf"\bT{number} P(\d+)", sentence.skeleton)
        if located and sentence.spots[int(located[1])].role in {"at", "from"}:
            spec = replace(spec, location=spec.location or sentence.spots[int(located[1])].place)
        options.append(spec)
        if either := re.search(rf"\bT{number} P(\d+)(?: ,)? or P(\d+)", sentence.skeleton):
            # "the milk from the fridge or from the table"
            places = [sentence.spots[int(n)] for n in either.groups()]
            if all(place.role in {"from", "at"} for place in places):
                options[-1:] = [replace(spec, location=place.place) for place in places]
    if len(options) > 1:
        # "Which cup would you like, the red or the blue one?": the cup as such is no option.
        bare = [spec for spec in options if not (spec.color or spec.size or spec.location)]
        specific = [spec for spec in options if spec.color or spec.size or spec.location]
        options = specific if specific and len({s.type for s in options}) == 1 and bare else options
    return tuple(dict.fromkeys(options))
