"""Reads the slots of an utterance when its command is already known, whatever words it is asked with."""

import re
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import cues
from attune.dialogue.grammar.clauses import Clause, ClauseCutter, Sentence
from attune.dialogue.grammar.polarity import refused
from attune.dialogue.grammar.references import is_described_by, object_spoken_of
from attune.dialogue.grammar.requests import RequestReader, Wanted
from attune.dialogue.interpreter import CommandIntent, Interpretation
from attune.dialogue.lexicon import Lexicon

_REASON = "the whole sentence sounds like it"
_USED_FOR = re.compile(
    r"\b(?:to (?:eat|drink|cut|spread|put|pour|stir|butter|slice|have|go) (?:\w+ )??|for (?:my |the |our )?|with my )T\d+"
)
_PUT_THERE = re.compile(r"(?:,|\b(?:go|put|place|set|leave|be|have|it|them|stand|sit))$")


def read_as(
    command: CommandIntent, text: str, sentence: Sentence, context: Context, lexicon: Lexicon, cutter: ClauseCutter,
    said: Sequence[ObjectSpec], confidence: float,
) -> Interpretation | None:  # fmt: skip
    """What a skeleton means, given its command.

    Args:
        text: The skeleton with its corrections settled; `sentence` holds its things and places.

    Returns:
        None when it names nothing that the command needs.
    """
    if command == "other":
        return Interpretation(intent="talk", confidence=confidence, reason="the whole sentence sounds like no request")
    if command in {"stop", "setting_breakfast"}:
        return Interpretation(intent=command, confidence=confidence, reason=_REASON)
    negative, _ = refused(cutter.cut(text), sentence.things, sentence.spots, context)
    if command == "change_location":
        places = [
            sentence.spots[int(match[1])].place
            for match in re.finditer(r"\bP(\d+)\b", text)
            if sentence.spots[int(match[1])].role != "from" and not cues.NEGATIVE_SPOT.search(text[: match.start()].rstrip())
        ]
        if not places:
            return None
        return Interpretation(
            intent="change_location", destination=places[-1], confidence=confidence, reason=_REASON
        )
    if command == "replace_object":
        negative |= _brought_already(text, sentence, context, negative)
    wanted = _asked_for(_without_uses(text), negative, sentence, context, lexicon, said)
    if not wanted.add:
        return None
    if command == "bring_me":
        return Interpretation(
            intent="bring_me", add=tuple(wanted.add), definite=tuple(wanted.definite), destination=wanted.destination,
            confidence=confidence, reason=_REASON,
        )  # fmt: skip
    named = [sentence.things[number].spec for number in sorted(negative) if sentence.things[number].head == "noun"]
    old = object_spoken_of(context, wanted.add[0], said)
    remove = tuple(named) or ((old,) if old else ())
    return Interpretation(
        intent="replace_object", add=tuple(wanted.add), remove=tuple(spec for spec in remove if spec not in wanted.add),
        confidence=confidence, reason=_REASON,
    )  # fmt: skip


def _without_uses(text: str) -> str:
    """Leave out what a thing is for, unless nothing else is named: "something to drink my milk from, a glass"."""
    shorter = _USED_FOR.sub("", text)
    return shorter if re.search(r"\bT\d", shorter) else text


def _brought_already(text: str, sentence: Sentence, context: Context, negative: set[int]) -> set[int]:
    """Of several things, those that the robot is about: "you brought me a mug, and what I wanted is a bowl"."""
    numbers = [int(number) for number in re.findall(r"\bT(\d+)", text) if int(number) not in negative]
    specs = {number: sentence.things[number].spec for number in numbers}
    by_type = {n for n, spec in specs.items() if spec.type in {has.type for has in context.recent}}
    described = {
        n for n, spec in specs.items()
        if (spec.color or spec.size) and any(is_described_by(replace(spec, type="", location=""), has) for has in context.recent)
    }  # fmt: skip
    for old in (by_type, described):
        if 0 < len(old) < len(numbers):
            return old
    return set()


def _asked_for(
    text: str, negative: set[int], sentence: Sentence, context: Context, lexicon: Lexicon, said: Sequence[ObjectSpec]
) -> Wanted:
    """All things of a skeleton but the refused ones, as if they had been asked for in plain words."""
    put_there = ""
    for match in re.finditer(r"(?<!T\d )(?<!T\d\d )\bP(\d+)\b", text):
        spot = sentence.spots[int(match[1])]
        if spot.role == "at" and _PUT_THERE.search(text[: match.start()].rstrip()):
            put_there = spot.place
            text = f"{text[: match.start()]}{text[match.end() :]}"
            break
    parts = [part for part in re.findall(r"\b[TP]\d+\b|\band\b|[,.?]", text) if part[0] != "T" or int(part[1:]) not in negative]
    body = " ".join("," if part in {".", "?"} else part for part in parts).strip(" ,")
    clause = Clause("fetch", "bring", True, "", body, 0)
    wanted = RequestReader(sentence, context, lexicon, said).read([clause])
    wanted.destination = wanted.destination or put_there
    return wanted
