"""Answers to what the robot asked: "the red one", "yes please", "either"."""

import re
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.agreement import agreed_with_addition
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.items import Thing
from attune.dialogue.grammar.questions import Question
from attune.dialogue.grammar.references import fits, is_described_by
from attune.dialogue.grammar.remarks import NO, YES
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
_REQUEST = re.compile(r"\b(?:instead of|rather than|swap|replace|exchange|not T\d+ but)\b")
_ASKS = re.compile(
    r"(?:(?:and|but|so|well|okay|oh|,) )*(?:what|where|when|why|who|whose|how (?!about)|which (?:one )?(?:of \S+ )?"
    r"(?:is|are|was|has)|(?:do|have) (?:we|you)|(?:is|are) there|(?:is|are|was|were|does|did|has) (?:the )?[TP]\d)\b"
)
"""A question of the person's own is no answer, though it names what was offered: "what cups do you have?"."""
_ORDINAL = re.compile(
    r"^(?:(?:the|number|option|please|,|\.|yes|no|one) ?)*(?P<n>first|former|second|latter|last|one|"
    r"two)(?: (?:one|thing|option|choice|you (?:just )?(?:said|named|mentioned|offered)|please|would be .*|then|,|"
    r"\.))*$"
)
_ORDINALS = {"first": 0, "former": 0, "one": 0, "second": 1, "two": 1, "latter": -1, "last": -1}


_TWO = 2
_DENIES = re.compile(r"\b(?:no|nope|not|never|nor|neither|leave|keep|if|is|are|was)\b")
_PUT_IT = (
    r"(?:(?:(?:then|please|but|and|just|you can|could you|,) )*(?:put|bring|take|set|leave|place|have|get|make)"
    r"(?: (?:it|that|them|me|one))*(?: (?:down|over|to go))? )?"
)
_BUT_THERE = re.compile(
    rf"(?:(?:yes|please|okay|sure|right|alright|go on|of course|do|oh|well|and|but|then|i think|thanks|thank you|"
    rf"exactly|just|make it|,) )*{_PUT_IT}P(\d+)\b(?! (?:is|was|has)\b)"
)
_AND_THERE = re.compile(rf"\bT\d+(?: please)? (?:(?:,|and|but) )+(?:to go )?{_PUT_IT}P(\d+)\b")


_REFUSED = re.compile(
    r"\b(?:no|without|not (?:want |need |fancy |like )?(?:any )?) ?T(\d+)(?! instead)|"
    r"^(?:(?:no|thanks|thank you|oh|well|,) )*(?:no|thanks)(?: ,)? (?:i|we) (?:already )?(?:have|have got) T(\d+)"
)
_BRING_IT = re.compile(
    r"(?:(?:yes|please|okay|sure|go on|go ahead|why not|do|oui|then|and|of course|,) ?)+(?:go (?:and |ahead and )?)?"
    r"(?:bring|fetch|get|take)(?: (?:it|that|them|me that|me it|please|over|,))*"
    r"(?: (?:but |and )?(?:be|make it|do it|mind) (?:quick|careful|snappy|gentle|fast)| quickly| now)?"
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
        return agreed_to_the_only(question, context)
    if len(question.options) == 1 and _refuses(text, sentence, question.options[0]):
        return Interpretation(intent="deny", confidence=0.9, reason="does not want what was offered")
    if _REQUEST.search(text) or _ASKS.match(text):
        return None
    more = agreed_with_addition(text, sentence, question, lambda part: read_answer(part, sentence, question, context))
    if more is not None:
        return more
    if question.kind == "place":
        return _place_answer(text, sentence, question, context)
    there = _BUT_THERE.match(text)
    if there and len(question.options) == 1 and not re.search(r"\bT\d", text) and not _DENIES.search(text):
        spot = sentence.spots[int(there[1])]
        if spot.role in {"to", "at"}:
            return _placed(question, context, spot.place, "agrees, and says where to")
    plain = not re.search(r"\b[TP]\d+\b", text)
    if plain and NO.match(text):
        return Interpretation(intent="deny", confidence=0.9, reason="says no to the question")
    if plain and YES.match(text):
        return _agreed(question)
    options = question.options
    if not options:
        return None
    both = re.match(r"T(\d+)(?: please| thanks)*(?:$| , (?!.*(?:\b[TP]\d|\b(?:not|no|but)\b)))", text)
    if (
        both
        and len(options) > 1
        and sentence.things[int(both[1])].count == len(options)
        and sentence.things[int(both[1])].head == "one"
    ):
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
        return _chosen(tuple(dict.fromkeys(chosen)), _destination(text, sentence))
    if not things and sentence.spots and not re.search(r"\bnot P\d", text):
        place = sentence.spots[-1].place
        at_place = [option for option in options if _place_of(option, context) == place]
        return _chosen((replace(at_place[0], location=place),)) if len(at_place) == 1 else None
    if len(things) == 1 and things[0].head != "noun" and not _LEADING_NO.match(text) and not things[0].other:
        kinds = {option.type for option in options}
        if len(options) == 1:
            return _chosen((_corrected(options[0], things[0].spec),))
        if len(kinds) == 1:
            return _chosen((replace(things[0].spec, type=kinds.pop()),))
    return None


def _refuses(text: str, sentence: Sentence, offered: ObjectSpec) -> bool:
    """Whether it is refused by its name: "no milk, thanks", "I'm fine without milk", "no, I've got a plate already"."""
    refused = [match[1] or match[2] for match in _REFUSED.finditer(text)]
    things = [sentence.things[int(number)] for number in refused]
    return any(not thing.definite and is_described_by(thing.spec, offered) for thing in things)


def _is_only_named_again(thing: Thing, offered: ObjectSpec) -> bool:
    return thing.definite and thing.spec.type == offered.type and is_described_by(thing.spec, offered)


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
        if is_described_by(replace(spec, location=""), option)
        and (not spec.location or _place_of(option, context) in {"", spec.location})
    ]
    if thing.compared and not fitting:
        sized = sorted(options, key=lambda option: ("small", "", "normal", "big").index(option.size))
        fitting = [sized[-1] if spec.size == "big" else sized[0]]
    if len(fitting) > 1 and thing.other:
        return None
    return replace(fitting[0], location=fitting[0].location or spec.location) if len(fitting) == 1 else None


