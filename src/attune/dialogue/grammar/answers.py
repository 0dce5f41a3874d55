"""Answers to what the robot asked: "the red one", "yes please", "either"."""

import re
from dataclasses import dataclass, replace
from typing import Literal

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence, skeleton
from attune.dialogue.grammar.items import Thing
from attune.dialogue.grammar.phrases import PhraseReader
from attune.dialogue.grammar.references import is_described_by, resolve
from attune.dialogue.grammar.remarks import NO, YES
from attune.dialogue.grammar.tokens import tokenize
from attune.dialogue.interpreter import Interpretation

_ANY = re.compile(
    r"\b(?:either|any(?: of (?:them|those|the two))?|whichever|whatever|do(?:es)? not (?:matter|care|mind)|"
    r"do not (?:care|mind)|you (?:choose|decide|pick)|surprise me|up to you|no preference|your choice|anyone)\b"
)
_BOTH = re.compile(r"\b(?:both|all of them|all|the two|the two of them)\b")
_LEADING_NO = re.compile(r"^(?:no|nope|not that(?: one)?|neither)\b(?: ,)? ?")
_LEADING_YES = re.compile(
    r"^(?:(?:yes|sure|okay|right|of course|please|exactly|alright|oh|well|i guess|i think|"
    r",) ?)+"
)
_STOP_QUESTION = re.compile(r"\b(?:stop|cancel|give up|abort|pause)\b")
_GO_ON_QUESTION = re.compile(r"\b(?:carry on|continue|go on|keep going|resume)\b")
_REQUEST = re.compile(r"\b(?:instead of|rather than|swap|replace|exchange|not T\d+ but)\b")
_ASKS = re.compile(
    r"(?:(?:and|but|so|well|okay|,) )*(?:what|where|how (?:many|much|long)|(?:do|have) (?:we|you)|(?:is|are) there)\b"
)
"""A question of the person's own is no answer, though it names what was offered: "what cups do you have?"."""
_ORDINAL = re.compile(
    r"^(?:(?:the|number|option|please|,|\.|yes|no|one) ?)*(?P<n>first|former|second|latter|last|one|"
    r"two)(?: (?:one|option|please|would be .*|then|,|\.))*$"
)
_ORDINALS = {"first": 0, "former": 0, "one": 0, "second": 1, "two": 1, "latter": -1, "last": -1}


_TWO = 2


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


_REFUSED = re.compile(
    r"\b(?:no|without|not (?:want |need |fancy |like )?(?:any )?) ?T(\d+)(?! instead)|"
    r"^(?:(?:no|thanks|thank you|oh|well|,) )*(?:no|thanks)(?: ,)? (?:i|we) (?:already )?(?:have|have got) T(\d+)"
)
_BRING_IT = re.compile(
    r"(?:(?:yes|please|okay|sure|go on|go ahead|why not|do|oui|then|and|,) ?)+(?:bring|fetch|get|take)"
    r"(?: (?:it|that|them|me that|me it|please|over|,))*"
)


def read_answer(text: str, sentence: Sentence, question: Question, context: Context) -> Interpretation | None:  # noqa: PLR0911, PLR0912 - one rule per return
    """What an answer means; None when it answers nothing (a new request, or talk).

    Args:
        text: The skeleton of what was said.
        sentence: The things and places in it.
        question: What was asked.
        context: The situation.
    """
    text = text.strip(" .,?")
    if len(question.options) == 1 and _BRING_IT.fullmatch(text):
        return _chosen(question.options)
    if len(question.options) == 1 and _refuses(text, sentence, question.options[0]):
        return Interpretation(intent="deny", confidence=0.9, reason="does not want what was offered")
    if _REQUEST.search(text) or _ASKS.match(text):
        return None
    if question.kind == "place":
        return _place_answer(text, sentence, question)
    plain = not re.search(r"\b[TP]\d+\b", text)
    if plain and NO.match(text):
        return Interpretation(intent="deny", confidence=0.9, reason="says no to the question")
    if plain and YES.match(text):
        return _agreed(question)
    options = question.options
    if not options:
        return None
    both = re.fullmatch(r"T(\d+)(?: please| thanks| ,)*", text)
    if both and sentence.things[int(both[1])].count == len(options) and sentence.things[int(both[1])].head == "one":
        return _chosen(options)
    ordinal = _ORDINAL.match(_LEADING_YES.sub("", text))
    if ordinal and len(options) > 1 and abs(_ORDINALS[ordinal["n"]]) < len(options):
        return _chosen((options[_ORDINALS[ordinal["n"]]],))
    if plain and _BOTH.search(text) and len(options) > 1 and len(text.split()) <= 6:
        return _chosen(options)
    denied = re.search(r"\b(?:not|no|never)\b", text)
    if (
        _ANY.search(text)
        and not denied
        and len(text.split()) <= 10
        and not _names_something_else(text, sentence, options)
    ):
        return _chosen(options[:1])
    refused = re.fullmatch(r"(?:no |, |well )*not T(\d+)(?: please| ,)*", text)
    if refused and len(options) == _TWO:
        number = int(refused[1])
        unwanted = _pick(sentence.things[number], number, f"T{number}", sentence, options, context)
        return _chosen(tuple(option for option in options if option != unwanted)) if unwanted else None
    chosen = [
        option
        for number, thing in enumerate(sentence.things)
        if f"T{number}" in text.split() and (option := _pick(thing, number, text, sentence, options, context))
    ]
    said = text.split()
    refused_too = set() if text.startswith("no T") else set(re.findall(r"\b(?:not|no) (T\d+)\b", text))
    things = [
        thing
        for number, thing in enumerate(sentence.things)
        if f"T{number}" in said and f"T{number}" not in refused_too
    ]
    if chosen and len(chosen) == len(things):
        return _chosen(tuple(dict.fromkeys(chosen)))
    if not things and sentence.spots:
        place = sentence.spots[-1].place
        at_place = [option for option in options if _place_of(option, context) == place]
        return _chosen((replace(at_place[0], location=place),)) if len(at_place) == 1 else None
    if len(things) == 1 and things[0].head != "noun" and not _LEADING_NO.match(text) and not things[0].other:
        kinds = {option.type for option in options}
        if len(kinds) == 1:
            return _chosen((replace(things[0].spec, type=kinds.pop()),))
    return None


