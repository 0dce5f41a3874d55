"""Which of the places that are named are where things shall go, and which are where they are."""

import re
from collections.abc import Sequence
from dataclasses import replace

from attune.dialogue.context import Context
from attune.dialogue.grammar import frames
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.corrections import settle
from attune.dialogue.grammar.items import Spot
from attune.dialogue.grammar.mentions import without_mentions

_IT = r"(?:it|that|this|them|they|these|those)"
_OBJECT = rf"(?:T\d+|{_IT})(?:(?: and| , and| ,) T\d+)*"
_WAY = r"(?: (?:back|away|down|up|over|out|straight|carefully|right|gently|neatly|please|safely|just))*"
_PUT = (
    r"(?:put|place|set|stand|leave|lay|pop|stick|drop|stack|stow|shove|sit|slide|tidy|store|stash|chuck|tuck|park|"
    r"plonk|slip|sling|lob|bung|whack|load|file|return|pile|line up|shift|tidy away|put away|bang|dump|toss|deposit)"
)
_GOES = (
    r"(?:goes|go|belongs?|(?:wants?|needs?) (?:putting|to go|to be put|to be|tidying|stacking|returning)|"
    r"(?:should|must|can|could|may|might|will|has to|have to|is to|ought to) "
    r"(?:go|be put|be placed|be stored|be returned))"
)
_PUT_THERE = re.compile(rf"\b{_PUT} {_OBJECT}{_WAY} P(\d+)\b")
_GOES_THERE = re.compile(rf"\b(?:T\d+|{_IT}){_WAY} {_GOES}{_WAY} P(\d+)\b")
_WITH_IT = re.compile(rf"(?:^|(?<=[,.] )|(?<=back )|(?<=away )|(?<=off )|(?<=so ))P(\d+) with {_OBJECT}(?= |$)")
_SEE_TO_IT = re.compile(rf"\b(?:see(?: to it)? that|make sure(?: that)?) {_OBJECT} (?:is|are|gets?) (?:\w+ )??P(\d+)\b")
_INTO_IT = re.compile(
    rf"\bP(\d+)(?P<between> (?!T|P).*?\b(?:{_PUT}|add) T\d+){_WAY} (?:(?:in|into|onto|on)(?: it| there)?|to it)"
    r"(?= *(?:[.,?]|$|please))"
)
_WISHED = re.compile(
    r"(?:\b(?:want|need|like|love|have|with)(?: to (?:have|see))?) (?:T\d+(?: and| ,) )*T\d+ (?:out |over )?P(\d+)\b"
)
_ASKED_FOR = re.compile(r"\b(?:i|we) (?:\w+ )?(?:want|need|like|love)\b")
_NAMED = re.compile(
    rf"(?:^|(?<=\. ))(?:(?:and|so|now|then|oh|okay|right|please|,|\.) )*T\d+(?:(?: and| ,) T\d+)*(?: as well| too)?"
    rf"(?: ,)?{_WAY} P(\d+)(?= (?:[.,]|please|when)|$)"
)
_NAMED_AFTER = re.compile(r"^(?:(?:and|so|now|then|okay|right|please|back|,|\.) )*P(\d+) please , T\d+\b")
_FETCHED = re.compile(r"\b(?:bring|fetch|get|hand|pass|give|grab|take|(?:can|could|may) (?:i|we) have)\b")
_TO_LOOK = (
    r"(?:go|nip|pop|dash|head|steer(?: yourself)?|proceed|run|walk|trundle|wander|whizz|roll|hop|march|"
    r"(?:a )?(?:rummage|look|peek|pit stop|dig|search|stop)|rummage|look|check|search|dig)"
)
_LOOKED_IN = re.compile(
    rf"\b{_TO_LOOK}(?: (?:over|up|down|across|along|back|straight|deep))* "
    r"P(\d+)(?P<between> (?:for|and|,)(?: (?!P\d|T\d|on\b|in\b)[\w',]+){0,5}? T\d+)(?! P\d)"
)
_FROM_IT = re.compile(r"\bP(\d+)(?P<between>\b.*\bT\d+)(?: \w+){0,2}? (?:from|out of|off) (?:it|there)\b")
_OUT_OF = re.compile(r"\b(?:from|out of|of)(?: (?:the|a|an|my|our))?(?: (?!T\d|P\d)\w+)?$")
_THERE_IS = re.compile(r"\bP(\d+) (?:there|you) (?:is|are|should be|will find|will see) T\d+")
_IT_IS = re.compile(
    r"\b(?:it|they) (?:is|are|should be|must be|will be|might be|sits?|stands?|lives?)"
    r"(?: (?:standing|sitting|lying|still|probably|just|over|up|out|now))* P(\d+)\b|"
    r"\b(?:i|you|we) (?:have )?(?:left|put|saw|keep|kept) (?:it|them) P(\d+)\b"
)
_FOUND_THERE = re.compile(rf"\b(?:find|spot|look for) {_OBJECT} P(\d+) and\b")
_PASSING = re.compile(
    r"\b(?:while|since|as|if|when) you are (?:going |passing |driving )?(?:past |by |near )?P(\d+)\b|"
    r"\bgoing past P(\d+)\b"
)
_AND_ITS_PLACE = re.compile(
    r"^(?:(?!T\d|P\d|put\b)\S+ ){0,4}?T(\d+)(?: please)?(?: [,.])? P(\d+)(?= (?:[,.]|by\b)|$)(?!.*\bbefore\b)"
)
_SURFACES = frozenset({"table", "countertop"})


