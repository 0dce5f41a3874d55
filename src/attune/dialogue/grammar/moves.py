"""Where what the robot is about shall go: "put the cup on the shelf", "the spoon goes on the table"."""

import re
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import cues, frames
from attune.dialogue.grammar.clauses import Clause, Sentence
from attune.dialogue.grammar.items import Role, Thing
from attune.dialogue.grammar.references import fits
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.words import words

NAMED = 0.97
"""The rules' confidence where what is on its way is named: it is not asked for anew, and nobody else is told."""

_ONE_MORE = re.compile(
    r"\b(?:too(?! \w+ (?:for|to)\b)|as well|aswell|also|another|more|in addition|additionally|extra|plus|besides|"
    r"along with|together with)\b"
)
_NOT_THIS = re.compile(r"\b(?:instead of|rather than|forget(?: about)?|skip|without|prefer|swap|replace|exchange) T\d")
_IT = r"(?:it|that|this|them|they|these|those)"
_OBJECT = rf"(?:T\d+|{_IT}(?: T\d+)?)(?: and T\d+)*"
_SOON = r"((?: (?!T\d|is |are |was |were |because |if |so |i |we |when |and |but )[\w']+){0,4}?) P(\d+)\b"
_HANDLED = re.compile(rf"(?:(?:me|us|over|please|just|back|down|off|,) )*{_OBJECT}{_SOON}")
_LEAD = (
    r"(?:^|(?<=[,.] ))(?:(?:actually|no|oh|okay|sorry|wait|well|so|now|and|but|then|please|yes|hey|"
    r"on second thoughts?|or|rather|instead|after all|,) )*"
)
_GOES = re.compile(
    rf"{_LEAD}(?:{_OBJECT}(?: (?:should|can|could|must|may|might|will|would|has to|have to|needs? to|wants to|better|"
    r"is to|are to|is supposed to))?(?: (?:just|also|all|really|rather|now|please|actually|better))* "
    r"(?:goes|go|belongs?|be (?:put|placed|set|brought|taken|delivered|left|carried|stood|served))|"
    rf"let {_OBJECT} (?:go|stand|sit)){_SOON}"
)
_WITH_IT = re.compile(rf"{_LEAD}(?:(?:off|straight|over|back|away) )*(?=P)()P(\d+) with {_OBJECT}(?= |$)(?! P)")
_AFTER = r"(?: (?:please|instead|after all|now|then|actually|thanks|rather|over there|,))*"
_TO_PLACE = re.compile(rf"{_LEAD}T\d+(?: (?:over|back|straight|right))*()(?= P) P(\d+){_AFTER}(?: *$| , )")
_RATHER_THERE = re.compile(
    r"^(?:(?:no|oh|sorry|wait|well|or|,) )*(?:actually|on second thoughts?|rather|no)(?: ,)? "
    rf"()P(\d+){_AFTER}(?: *$| , )"
)
_LET_GO = words("leave drop")
_ROLES: dict[str, frozenset[Role]] = {
    "put": frozenset({"to", "at", ""}), "drop": frozenset({"to", "at", ""}), "fetch": frozenset({"to", ""}),
    "wish": frozenset({"to", "at"}),
}  # fmt: skip


def moved(text: str, clauses: Sequence[Clause], sentence: Sentence, context: Context) -> Interpretation | None:
    """Read where what is on its way shall go, if an utterance names nothing else.

    Args:
        text: The skeleton with its corrections settled.
        clauses: Its clauses.
        sentence: The things and places in it.
        context: The situation.
    """
    on_the_way = _on_the_way(context)
    if not on_the_way or _ONE_MORE.search(text) or _NOT_THIS.search(text) or frames.PAST.search(text):
        return None
    if frames.QUESTION.match(text):
        return None
    numbers = list(dict.fromkeys(int(number) for number in re.findall(r"\bT(\d+)", text)))
    meant = [_meant(sentence.things[number], on_the_way) for number in numbers]
    if not all(meant):
        return None
    place = _place(text, clauses, sentence, context, named=bool(numbers))
    if not place:
        return None
    objects = tuple(dict.fromkeys(spec for specs in meant for spec in specs))
    everything = all(any(spec.type == has.type and fits(spec, has) for spec in objects) for has in on_the_way)
    return Interpretation(
        intent="change_location", add=() if everything else objects, destination=place,
        confidence=NAMED if objects else 0.9, reason="says where that shall go",
    )  # fmt: skip


def _on_the_way(context: Context) -> tuple[ObjectSpec, ...]:
    task = context.task.objects if context.task else ()
    held = (context.carrying,) if context.carrying and context.carrying not in task else ()
    return (*held, *task)


def _meant(thing: Thing, on_the_way: Sequence[ObjectSpec]) -> tuple[ObjectSpec, ...]:
    """What a noun phrase means of what is on its way; nothing if it may mean something else."""
    if thing.another or thing.other or thing.different or thing.compared or thing.ordinal or thing.unknown:
        return ()
    if thing.head == "noun":
        new = (thing.article and not thing.definite) or thing.spec.location
        same = any(thing.spec.type == has.type and fits(thing.spec, has) for has in on_the_way)
        return (thing.spec,) if same and not new else ()
    if thing.count > 1:
        return tuple(on_the_way) if thing.count == len(on_the_way) else ()
    fitting = [has for has in on_the_way if fits(thing.spec, has)]
    named = thing.definite and (thing.spec.color or thing.spec.size)
    return (replace(fitting[0], location=""),) if named and len(fitting) == 1 else ()


def _place(text: str, clauses: Sequence[Clause], sentence: Sentence, context: Context, *, named: bool) -> str:
    """The place said last as one where to put it."""
    for clause in reversed(clauses if named else ()):
        roles = _ROLES.get(clause.kind)
        if roles is None or (clause.kind == "drop" and clause.verb.split()[0] not in _LET_GO):
            continue
        found = _HANDLED.match(clause.body)
        place = _there(found, sentence, roles)
        stays = clause.kind == "wish" or clause.verb in {"leave", "keep"}
        if place and not (stays and _is_there(place, sentence, context)):
            return place
    for pattern in (_GOES, _WITH_IT):
        if place := _there(pattern.search(text), sentence, _ROLES["put"]):
            return place
    if named:
        return _there(_TO_PLACE.search(text), sentence, frozenset({"to"}))
    return _there(_RATHER_THERE.search(text), sentence, _ROLES["put"])


def _there(found: re.Match[str] | None, sentence: Sentence, roles: frozenset[Role]) -> str:
    if found is None or cues.NEGATIVE_SPOT.search(found[1].rstrip()):
        return ""
    spot = sentence.spots[int(found[2])]
    return spot.place if spot.role in roles else ""


def _is_there(place: str, sentence: Sentence, context: Context) -> bool:
    """Whether a thing named stands at a place already: then it is left there, or described by it."""
    if context.carrying is not None:
        return False
    named = [thing.spec for thing in sentence.things if thing.head == "noun"]
    return any(
        has.location == place and has.type == spec.type and fits(spec, has) for has in context.scene for spec in named
    )
