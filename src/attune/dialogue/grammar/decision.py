"""From what is wanted to one command: another place, another thing, one thing less, or something to bring."""

import re
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import frames
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.references import fits, object_spoken_of, resolve
from attune.dialogue.grammar.wanted import Wanted, same_request
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.lexicon import Lexicon
from attune.dialogue.words import words

_UNKNOWN_PLACE = re.compile(
    r"\bT\d+(?: please| over| down| back)? (?:to|into|onto) (?:the|my|our) (?P<to>(?!T\d|P\d)[a-z]+(?: room)?)\b|"
    r"\b(?:put|place|set|leave|lay|stick|pop|stand|drop|store) T\d+ (?:in|on|under|behind|beside|next to) "
    r"(?:the|my|our) (?P<at>(?!T\d|P\d)[a-z]+(?: room)?)\b"
)
_ONLY = re.compile(r"\b(?:only|just|alone|is enough|will do)\b")
_NO_PLACES = words(
    "morning evening afternoon night day weekend way double moment meantime end middle minute side left right top back "
    "front house kitchen place spot usual same corner lady man guest guests family girl boy old other one very next "
    "first last wife husband boss patient others person people visitors seat"
)


def just_spoken_of(wanted: Wanted, context: Context, said: Sequence[ObjectSpec]) -> Interpretation | None:
    """Read "bring it" after the robot has spoken of one thing that it is not about: "yes, some juice in the fridge"."""
    new = [spec for spec in dict.fromkeys(said) if not any(spec.type == has.type for has in context.recent)]
    if not (wanted.pronoun and wanted.asked and len(new) == 1) or wanted.add or wanted.remove or wanted.moves:
        return None
    return Interpretation(
        intent="bring_me", add=(replace(new[0], location=""),), definite=(True,), destination=wanted.destination,
        confidence=0.85, reason="asks for what the robot has just spoken of",
    )  # fmt: skip


def pointed_at(text: str, sentence: Sentence, context: Context, said: Sequence[ObjectSpec]) -> tuple[ObjectSpec, ...]:
    """What a question points at: "do you have a blue one?"; the type stays open where nothing was named before."""
    things = (sentence.things[int(number)] for number in re.findall(r"\bT(\d+)\b", text))
    return tuple(resolve(thing, context, (), said) or thing.spec for thing in things if thing.head == "one")


def elsewhere(wanted: Wanted, text: str, lexicon: Lexicon) -> Interpretation | None:
    """A thing shall go where the robot does not know a place: that is asked back, not brought somewhere else."""
    named = _UNKNOWN_PLACE.search(text)
    if named is None or wanted.destination or not (wanted.asked and wanted.add):
        return None
    place = named["to"] or named["at"]
    if place in _NO_PLACES | lexicon.others:
        return None
    reason = "names a place it does not know"
    return Interpretation(intent="unknown_object", unknown=place, confidence=0.7, reason=reason)


def answering(meaning: Interpretation, options: Sequence[ObjectSpec], context: Context) -> Interpretation:
    """After a question, "not the plate, the spoon" replaces nothing: the plate was only offered."""
    refused = meaning.remove and all(any(fits(spec, option) for option in options) for spec in meaning.remove)
    if meaning.intent != "replace_object" or not refused or any(spec in context.recent for spec in meaning.remove):
        return meaning
    return replace(meaning, intent="bring_me", remove=(), reason="wants something other than what was offered")


def is_of_the_kind(meaning: Interpretation, context: Context) -> bool:
    """Whether what is wanted after "wait" is of the kind that the robot is about: then it is that which was wrong."""
    about = {spec.type for spec in context.recent}
    return meaning.intent == "bring_me" and len(meaning.add) == 1 and meaning.add[0].type in about


def instead_of_given_up(
    meaning: Interpretation, text: str, context: Context, said: tuple[ObjectSpec, ...]
) -> Interpretation:
    """Read "cancel that, I'll have juice": what the robot was about is given up for what is wanted now."""
    if meaning.intent != "bring_me" or context.task is None or frames.ADDITIVE.search(text):
        return meaning
    old = object_spoken_of(context, meaning.add[0], said)
    return replace(meaning, intent="replace_object", remove=(old,)) if old and old not in meaning.add else meaning


