"""Cuts an utterance into clauses, each with what it asks for: fetching, putting, wishing, or nothing."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from attune.dialogue.grammar import frames
from attune.dialogue.grammar.items import Item, Spot, Thing, Word
from attune.dialogue.lexicon import Lexicon

Called = Literal["robot", "dear", "else", ""]
ClauseKind = Literal["fetch", "put", "wish", "lack", "swap", "drop", "plain"]


_ASKED_BEFORE = re.compile(
    r"\b(?:he|she|they|(?:my|our|his|her|the) \w+) (?:has |had )?(?:just |once )?(?:asked|wondered|said|told|wanted)"
    r"(?: (?:me|us|him|her|them))?(?: (?:whether|if|that))*$"
)
_ASKS_YOU = re.compile(r"\b(?:can|could|would|will) you(?: please| also| to| maybe)*$|(?:^|[.,] )please(?: to)?$")
_OWN_WISH = re.compile(
    r"\b(?:i|we|let me|let us)(?: would(?: \w+)?| want| need| will| could| wish)?(?: like| love| prefer)?(?: to)?$"
)
_HE_DOES = re.compile(r"(?:(?:and|then|so|well|yesterday|,) )*(?:he|she|they) (?!wants?\b|needs?\b|would like)\w+")
_PAIR = re.compile(r" (?:out )?T\d+(?: \w+)? (?:for|with|against|to|by|into) T\d+")
_REPORTED = re.compile(r"\b(?:says?|said|told|tells?|asked|asks|wants?|recipe|he|she|they) .*\bto\b")


@dataclass(frozen=True, slots=True)
class Sentence:
    """An utterance as a skeleton: words, with `T0` for a thing, `P0` for a place.

    Attributes:
        called: Who is called: the `robot`, something that a robot or a person may be called (`dear`), somebody
            `else`, or nobody ("").
    """

    skeleton: str
    things: tuple[Thing, ...]
    spots: tuple[Spot, ...]
    called: Called = ""


@dataclass(frozen=True, slots=True)
class Clause:
    """A part of the skeleton.

    Attributes:
        verb: The word that made it what it is.
        framed: Whether "you" are asked expressly ("could you ...").
        lead: The words before the verb.
        body: The words after it.
        start: Where it begins in the skeleton.
    """

    kind: ClauseKind
    verb: str
    framed: bool
    lead: str
    body: str
    start: int

    @property
    def text(self) -> str:
        """The whole clause."""
        return " ".join(part for part in (self.lead, self.verb, self.body) if part)

    def things(self) -> list[int]:
        """Numbers of the things in it, in order."""
        return [int(number) for number in re.findall(r"\bT(\d+)", self.text)]

    def spots(self) -> list[int]:
        """Numbers of the places in it, in order."""
        return [int(number) for number in re.findall(r"\bP(\d+)", self.text)]


def skeleton(items: Iterable[Item]) -> Sentence:
    """Write items as a skeleton."""
    things: list[Thing] = []
    spots: list[Spot] = []
    words: list[str] = []
    for item in items:
        if isinstance(item, Thing):
            words.append(f"T{len(things)}")
            things.append(item)
        elif isinstance(item, Spot):
            words.append(f"P{len(spots)}")
            spots.append(item)
        else:
            words.append(item.text if isinstance(item, Word) else item.mark)
    return Sentence(" ".join(words), tuple(things), tuple(spots))


@dataclass(frozen=True, slots=True)
class _Head:
    kind: ClauseKind
    frame: int
    start: int
    end: int
    framed: bool


class ClauseCutter:
    """Cuts skeletons into clauses with the verbs of a lexicon."""

    def __init__(self, lexicon: Lexicon) -> None:
        verbs = lexicon.verbs
        self._subjects = lexicon.others
        self._kinds: tuple[tuple[ClauseKind, re.Pattern[str]], ...] = (
            ("swap", _one_of(verbs.swap)),
            ("drop", _one_of(verbs.drop)),
            ("fetch", _one_of(verbs.fetch)),
            ("put", _one_of(verbs.put)),
        )
        self._gerunds: tuple[tuple[ClauseKind, re.Pattern[str]], ...] = (
            ("fetch", _one_of(verbs.bringing)),
            ("put", _one_of(verbs.putting)),
            ("swap", _one_of(verbs.swapping)),
        )
        self._pasts: tuple[tuple[ClauseKind, re.Pattern[str]], ...] = (
            ("fetch", _one_of(verbs.brought)),
            ("put", _one_of(verbs.left)),
        )

    def cut(self, text: str) -> list[Clause]:
        """The clauses of a skeleton, in order."""
        heads = self._heads(text)
        clauses: list[Clause] = []
        cuts = sorted(
            {0, *(head.frame for head in heads), *(m.end() + 1 for m in re.finditer(r"(?<= )[.?](?= )", text))}
        )
        by_frame = {head.frame: head for head in heads}
        for index, start in enumerate(cuts):
            end = cuts[index + 1] if index + 1 < len(cuts) else len(text)
            head = by_frame.get(start)
            if head is None:
                body = text[start:end].strip()
                if body.strip(" .,?"):
                    clauses.append(Clause("plain", "", False, "", body, start))
            else:
                lead, verb = text[start : head.start].strip(), text[head.start : head.end].strip()
                clauses.append(Clause(head.kind, verb, head.framed, lead, text[head.end : end].strip(), start))
        return clauses

    def _heads(self, text: str) -> list[_Head]:
        found: list[_Head] = []
        for kind, pattern in self._kinds:
            for match in pattern.finditer(text):
                head = self._accept(text, kind, match, self._lead(text, match))
                if head:
                    found.append(head)
        for patterns, frame in ((self._gerunds, frames.GERUND_FRAME), (self._pasts, frames.PAST_FRAME)):
            for kind, pattern in patterns:
                for match in pattern.finditer(text):
                    lead = self._lead(text, match)
                    if frame.search(lead) or (patterns is self._gerunds and _ASKS_YOU.search(lead)):
                        found.append(
                            _Head(kind, match.start() - len(lead.lstrip(" ,")), match.start(), match.end(), True)
                        )
        found += [
            _Head("wish", m.start(), m.start(), m.end(), False)
            for m in frames.WISH.finditer(text)
            if _wish_holds(text, m)
        ]
        found += [_Head("wish", m.start(), m.start(), m.end(), False) for m in frames.TERSE_WISH.finditer(text)]
        found += [_Head("lack", m.start(), m.start(), m.end(), False) for m in frames.LACK.finditer(text)]
        return _without_overlaps(found)

    @staticmethod
    def _lead(text: str, match: re.Match[str]) -> str:
        """What stands before a verb in its sentence, without the space between."""
        sentence = max(text.rfind(" . ", 0, match.start()), text.rfind(" ? ", 0, match.start()))
        return text[sentence + 3 if sentence >= 0 else 0 : max(match.start() - 1, 0)]

    def _tells(self, lead: str) -> bool:
        """Whether a verb before is what somebody does: "we take a bowl and add ..."."""
        for kind, pattern in self._kinds:
            for match in pattern.finditer(lead):
                before = lead[: match.start()].split()
                if kind in {"fetch", "put"} and before and before[-1] in {"i", "we", "he", "she", "they"}:
                    return frames.FRAME.search(lead[: match.start()].rstrip()) is None
        return False

    def _accept(self, text: str, kind: ClauseKind, match: re.Match[str], lead: str) -> _Head | None:  # noqa: PLR0911 - one rule per return
        if kind in {"swap", "drop"} and not re.match(
            rf" (?:{frames.T}|{frames.P}|{frames.PRONOUN}\b|from\b|over\b)", text[match.end() :]
        ):
            return None
        if kind == "swap" and _OWN_WISH.search(lead) and _PAIR.match(text[match.end() :]):
            return _Head(kind, match.start(), match.start(), match.end(), True)
        frame = frames.FRAME.search(lead)
        if frame and _ASKED_BEFORE.search(lead[: frame.start()].rstrip()):
            return None
        if frame:
            return _Head(kind, match.start() - 1 - len(lead) + frame.start(), match.start(), match.end(), True)
        before = lead.split()
        last = before[-1] if before else ","
        reported = _REPORTED.search(lead) is not None
        if last in {"and", "then"} and (self._tells(lead) or _HE_DOES.match(lead)):
            return None
        if last in {"and", "then"} and len(before) > 1 and not reported and frames.QUESTION.match(lead) is None:
            return _Head(kind, match.start(), match.start(), match.end(), False)
        if last == "you" and (
            len(before) == 1 or before[-2] in {",", "please", "now", "and", "robot", "then", "no", "so"}
        ):
            return _Head(kind, match.start(), match.start(), match.end(), False)
        if last == "do" and (len(before) == 1 or before[-2] in {",", "please", "and", "but", "so", "yes"}):
            return _Head(kind, match.start(), match.start(), match.end(), False)  # "and do get the bread"
        if last == "me" and " ".join(before[-2:]) in {"with me", "for me", "to me"}:
            return _Head(kind, match.start(), match.start(), match.end(), False)
        subject = (
            last in frames.NEVER_BEFORE_VERB
            or last in self._subjects
            and len(before) <= 3
            and before[0] not in {"hey", "dear"}
        )
        thing_before = re.fullmatch(r"[TP]\d+", last) is not None
        follows = text[match.end() :]
        if last in {"and", "then"} and reported:
            return None
        if subject or (thing_before and not re.match(rf" (?:me|us|it|{frames.T}|some)\b", follows)):
            return None
        if frames.QUESTION.match(lead) and "," not in before:
            return None
        return _Head(kind, match.start(), match.start(), match.end(), False)


def _wish_holds(text: str, match: re.Match[str]) -> bool:
    """Whether a wish is one: not denied, not a question about it, not a mere liking ("i like")."""
    before = text[: match.start()].rsplit(" . ", maxsplit=1)[-1].rsplit(" ? ", maxsplit=1)[-1]
    words = match[0].split()
    if re.search(
        r"\b(?:do|did|does|not|when|if|whether|what|where|why|how|that|think|who|which|said|says|"
        r"told)$",
        before.strip(),
    ) and not re.search(r"\b(?:think|that|said)$", before.strip()):
        return False
    if "like" in words and not {"would", "feel", "need", "want"} & set(words) and words[-1] == "like":
        return False
    if words[0] in {"do", "have"} and "you" in words:
        return (
            re.search(
                rf"{frames.T}[^.?]* (?:for (?:me|us)|i could \w+|we could \w+|to spare|i can \w+)\b",
                text[match.start() :],
            )
            is not None
        )
    if "see" in words[-1:] or re.search(r"\bis there (?:a|some|any)$", match[0]):
        return False
    return (
        "was" not in words[1:2] or "after" in words or "hoping" in words or words[0] == "would" or "wondering" in words
    )


def _without_overlaps(found: Sequence[_Head]) -> list[_Head]:
    kept: list[_Head] = []
    for head in sorted(found, key=lambda h: (h.frame, -(h.end - h.start), -h.end)):
        if any(head.frame < other.end and other.frame < head.end for other in kept):
            continue
        kept.append(head)
    return kept


def _one_of(phrases: Sequence[str]) -> re.Pattern[str]:
    ordered = sorted(phrases, key=len, reverse=True)
    return re.compile(rf"(?:^|(?<= ))(?:{'|'.join(map(re.escape, ordered))})(?= |$)")