def _refuses(text: str, sentence: Sentence, offered: ObjectSpec) -> bool:
    """Whether it is refused by its name: "no milk, thanks", "I'm fine without milk", "no, I've got a plate already"."""
    refused = [match[1] or match[2] for match in _REFUSED.finditer(text)]
    things = [sentence.things[int(number)] for number in refused]
    return any(not thing.definite and is_described_by(thing.spec, offered) for thing in things)


def _names_something_else(text: str, sentence: Sentence, options: tuple[ObjectSpec, ...]) -> bool:
    named = [sentence.things[int(number)] for number in re.findall(r"\bT(\d+)\b", text)]
    return any(thing.head == "noun" and thing.spec.type not in {o.type for o in options} for thing in named)


def _pick(
    thing: Thing, number: int, text: str, sentence: Sentence, options: tuple[ObjectSpec, ...], context: Context
) -> ObjectSpec | None:
    """The only option that fits what was said."""
    if re.search(rf"\b(?:not|no) T{number}\b", text) and not text.startswith("no T"):
        return None
    if thing.ordinal and len(options) > 1:
        index = thing.ordinal - 1 if thing.ordinal > 0 else -1
        return options[index] if index < len(options) else None
    spec = thing.spec
    located = re.search(rf"\bT{number} P(\d+)", text)
    if located and sentence.spots[int(located[1])].role in {"at", "from"}:
        spec = replace(spec, location=sentence.spots[int(located[1])].place)
    fitting = [
        option
        for option in options
        if is_described_by(replace(spec, location=""), option) and spec.location in {"", _place_of(option, context)}
    ]
    if thing.compared and not fitting:
        sized = sorted(options, key=lambda option: ("small", "", "normal", "big").index(option.size))
        fitting = [sized[-1] if spec.size == "big" else sized[0]]
    if len(fitting) > 1 and thing.other:
        return None
    return replace(fitting[0], location=fitting[0].location or spec.location) if len(fitting) == 1 else None


def _place_of(option: ObjectSpec, context: Context) -> str:
    """Where an option is: as the question said, or as the scene knows."""
    if option.location:
        return option.location
    places = {has.location for has in context.scene if is_described_by(option, has)}
    return places.pop() if len(places) == 1 else ""


def _place_answer(text: str, sentence: Sentence, question: Question) -> Interpretation | None:
    places = [spot.place for number, spot in enumerate(sentence.spots) if f"P{number}" in text.split()]
    if len(places) == 1 and not any(f"T{number}" in text.split() for number in range(len(sentence.things))):
        return Interpretation(
            intent="change_location", destination=places[0], confidence=0.9, reason="names the place asked for"
        )
    if places or sentence.things:
        return None
    if NO.match(text):
        return Interpretation(intent="deny", confidence=0.9, reason="says no to the question")
    if (YES.match(text) and len(question.places) == 1) or (_ANY.search(text) and question.places):
        return Interpretation(
            intent="change_location", destination=question.places[0], confidence=0.9, reason="agrees to the place"
        )
    ordinal = _ORDINAL.match(text)
    if ordinal and len(question.places) > 1:
        return Interpretation(
            intent="change_location",
            destination=question.places[_ORDINALS[ordinal["n"]]],
            confidence=0.9,
            reason="chooses a place",
        )
    return None


def _agreed(question: Question) -> Interpretation:
    if question.kind == "breakfast":
        return Interpretation(intent="setting_breakfast", confidence=0.9, reason="agrees to breakfast")
    if question.kind == "stop":
        return Interpretation(intent="stop", confidence=0.9, reason="agrees to stop")
    if question.kind == "go_on":
        return Interpretation(intent="carry_on", confidence=0.9, reason="agrees to go on")
    if len(question.options) == 1:
        return _chosen(question.options)
    return Interpretation(intent="affirm", confidence=0.7, reason="says yes, but not to what")


def _chosen(options: tuple[ObjectSpec, ...]) -> Interpretation:
    return Interpretation(
        intent="bring_me", add=options, definite=(True,) * len(options), confidence=0.92,
        reason="answers the question", answers=True,
    )  # fmt: skip


__all__ = ["Question", "read_answer", "read_question", "resolve"]