def left_out(meaning: Interpretation, text: str, context: Context) -> Interpretation:
    """Read "forget the juice, I only need the glass" while both are fetched: nothing replaces the juice."""
    if meaning.intent != "replace_object" or not meaning.remove or not _ONLY.search(text):
        return meaning
    objects = context.task.objects if context.task else ()
    if not all(same_request(spec, objects) for spec in (*meaning.add, *meaning.remove)):
        return meaning
    reason = "wants only some of several things"
    return Interpretation(intent="cancel_object", remove=meaning.remove, confidence=meaning.confidence, reason=reason)


def decide(wanted: Wanted, text: str, context: Context, said: tuple[ObjectSpec, ...]) -> Interpretation | None:  # noqa: PLR0911 - one rule per return
    """The command that is wanted, or None."""
    additive = frames.ADDITIVE.search(text) is not None and not re.search(r"\binstead\b", text)
    add, remove = tuple(wanted.add), tuple(dict.fromkeys(wanted.remove))
    confidence = 0.95 if wanted.framed else 0.9 if wanted.asked else 0.75
    moving = (
        wanted.destination
        and not remove
        and (not add or _is_moving(wanted, context, additive))
        and (wanted.moves or wanted.pronoun or context.busy)
    )
    if moving:
        on_the_way = context.task.objects if context.task else ()
        some = add if len(on_the_way) > len(add) else ()
        return Interpretation(
            intent="change_location", add=some, destination=wanted.destination, confidence=confidence,
            reason="names another place",
        )  # fmt: skip
    if add and remove:
        remove = tuple(spec for spec in remove if spec not in add) or remove
        return _replacing(wanted, add, remove, confidence, "wants one thing instead of another")
    if remove and not add:
        back = re.search(r"\bT\d+ (?:back|away)\b|\breturn T\d+|\b(?:put|take|bring|carry) (?:back|away) T\d+", text)
        if back:
            return Interpretation(intent="put_back", remove=remove, confidence=0.85, reason="wants something put back")
        return Interpretation(
            intent="cancel_object", remove=remove, confidence=0.85, reason="does not want something any more"
        )
    if not add:
        return None
    if not additive:
        instead = re.search(r"\binstead\b|\bin its place\b|\bin place of (?:it|that|this)\b", text) is not None
        corrects = instead or wanted.contrast or (context.busy and _corrects(wanted, text))
        if corrects:
            spoken_of = object_spoken_of(context, add[0], said)
            old = (spoken_of,) if spoken_of is not None and spoken_of != add[0] else ()
            if old or instead or wanted.contrast:
                return _replacing(wanted, add, old, confidence, "corrects what was wanted")
    return Interpretation(
        intent="bring_me", add=add, definite=tuple(wanted.definite), destination=wanted.destination,
        unknown=wanted.unknown, confidence=confidence, reason="asks for objects",
    )  # fmt: skip


def _corrects(wanted: Wanted, text: str) -> bool:
    if frames.CORRECTION.search(text) or wanted.indirect:
        return True
    return re.fullmatch(
        r"(?:please |, |robot |oh )*(?:i (?:want|would like|need|would prefer) )?T\d+(?: please| ,| \.|!| \?)*", text
    ) is not None and (len(wanted.add) == 1 and wanted.definite[:1] == [True] and not wanted.asked and wanted.indirect)


def _is_moving(wanted: Wanted, context: Context, additive: bool) -> bool:
    """Whether the objects named with a place are those the robot is about already."""
    if additive or not (wanted.asked or wanted.moves) or not context.busy:
        return False
    about = context.recent
    return all(definite for definite in wanted.definite) and all(
        not spec.location and same_request(spec, about) for spec in wanted.add
    )


def _replacing(
    wanted: Wanted, add: tuple[ObjectSpec, ...], remove: tuple[ObjectSpec, ...], confidence: float, reason: str
) -> Interpretation:
    return Interpretation(
        intent="replace_object", add=add, remove=remove, destination=wanted.destination,
        definite=tuple(wanted.definite), confidence=confidence, reason=reason,
    )  # fmt: skip