def where_it_goes(text: str, sentence: Sentence) -> set[int]:
    """The numbers of the places where something shall be put, whatever the preposition.

    Args:
        text: The skeleton.
        sentence: The things and places in it.
    """
    spots = sentence.spots
    found = {
        int(match[1])
        for pattern in (_PUT_THERE, _GOES_THERE, _WITH_IT, _SEE_TO_IT, _INTO_IT)
        for match in pattern.finditer(text)
    }
    found |= {
        int(match[1])
        for match in _WISHED.finditer(text)
        if spots[int(match[1])].place in _SURFACES and not _tells_which(int(match[1]), sentence)
    }
    if not _FETCHED.search(text) and not _ASKED_FOR.search(text):
        named = (pattern.search(text) for pattern in (_NAMED, _NAMED_AFTER))
        found |= {int(match[1]) for match in named if match and spots[int(match[1])].role == "at"}
    return {number for number in found if spots[number].role != "from"}


def settled_with_roles(sentence: Sentence, text: str, context: Context) -> tuple[Sentence, str]:
    """A sentence as it is read: corrected, without asides and mere mentions, with the part that each place plays."""
    settled, text, _ = settle(sentence, frames.without_asides(text))
    return _with_roles(settled, without_mentions(text, settled, context))


def _tells_which(number: int, sentence: Sentence) -> bool:
    """Whether a place tells which one is meant: "the one on the table"."""
    described = re.search(rf"\bT(\d+) P{number}\b", sentence.skeleton)
    thing = sentence.things[int(described[1])] if described else None
    return thing is not None and thing.head == "one" and not (thing.spec.color or thing.spec.size)


def where_it_is(text: str, spots: Sequence[Spot]) -> set[int]:
    """The numbers of the places where something is to be fetched, though no "from" says so."""
    found = {int(match[1]) for pattern in (_LOOKED_IN, _FROM_IT, _FOUND_THERE) for match in pattern.finditer(text)}
    if _FETCHED.search(text) or re.search(r"\b(?:want|need|please)\b", text):
        for pattern in (_THERE_IS, _IT_IS):
            found |= {int(match[1] or match[match.lastindex or 1]) for match in pattern.finditer(text)}
    for match in re.finditer(r"\bP(\d+)\b", text):
        if spots[int(match[1])].role == "" and _OUT_OF.search(text[: match.start()].rstrip()):
            found.add(int(match[1]))
    return found


def _is_named_as_its_place(text: str, sentence: Sentence) -> set[int]:
    """The place in "spoon please, drawer by the sink": who wants something put away speaks of a certain thing."""
    named = _AND_ITS_PLACE.search(text)
    if named is None:
        return set()
    thing, spot = sentence.things[int(named[1])], sentence.spots[int(named[2])]
    inside = spot.role == "" and spot.place in {"fridge", "drawer", "cabinet", "shelf"}
    return {int(named[2])} if inside and not thing.definite and thing.head == "noun" else set()


def _with_roles(sentence: Sentence, text: str) -> tuple[Sentence, str]:
    """The sentence with the part that each of its places plays, and the text without places that play none."""
    if not sentence.spots:
        return sentence, text
    spots = list(sentence.spots)
    goes = where_it_goes(text, sentence)
    for number in (where_it_is(text, spots) | _is_named_as_its_place(text, sentence)) - goes:
        spots[number] = replace(spots[number], role="from")
    for number in goes:
        spots[number] = replace(spots[number], role="to")
    for pattern in (_INTO_IT, _FROM_IT, _LOOKED_IN):  # "it" is the place named before
        text = pattern.sub(r"\g<between> P\1", text)
    return replace(sentence, spots=tuple(spots)), " ".join(_PASSING.sub(" ", text).split())
