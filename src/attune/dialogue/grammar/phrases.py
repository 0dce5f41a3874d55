"""Finds the noun phrases ("the small red cup from the cabinet") and the places in a row of tokens."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from attune.core.messages import ObjectSpec, Size
from attune.dialogue.grammar.items import Break, Item, Role, Spot, Thing, Word
from attune.dialogue.grammar.tokens import Token
from attune.dialogue.lexicon import Entry, Lexicon
from attune.dialogue.words import words

_BREAKS = frozenset({",", ".", "?"})
_DEFINITE = words("the my your our his her their its this that these those 's")
_ARTICLES = frozenset({"a", "an", "the", "my", "some", "two"})
_INDEFINITE = words("a an some any another one each every either")
_AMOUNTS: dict[tuple[str, ...], int] = {
    ("a", "couple", "of"): 2, ("a", "couple"): 2, ("a", "pair", "of"): 2, ("a", "few"): 1, ("a", "bit", "of"): 1,
    ("a", "little", "bit", "of"): 1, ("a", "drop", "of"): 1, ("a", "set", "of"): 1, ("a", "piece", "of"): 1,
    ("one", "of", "the"): 1, ("one", "of", "those"): 1, ("one", "of", "these"): 1, ("one", "of", "my"): 1,
    ("one", "of", "our"): 1, ("some", "of", "the"): 1, ("some", "of", "that"): 1, ("one", "more"): 1,
    ("all", "the"): 1, ("all", "of", "the"): 1, ("both", "of", "the"): 2, ("a", "bunch", "of"): 1,
    ("a", "slice", "of"): 1, ("a", "box", "of"): 1,
    ("the", "box", "of"): 1, ("the", "bottle", "of"): 1, ("the", "carton", "of"): 1, ("the", "packet", "of"): 1,
    ("a", "packet", "of"): 1, ("a", "bottle", "of"): 1, ("a", "carton", "of"): 1, ("a", "kind", "of"): 1,
}  # fmt: skip
_ORDINALS = {"first": 1, "former": 1, "second": 2, "latter": 2, "third": 3, "last": -1}
_FROM: tuple[tuple[str, ...], ...] = (
    ("from", "on", "top", "of"), ("from", "the", "top", "of"), ("from", "the", "inside", "of"), ("from", "inside"),
    ("from", "out", "of"), ("from", "over", "on"), ("from", "over", "in"), ("from", "on"), ("from", "in"),
    ("from", "off"), ("over", "from"), ("from", "under"), ("from", "behind"), ("from",), ("out", "of"), ("off", "of"),
    ("off",), ("out", "from"), ("from", "within"),
)  # fmt: skip
_TO: tuple[tuple[str, ...], ...] = (
    ("over", "to"), ("back", "to"), ("up", "to"), ("down", "to"), ("over", "onto"), ("on", "to"), ("in", "to"), ("to",),
    ("onto",), ("into",), ("toward",), ("towards",), ("back", "onto"), ("back", "on"), ("back", "into"),
)  # fmt: skip
_AT: tuple[tuple[str, ...], ...] = (
    ("on", "top", "of"), ("in", "front", "of"), ("inside", "of"), ("down", "on"), ("up", "on"), ("over", "on"),
    ("over", "in"), ("over", "by"), ("over", "at"), ("next", "to"), ("in",), ("on",), ("at",), ("inside",), ("by",),
    ("near",), ("beside",), ("within",), ("upon",), ("under",), ("behind",), ("at", "the", "top", "of"),
)  # fmt: skip
_PREPOSITIONS: tuple[tuple[tuple[str, ...], Role], ...] = tuple(
    sorted(
        [(words, "from") for words in _FROM] + [(words, "to") for words in _TO] + [(words, "at") for words in _AT],
        key=lambda pair: -len(pair[0]),
    )
)
_PREPOSITIONS_START = {preposition[0] for preposition, _ in _PREPOSITIONS}
_PLACE_ADJECTIVES = words("top bottom upper lower middle left right kitchen dining other same wall corner")
_NOT_ADJECTIVES = words(
    "i you he she it we they me us him them and or but not no is are was were be am do does did have has "
    "had can could will would shall should may might must to of in on at from for with by as if that this "
    "there here please instead than rather bring get fetch give take put want need like one what which "
    "who where when how why said so then because meant mean sorry wait actually stop over into onto out "
    "off up down again also just too now's wrong"
)
_RELATIVES = (("that", "is"), ("which", "is"), ("that", "are"), ("which", "are"), ("who", "is"), ("that", "was"),
              ("which", "was"), ("that", "'s"), ("which", "'s"))  # fmt: skip
_STANDING = words("stands standing sits sitting lies lying sit lie stand stored kept lives located hidden")
_WHERE_RELATIVES = words(
    "that which you i we keep kept left put will find should be have has can there over right just always "
    "got somewhere probably still usually there's is are"
)


@dataclass(slots=True)
class _Draft:
    """The properties of a noun phrase while it is read."""

    color: str = ""
    size: str = ""
    compared: bool = False
    other: bool = False
    different: bool = False
    another: bool = False
    ordinal: int = 0
    location: str = ""

    def take(self, entry: Entry) -> bool:
        """Add a property; False when one of its kind is there already."""
        if entry.group == "color":
            if self.color:
                return False
            self.color = entry.value
        else:
            if self.size:
                return False
            self.size, self.compared = entry.value, entry.group == "comparative"
        return True


class PhraseReader:
    """Reads tokens with a lexicon.

    Args:
        lexicon: The words.
        present: Types known to be there; "my glasses" are drinking glasses only where there are some.
    """

    def __init__(self, lexicon: Lexicon, present: Collection[str] = ()) -> None:
        self._lexicon = lexicon
        self._present = present
        self._starts = {phrase[0] for phrase in lexicon.phrases}

    def items(self, tokens: Sequence[Token]) -> list[Item]:
        """All items of an utterance, in order."""
        words = [token.text for token in tokens]
        items: list[Item] = []
        at = 0
        while at < len(words):
            spot = self._spot(words, at)
            found: tuple[Item, int] | None = spot or self._thing(words, at)
            if found is None:
                text = words[at]
                items.append(Break(text) if text in _BREAKS else Word(text, tokens[at].capital))
                at += 1
            else:
                items.append(found[0])
                at = found[1]
        return items

    def match(self, words: Sequence[str], at: int) -> tuple[Entry, int] | None:
        """The longest phrase of the lexicon at a position, and where it ends."""
        if at >= len(words) or words[at] not in self._starts:
            return None
        for length in range(min(self._lexicon.longest, len(words) - at), 0, -1):
            entry = self._lexicon.phrases.get(tuple(words[at : at + length]))
            if entry is not None:
                return entry, at + length
        return None

    def _spot(self, words: Sequence[str], start: int) -> tuple[Spot, int] | None:
        role: Role = ""
        at = start
        opens = at < len(words) and words[at] in _PREPOSITIONS_START
        for preposition, meaning in _PREPOSITIONS if opens else ():
            if tuple(words[at : at + len(preposition)]) == preposition:
                role, at = meaning, at + len(preposition)
                break
        definite = True
        if at < len(words) and (words[at] in _DEFINITE or words[at] in {"a", "an"}):
            definite = words[at] not in {"a", "an"}
            at += 1
        while at < len(words):
            found = self.match(words, at)
            if found and found[0].group == "place" and not self._is_place(words, start, at, found[1], role):
                return None
            if found and found[0].group == "place":
                return Spot(found[0].value, role, definite), self._after_place(words, found[1])
            if found and found[0].group in {"color", "size"}:
                at = found[1]
            elif words[at] in _PLACE_ADJECTIVES or words[at] in self._lexicon.adjectives:
                at += 1
            else:
                return None
        return None

    def _is_place(self, words: Sequence[str], start: int, at: int, end: int, role: Role) -> bool:
        """`the fridge milk` is no place, and "the side" is one only in "on the side"."""
        if words[at] == "side" and end == at + 1:
            return tuple(words[start:at]) in {("on", "the"), ("onto", "the"), ("over", "on", "the"), ("off", "the"),
                                              ("down", "on", "the")} and words[end : end + 1] != ["of"]  # fmt: skip
        return bool(role) or at == start or not self._nominal(words, end)

    def _after_place(self, words: Sequence[str], at: int) -> int:
        """Skip what only describes the place: "the shelf above the counter", "the cabinet over there"."""
        if tuple(words[at : at + 2]) == ("over", "there"):
            return at + 2
        if at < len(words) and words[at] in {"above", "below", "under", "beside", "behind"}:
            inner = self._spot(words, at + 1)
            if inner:
                return inner[1]
        if tuple(words[at : at + 2]) == ("next", "to") and (inner := self._spot(words, at + 2)):
            return inner[1]
        return at

    def _thing(self, words: Sequence[str], start: int) -> tuple[Thing, int] | None:
        named = self.match(words, start)
        if named and named[0].group == "unknown" and words[start] in _DEFINITE:
            noun = self._lexicon.phrases.get((words[named[1] - 1],))
            if noun is None or noun.value not in self._present:
                return replace(self._make(_Draft(), True, True, 1, named[0].value, ""), unknown=True), named[1]
        at, definite, article, count, another = self._determiner(words, start)
        draft = _Draft(another=another)
        at = self._adjectives(words, at, draft, article)
        found = self.match(words, at) if at < len(words) else None
        thing: Thing | None = None
        if found and found[0].group in {"type", "unknown"}:
            entry, at = found
            size = draft.size
            if size == "small" and not definite and entry.value in self._lexicon.mass and "little" in words[start:at]:
                size = ""  # "a little milk" is an amount
            thing = self._make(draft, definite, article, count, entry.value, size)
            if entry.group == "unknown":
                thing = replace(thing, unknown=True)
        elif at < len(words) and words[at] in {"one", "ones"} and (at > start or self._stands_alone(words, at)):
            thing, at = replace(self._make(draft, definite, article, count, "", draft.size), head="one"), at + 1
        elif at > start and article and words[at - 1] == "one" and self._stands_alone(words, at - 1):
            thing = replace(self._make(draft, definite, article, count, "", draft.size), head="one")
        elif (draft.color or draft.size or draft.other or draft.ordinal or another) and (
            self._ends(words, _after_partitive(words, at)) or self._denied_property(words, start, at)
        ):
            if (draft.other or draft.ordinal) and not draft.color and not draft.size and not definite and not another:
                return None
            thing = replace(self._make(draft, definite, article, count, "", draft.size), head="bare")
        elif count > 1 and self._ends(words, at):
            thing = replace(self._make(draft, definite, article, count, "", draft.size), head="one")
        if thing is None:
            return None
        if thing.head != "noun":
            at = _after_partitive(words, at)
        return self._modifiers(words, at, thing)

    @staticmethod
    def _make(draft: _Draft, definite: bool, article: bool, count: int, type_: str, size: str) -> Thing:
        spec = ObjectSpec(type=type_, color=draft.color, size=_size(size), location=draft.location)
        return Thing(
            spec=spec,
            definite=definite,
            article=article,
            count=count,
            compared=draft.compared,
            other=draft.other,
            different=draft.different,
            another=draft.another,
            ordinal=draft.ordinal,
        )

    def _determiner(self, words: Sequence[str], at: int) -> tuple[int, bool, bool, int, bool]:
        """Where the determiners end, and what they said: definite, any, count, another."""
        definite = article = another = False
        count = 1
        while at < len(words):
            amount = next((n for n in (4, 3, 2) if at + n <= len(words) and tuple(words[at : at + n]) in _AMOUNTS), 0)
            word = words[at]
            if word in {"that", "this", "these", "those"} and at + 1 < len(words) and words[at + 1] in _ARTICLES:
                break  # "make that a large one"
            if amount:
                count = _AMOUNTS[tuple(words[at : at + amount])]
                another = another or words[at + amount - 1] == "more"
                article = True
                definite = definite or words[at] == "the"
                at += amount
            elif word in _DEFINITE:
                definite = article = True
                at += 1
            elif word in self._lexicon.numbers or (word.isdigit() and len(word) == 1 and word != "0"):
                both_of = word == "both" and at + 1 < len(words) and words[at + 1] in _ARTICLES
                count = 1 if both_of else self._lexicon.numbers.get(word) or int(word)
                article = True
                at += 1
                if at < len(words) and words[at] == "more":
                    another, at = True, at + 1
            elif word in _INDEFINITE and not article:
                article = True
                another = word == "another"
                at += 1
            else:
                break
        return at, definite, article, min(count, 6), another

    def _adjectives(self, words: Sequence[str], at: int, draft: _Draft, article: bool) -> int:
        while at < len(words):
            found = self.match(words, at)
            word = words[at]
            if found and found[0].group in {"color", "size", "comparative"}:
                if not draft.take(found[0]):
                    break
                at = found[1]
                if (
                    at < len(words)
                    and words[at] in {"colored", "sized", "color", "size"}
                    and self._nominal(words, at + 1)
                ):
                    at += 1
            elif (
                found
                and found[0].group == "place"
                and article
                and not draft.location
                and self._nominal(words, found[1])
            ):
                draft.location, at = found[0].value, found[1]
            elif found:
                break
            elif word in {"and", ","} and (draft.color or draft.size) and self._goes_on(words, at + 1, draft):
                at += 1
            elif word in self._lexicon.adjectives and word not in {"one", "ones"}:
                draft.other = draft.other or word in {"other", "different"}
                draft.different = draft.different or word == "different"
                draft.ordinal = _ORDINALS.get(word, draft.ordinal)
                draft.another = draft.another or word in {"more", "same"}
                at += 1
            elif word in _ORDINALS:
                draft.ordinal = _ORDINALS[word]
                at += 1
            elif article and word in self._lexicon.homophones and not draft.color and self._nominal(words, at + 1):
                draft.color = self._lexicon.homophones[word]
                at += 1
            elif article and word not in _NOT_ADJECTIVES and word not in _BREAKS and self._nominal(words, at + 1):
                at += 1
            else:
                break
        return at

    def _goes_on(self, words: Sequence[str], at: int, draft: _Draft) -> bool:
        """Whether "small and red cup" goes on with another kind of property and then a noun."""
        found = self.match(words, at) if at < len(words) else None
        if not found or found[0].group not in {"color", "size"} or not self._nominal(words, found[1], depth=1):
            return False
        return not (draft.color if found[0].group == "color" else draft.size)

    def _nominal(self, words: Sequence[str], at: int, depth: int = 2) -> bool:
        """Whether a noun comes next, perhaps after properties."""
        found = self.match(words, at) if at < len(words) else None
        if found is None:
            return at < len(words) and words[at] in {"one", "ones"}
        if found[0].group in {"color", "size"} and depth:
            return self._nominal(words, found[1], depth - 1)
        return found[0].group == "type"

    def _stands_alone(self, words: Sequence[str], at: int) -> bool:
        before = words[at - 1] if at else ""
        return self._ends(words, at + 1) and before not in {"no", "any", "every", "which", "some"}

    def _denied_property(self, words: Sequence[str], start: int, at: int) -> bool:
        """`not red blue`."""
        found = self.match(words, at)
        return (
            bool(start)
            and words[start - 1] in {"not", "no"}
            and found is not None
            and found[0].group in {"color", "size"}
        )

    def _ends(self, words: Sequence[str], at: int) -> bool:
        return at >= len(words) or words[at] in _BREAKS or words[at] in _AFTER_BARE

    def _modifiers(self, words: Sequence[str], at: int, thing: Thing) -> tuple[Thing, int]:
        """Read what follows the noun: colour and size after it, "that is red", "which is in the cabinet"."""
        while at < len(words):
            step = (
                self._property_after(words, at, thing)
                or self._relative(words, at, thing)
                or self._standing(words, at, thing)
            )
            if step is None:
                break
            thing, at = step
        return thing, at

    def _property_after(self, words: Sequence[str], start: int, thing: Thing) -> tuple[Thing, int] | None:
        at = start
        comma = words[at] == ","
        if comma:
            at += 1
        elif words[at] in {"in", "of", "with"}:
            at += 1
            while at < len(words) and words[at] in {"the", "a", "color", "size", "in"}:
                at += 1
        elif words[at] in {"color", "size"}:
            at += 1
        found = self.match(words, at) if at < len(words) else None
        if not found or found[0].group not in {"color", "size"}:
            return None
        end = found[1]
        if self._nominal(words, end):
            return None  # it belongs to the next noun
        if end < len(words) and words[end] in {"color", "colored", "size", "sized"}:
            end += 1
        if comma and not self._ends(words, end):
            return None
        changed = _with(thing, found[0])
        return (changed, end) if changed else None

    def _relative(self, words: Sequence[str], at: int, thing: Thing) -> tuple[Thing, int] | None:
        """`that is red and small`; a place after it is read by `_standing`."""
        if tuple(words[at : at + 2]) not in _RELATIVES:
            return None
        at += 2
        changed: Thing | None = thing
        read = False
        while at < len(words) and changed:
            if words[at] in {"and", ",", "really", "very", "quite"} and read is (words[at] in {"and", ","}):
                at += 1
            found = self.match(words, at) if at < len(words) else None
            if not found or found[0].group not in {"color", "size"}:
                break
            changed = _with(changed, found[0])
            at, read = found[1], True
        return (changed, at) if changed and read else None

    def _standing(self, words: Sequence[str], start: int, thing: Thing) -> tuple[Thing, int] | None:
        """`that is (standing) in the cabinet`, `you left on the table`: where the thing is."""
        if thing.spec.location or thing.unknown:
            return None
        at = start
        if words[at] not in {
            "that",
            "which",
            "you",
            "i",
            "we",
            "standing",
            "sitting",
            "lying",
            "stored",
            "kept",
            "over",
        }:
            return None
        while at < len(words) and at - start < 5 and (words[at] in _WHERE_RELATIVES or words[at] in _STANDING):
            at += 1
        if at == start:
            return None
        if words[at - 1] in {"put"} and words[start] in {"you"}:
            return None  # "the cup you put on the table" is fine, "you put" may be an order
        spot = self._spot(words, at)
        if spot is None or spot[0].role not in {"at", "from"}:
            return None
        return replace(thing, spec=replace(thing.spec, location=spot[0].place)), spot[1]


_AFTER_BARE = words(
    "and or from in on at please instead too as no not sorry i rather out off thanks thank for than with "
    "but if when to of would could can is are now actually wait mean over that which inside also then "
    "will you"
)


def _after_partitive(words: Sequence[str], at: int) -> int:
    """Skip "of the two", "of them" after a pointing word."""
    for partitive in (("of", "the", "two"), ("of", "the", "pair"), ("of", "them"), ("of", "those"), ("of", "these")):
        if tuple(words[at : at + len(partitive)]) == partitive:
            return at + len(partitive)
    return at


def _size(value: str) -> Size:
    return value if value in {"small", "normal", "big"} else ""  # type: ignore[return-value]


def _with(thing: Thing, entry: Entry) -> Thing | None:
    if entry.group == "color":
        return None if thing.spec.color else replace(thing, spec=replace(thing.spec, color=entry.value))
    return None if thing.spec.size else replace(thing, spec=replace(thing.spec, size=_size(entry.value)))