def _corrected(offered: ObjectSpec, said: ObjectSpec) -> ObjectSpec:
    """What was offered, but for what is said otherwise: "yes, but a blue one"."""
    return replace(
        offered, color=said.color or offered.color, size=said.size or offered.size,
        location=said.location or offered.location,
    )  # fmt: skip


def _place_of(option: ObjectSpec, context: Context) -> str:
    """Where an option is: as the question said, or as the scene knows."""
    if option.location:
        return option.location
    places = {has.location for has in context.scene if is_described_by(option, has)}
    return places.pop() if len(places) == 1 else ""


def _destination(text: str, sentence: Sentence) -> str:
    """Where the chosen one shall go: "the red one, on the counter"."""
    there = _AND_THERE.search(text)
    spot = sentence.spots[int(there[1])] if there else None
    return spot.place if spot and spot.role in {"to", "at"} else ""


def _placed(question: Question, context: Context, place: str, reason: str) -> Interpretation:
    """A place for what was asked about: another one if the robot is about it, else it is brought there."""
    recent = context.recent
    if not question.options or any(has.type == o.type and fits(o, has) for o in question.options for has in recent):
        return Interpretation(intent="change_location", destination=place, confidence=0.9, reason=reason)
    options = tuple(replace(o, location="") if o.location in question.places else o for o in question.options)
    return replace(_chosen(options, place), reason=reason)


def _place_answer(  # noqa: PLR0911 - one rule per return
    text: str, sentence: Sentence, question: Question, context: Context
) -> Interpretation | None:
    places = [spot.place for number, spot in enumerate(sentence.spots) if f"P{number}" in text.split()]
    if len(places) == 1 and not any(f"T{number}" in text.split() for number in range(len(sentence.things))):
        return _placed(question, context, places[0], "names the place asked for")
    named = [thing for number, thing in enumerate(sentence.things) if f"T{number}" in text.split()]
    agrees = _LEADING_YES.match(text) and not _DENIES.search(text)
    if agrees and not places and named and len(question.options) == len(question.places) == 1:
        again = all(_is_only_named_again(thing, question.options[0]) for thing in named)
        return _placed(question, context, question.places[0], "agrees to the place") if again else None
    if places or named:
        return None
    if NO.match(text):
        return Interpretation(intent="deny", confidence=0.9, reason="says no to the question")
    if (YES.match(text) and len(question.places) == 1) or (_ANY.search(text) and question.places):
        return _placed(question, context, question.places[0], "agrees to the place")
    ordinal = _ORDINAL.match(text)
    if ordinal and len(question.places) > 1:
        return _placed(question, context, question.places[_ORDINALS[ordinal["n"]]], "chooses a place")
    return None


def agreed_to_the_only(question: Question, context: Context) -> Interpretation:
    """The only thing that was offered, with the place that was asked about."""
    if question.kind == "place" and len(question.places) == 1:
        return _placed(question, context, question.places[0], "agrees to the place")
    return _chosen(question.options)


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


def _chosen(options: tuple[ObjectSpec, ...], destination: str = "") -> Interpretation:
    return Interpretation(
        intent="bring_me", add=options, definite=(True,) * len(options), destination=destination, confidence=0.92,
        reason="answers the question", answers=True,
    )  # fmt: skip
