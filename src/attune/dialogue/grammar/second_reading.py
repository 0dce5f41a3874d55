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
from attune.dialogue.grammar.requests import RequestReader
from attune.dialogue.grammar.wanted import Wanted
from attune.dialogue.interpreter import CommandIntent, Interpretation
from attune.dialogue.lexicon import Lexicon

_REASON = "the whole sentence sounds like it"
_USED_FOR = re.compile(
    r"\b(?:to (?:eat|drink|cut|spread|put|pour|stir|butter|slice|have|go) (?:\w+ )??|"
    r"for (?:my |the |our )?|with my )T\d+"
)
_DENIED = re.compile(r"\b(?:not|no|never)\b[^,.]*$")
_PUT_THERE = re.compile(r"(?:,|\b(?:go|put|place|set|leave|be|have|it|them|stand|sit))$")
_PLACE_OF_ITS_OWN = re.compile(r"(?<!T\d )(?<!T\d\d )\bP(\d+)\b")


class SecondReading:
    """Reads one utterance. Make a new one for each.

    Args:
        text: The skeleton with its corrections settled.
        sentence: The things and places in it.
        context: The situation.
        lexicon: The words of this situation.
        said: What the robot spoke of last.
    """

    def __init__(
        self, text: str, sentence: Sentence, context: Context, lexicon: Lexicon, said: Sequence[ObjectSpec]
    ) -> None:
        self._text = text
        self._sentence = sentence
        self._context = context
        self._lexicon = lexicon
        self._said = said

    def read_as(self, command: CommandIntent, cutter: ClauseCutter, confidence: float) -> Interpretation | None:
        """What it means, given its command; None when it names nothing that the command needs.

        Args:
            command: The command.
            cutter: Cuts the skeleton into clauses.
            confidence: How sure the command is, 0 to 1.
        """
        confidence = round(confidence, 2)
        if command == "other":
            reason = "the whole sentence sounds like no request"
            return Interpretation(intent="talk", confidence=confidence, reason=reason)
        if command in {"stop", "setting_breakfast"}:
            return Interpretation(intent=command, confidence=confidence, reason=_REASON)
        if command == "change_location":
            return self._moved(confidence)
        unwanted, _ = refused(cutter.cut(self._text), self._sentence.things, self._sentence.spots, self._context)
        if command == "replace_object":
            unwanted |= self._brought_already(unwanted)
        else:
            unwanted |= self._there_already(unwanted)
        wanted = self._asked_for(unwanted)
        if not wanted.add:
            return None
        replacing = command == "replace_object"
        return Interpretation(
            intent=command, add=tuple(wanted.add), definite=tuple(wanted.definite),
            remove=self._replaced(wanted, unwanted) if replacing else (),
            destination="" if replacing else wanted.destination, confidence=confidence, reason=_REASON,
        )  # fmt: skip

    def _moved(self, confidence: float) -> Interpretation | None:
        spots = self._sentence.spots
        places = [
            spots[int(match[1])].place
            for match in re.finditer(r"\bP(\d+)\b", self._text)
            if spots[int(match[1])].role != "from"
            and not cues.NEGATIVE_SPOT.search(self._text[: match.start()].rstrip())
        ]
        if not places:
            return None
        told = [
            spots[int(match[1])].place
            for match in re.finditer(r"\bP(\d+)\b", self._text)
            if spots[int(match[1])].role == "to" and not _DENIED.search(self._text[: match.start()])
        ]
        place = next((place for place in told if place in places), places[-1])
        return Interpretation(intent="change_location", destination=place, confidence=confidence, reason=_REASON)

    def _brought_already(self, unwanted: set[int]) -> set[int]:
        """Of several things, those that the robot is about: "you brought me a mug, and what I wanted is a bowl"."""
        numbers = {int(number) for number in re.findall(r"\bT(\d+)", self._text)} - unwanted
        specs = {number: self._sentence.things[number].spec for number in numbers}
        about = self._context.recent
        of_a_type = {number for number, spec in specs.items() if spec.type in {has.type for has in about}}
        described = {
            number
            for number, spec in specs.items()
            if (spec.color or spec.size)
            and any(is_described_by(replace(spec, type="", location=""), has) for has in about)
        }
        return next((old for old in (of_a_type, described) if 0 < len(old) < len(numbers)), set())

    def _there_already(self, unwanted: set[int]) -> set[int]:
        """Of several things, those that the robot is about and that are only mentioned: "a fork with that plate"."""
        numbers = {int(number) for number in re.findall(r"\bT(\d+)", self._text)} - unwanted
        things = {number: self._sentence.things[number] for number in numbers}
        old = {
            number
            for number, thing in things.items()
            if thing.definite and thing.head == "noun" and not thing.other
            and any(thing.spec.type == has.type and is_described_by(thing.spec, has) for has in self._context.recent)
        }  # fmt: skip
        return old if len(old) < len(numbers) else set()

    def _replaced(self, wanted: Wanted, unwanted: set[int]) -> tuple[ObjectSpec, ...]:
        things = [self._sentence.things[number] for number in sorted(unwanted)]
        named = tuple(thing.spec for thing in things if thing.head == "noun")
        old = object_spoken_of(self._context, wanted.add[0], self._said)
        return tuple(dict.fromkeys(spec for spec in named or ((old,) if old else ()) if spec not in wanted.add))

    def _asked_for(self, unwanted: set[int]) -> Wanted:
        """All other things of the skeleton, as if they had been asked for in plain words."""
        text, destination = self._without_destination(self._without_uses())
        parts = [
            "," if part in {".", "?"} else part
            for part in re.findall(r"\b[TP]\d+\b|\band\b|[,.?]", text)
            if part[0] != "T" or int(part[1:]) not in unwanted
        ]
        clause = Clause("wish", "want", True, "", " ".join(parts).strip(" ,"), 0)
        wanted = RequestReader(self._sentence, self._context, self._lexicon, self._said).read([clause])
        wanted.destination = wanted.destination or destination
        return wanted

    def _without_uses(self) -> str:
        """Leave out what a thing is for, unless nothing else is named: "something to drink my milk from, a glass"."""
        shorter = _USED_FOR.sub("", self._text)
        return shorter if re.search(r"\bT\d", shorter) else self._text

    def _without_destination(self, text: str) -> tuple[str, str]:
        """Take out a place that does not follow its thing at once: "the cereal, and it can go on the counter"."""
        for match in _PLACE_OF_ITS_OWN.finditer(text):
            spot = self._sentence.spots[int(match[1])]
            if spot.role == "at" and _PUT_THERE.search(text[: match.start()].rstrip()):
                return f"{text[: match.start()]}{text[match.end() :]}", spot.place
        return text, ""
