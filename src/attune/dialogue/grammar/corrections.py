"""Self-correction and apposition: "the red, no, the blue cup" is one thing, "a bowl, a white one" too."""

import re
from dataclasses import replace

from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.items import Spot, Thing, described

_STRONG = (
    r"(?:no|nope|sorry|wait|i mean|i meant|i meant to say|or rather|actually|make that|make it|correction|oops|"
    r"whoops|"
    r"scratch that|or better|better|pardon|on second thoughts?|not that|forget that|what am i saying|excuse me|"
    r"i should say|"
    r"rather|i wanted to say|my mistake|silly me|no no|let me correct that|that is wrong|make them|i misspoke|"
    r"apologies)"
)
_WEAK = (
    r"(?:[,.?]|oh|ach|och|please|yes|just|well|hold on|hang on|let me see|let us see|i think|that is|what is it called|"
    r"the|ah|or|so|"
    r"okay|god|dear|would be|maybe|now|a moment|hmm|say|like|you know|not|it|is|was|to be|of course|i want|i need|"
    r"i would like)"
)
MARKER = rf"(?:(?: {_WEAK})*? {_STRONG}(?: (?:{_WEAK}|{_STRONG}))*?)"
_UNKNOWN_CORRECTED = re.compile(rf"\b(?:the|a|an|my|some) (?!T\d|P\d)[a-z]+{MARKER} (?=T\d)")
_THING = re.compile(rf"\bT(\d+)((?: P\d+)*){MARKER} T(\d+)\b")
_SPOT = re.compile(rf"\bP(\d+){MARKER} P(\d+)\b")
_TRAILING = re.compile(r"\bT(\d+)((?: P\d+)*) (?:, )?(?:or )?T(\d+) i mean\b")
_AFTERWARDS = re.compile(rf"\bT(\d+)((?: (?:P\d+|please|for me|thanks|[,.]))*){MARKER} (?:in |a )?T(\d+)\b")
_APPOSITION = re.compile(
    r"\bT(\d+)((?: P\d+)*)(?: please)? (?:[,.]|(?:(?:, |\. )?(?:it|that|which|they|and it) )?(?:should|must|"
    r"has to|have to|needs to|"
    r"ought to) be)(?: (?:preferably|if possible|maybe|ideally|perhaps|but|i mean|namely|specifically|please|is|a|"
    r"it is|,))* "
    r"T(\d+)\b"
)
_AND_PROPERTY = re.compile(r"\bT(\d+) (?:and|,|and also) T(\d+)\b")
_NOT_PROPERTY = re.compile(r"\b(T\d+) (?:that|which) (?:is|are) not T(\d+)\b")
_NEGATED_BEFORE = re.compile(
    r"(?:\bnot|instead of|rather than|in place of|do not (?:want|need)|\bforget|\bwrong|\bno)$"
)


def settle(sentence: Sentence, text: str) -> tuple[Sentence, str, bool]:
    """Merge what was corrected or described twice. Says whether anything was corrected."""
    things, spots = list(sentence.things), list(sentence.spots)
    text = _UNKNOWN_CORRECTED.sub("", text)
    corrected = False
    for pattern in (_TRAILING, _THING, _AFTERWARDS):
        while (match := pattern.search(text)) and not _NEGATED_BEFORE.search(text[: match.start()].rstrip()):
            first, second = int(match[1]), int(match[3])
            merged = _described(things[first], things[second]) if pattern is _TRAILING else None
            things[second] = merged or corrected_thing(things[first], things[second])
            text = f"{text[: match.start()]}T{second}{match[2]}{text[match.end() :]}"
            corrected = True
    while (match := _SPOT.search(text)) and not _NEGATED_BEFORE.search(text[: match.start()].rstrip()):
        first, second = int(match[1]), int(match[2])
        spots[second] = _corrected_spot(spots[first], spots[second])
        text = f"{text[: match.start()]}P{second}{text[match.end() :]}"
        corrected = True
    text = _NOT_PROPERTY.sub(r"\1", text)
    for match in re.finditer(r"\bP(\d+) , P(\d+)\b", text):
        if spots[int(match[1])].role == spots[int(match[2])].role == "from":
            text = text.replace(match[0], f"P{match[2]}", 1)  # "from the cabinet, er, from the fridge"
    position = 0
    while match := _APPOSITION.search(text, position):
        first, second = int(match[1]), int(match[3])
        merged = _described(things[first], things[second])
        if merged is None or _NEGATED_BEFORE.search(text[: match.start()].rstrip()):
            position = match.start() + 1
            continue
        things[first] = merged
        text = f"{text[: match.start()]}T{first}{match[2]}{text[match.end() :]}"
        more = _AND_PROPERTY.match(text, match.start())
        if more and things[int(more[2])].head == "bare" and not things[int(more[2])].article:
            things[first] = _described(merged, things[int(more[2])]) or merged
            text = f"{text[: match.start()]}T{first}{text[more.end() :]}"
    return Sentence(sentence.skeleton, tuple(things), tuple(spots)), text, corrected


def corrected_thing(first: Thing, second: Thing) -> Thing:
    """What is meant after "first, no, second": a noun with its own article replaces, all else only overwrites."""
    a, b = first.spec, second.spec
    if (
        second.head == "noun"
        and (second.article or b.color or b.size)
        and first.head == "noun"
        and not (not second.article and b.type == a.type)
    ):
        if second.article:
            return replace(second, spec=replace(b, location=b.location or a.location))
        spec = described(b.type, b.color or a.color, b.size or a.size, b.location or a.location)
        return replace(second, spec=spec)
    if second.head == "noun" and second.article:
        return replace(second, spec=replace(b, location=b.location or a.location))
    spec = described(b.type or a.type, b.color or a.color, b.size or a.size, b.location or a.location)
    head = "noun" if spec.type else second.head
    return replace(second, spec=spec, head=head, definite=second.definite or first.definite, compared=False)


def _corrected_spot(first: Spot, second: Spot) -> Spot:
    return second if second.role and second.role != "at" else replace(second, role=first.role or second.role)


def _described(first: Thing, second: Thing) -> Thing | None:
    """One thing that is described twice, or None if these are two."""
    pointing = first.head == "one" and second.head == "bare"
    noun, other = (first, second) if first.head == "noun" or pointing else (second, first)
    if (
        (noun.head != "noun" and not pointing)
        or other.head == "noun"
        or second.another
        or second.other
        or second.ordinal
    ):
        return None
    if (noun.spec.color and other.spec.color) or (noun.spec.size and other.spec.size):
        return None
    spec = replace(
        noun.spec,
        color=noun.spec.color or other.spec.color,
        size=noun.spec.size or other.spec.size,
        location=noun.spec.location or other.spec.location,
    )
    return replace(noun, spec=spec, compared=other.compared or noun.compared)
