"""From clauses to what is wanted: which objects to bring, which to drop, and where to put them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import cues, frames
from attune.dialogue.grammar.bare import is_contrast, names_only
from attune.dialogue.grammar.clauses import Clause, ClauseKind, Sentence
from attune.dialogue.grammar.corrections import MARKER
from attune.dialogue.grammar.items import Spot, Thing, described
from attune.dialogue.grammar.polarity import goes_to, refused
from attune.dialogue.grammar.references import is_described_by, object_spoken_of, resolve
from attune.dialogue.grammar.wanted import Wanted
from attune.dialogue.lexicon import Lexicon


class RequestReader:
    """Reads the clauses of one utterance. Make a new one for each utterance."""

    def __init__(self, sentence: Sentence, context: Context, lexicon: Lexicon, said: Sequence[ObjectSpec]) -> None:
        self._things = list(sentence.things)
        self._spots = sentence.spots
        self._context = context
        self._lexicon = lexicon
        self._said = said
        self._wanted = Wanted()
        self._place_to_look = ""
        self._place_mentioned = ""
        self._nouns: list[ObjectSpec] = []
        self._given_back: list[ObjectSpec] = []
        self._listed: list[ObjectSpec] = []

    def read(self, clauses: Sequence[Clause]) -> Wanted:
        """All clauses together."""
        self._negative, self._wrong = refused(clauses, self._things, self._spots, self._context)
        asks = any(clause.kind in {"fetch", "put", "wish", "swap"} for clause in clauses)
        previous: Clause | None = None
        for clause in clauses:
            if previous is not None and self._takes_back(previous, clause):
                self._wanted.add.clear()
                self._wanted.definite.clear()
            self._clause(clause, asks)
            previous = clause
        if not self._wanted.add and not self._wanted.remove and self._wanted.topics:
            whole = " ".join(clause.text for clause in clauses)
            if frames.POINTING_WISH.search(whole) and not self._wanted.moves:
                self._wanted.add.append(self._wanted.topics[-1])
                self._wanted.definite.append(True)
        self._finish()
        return self._wanted

    def _clause(self, clause: Clause, asks: bool) -> None:
        wanted = self._wanted
        if (clause.kind == "swap" and self._swap(clause)) or self._swapped(clause.text):
            return
        kind = self._drop(clause) if clause.kind == "drop" else clause.kind
        if kind == "drop":
            return
        if kind == "plain" and cues.PASSIVE.search(clause.text):
            self._objects(clause, "put")
            return
        if kind in {"plain", "swap"}:
            named = names_only(clause.text, self._lexicon) if kind == "plain" else ""
            wanted.moves = wanted.moves or named == "place"
            if named or (kind == "plain" and is_contrast(clause.text, self._things, self._context)):
                self._objects(clause, "plain")
            else:
                self._statement(clause)
            return
        if kind == "lack" and asks:
            self._statement(clause)
            return
        if frames.PAST.search(clause.body) and not clause.framed and kind != "wish":
            self._statement(clause)
            return
        wanted.framed = wanted.framed or clause.framed
        if kind in {"fetch", "put"}:
            wanted.asked = True
        self._objects(clause, "put" if kind == "put" else "fetch" if kind == "fetch" else "wish")

    def _drop(self, clause: Clause) -> ClauseKind:
        """`leave T0` drops it, `leave T0 P0` and `drop T0 P0` put it."""
        positive_spots = goes_to(clause, self._spots)
        if positive_spots and clause.verb in {"leave", "drop", "lose", "return"}:
            return "put"
        if clause.verb == "return" and not positive_spots:
            self._wanted.put_back = True
        if re.match(rf"(?:{frames.PRONOUN})\b", clause.body):
            self._wanted.contrast = True
        found = False
        for number in clause.things():
            positive = f"T{number}" in re.split(r"\b(?:and|but)\b (?=i |we |can |could )", clause.body)[0]
            if positive and number in self._negative:
                self._remove(number)
                found = True
            elif number not in self._negative:
                self._add(number, clause)
        if not found and not self._wanted.contrast:
            self._statement(clause)
        return "drop"

    def _swap(self, clause: Clause) -> bool:
        pair = cues.SWAP_PAIR.match(clause.body)
        if pair is None or pair["old"].startswith("P"):
            # "swap out the green bowl and bring the black one"
            self._given_back += [self._things[n].spec for n in clause.things() if self._things[n].head == "noun"]
            return False
        old, new = pair["old"], pair["new"]
        if clause.verb == "substitute" and " for " in pair[0] and old.startswith("T"):
            old, new = new, old
        wanted = self._wanted
        wanted.contrast = wanted.asked = True
        if old.startswith("T"):
            self._negative.add(int(old[1:]))
            if self._things[int(old[1:])].head != "noun" and self._things[int(new[1:])].head == "noun":
                self._nouns.append(self._things[int(new[1:])].spec)
            self._remove(int(old[1:]))
        elif wanted.topics and wanted.topics[-1].type != (
            self._things[int(new[1:])].spec.type or wanted.topics[-1].type
        ):
            wanted.remove.append(wanted.topics[-1])  # "this cup is filthy, swap it for a mug"
        self._negative.discard(int(new[1:]))
        self._add(int(new[1:]), clause)
        self._places(f"{new}{clause.body[pair.end() :]}", "put", clause)
        return True

    def _swapped(self, text: str) -> bool:
        """Read "my cup replaced with a mug"."""
        pair = cues.SWAPPED_PAIR.search(text)
        if pair is None or frames.QUESTION.match(text) or self._things[int(pair["old"])].head != "noun":
            return False
        old, new = int(pair["old"]), int(pair["new"])
        self._wanted.contrast = self._wanted.asked = True
        self._negative.discard(new)
        self._negative.add(old)
        self._remove(old)
        self._nouns.append(self._things[old].spec)
        return self._add(new, Clause("swap", "swap", True, "", text, 0))

    def _statement(self, clause: Clause) -> None:  # noqa: PLR0912 - one rule per branch
        """Something said about things: it only tells what pointing words may mean, and where to look."""
        text = clause.text
        specs: dict[int, ObjectSpec] = {}
        travel = cues.TRAVEL.search(text) is not None and not frames.PAST.search(text)
        for match in re.finditer(r"\b([TP])(\d+)\b", text):
            number = int(match[2])
            if match[1] == "T" and self._things[number].head == "noun":
                specs[number] = self._things[number].spec
            elif match[1] == "P" and self._spots[number].role in {"at", "from", ""}:
                before = cues.LOCATED.search(text[: match.start()].rstrip())
                if before and int(before[1]) in specs:
                    number_of = int(before[1])
                    specs[number_of] = replace(specs[number_of], location=self._spots[number].place)
                elif self._spots[number].role == "from" and specs:
                    specs[max(specs)] = replace(specs[max(specs)], location=self._spots[number].place)
            if match[1] == "P":
                self._place_mentioned = self._spots[number].place
            if match[1] == "P" and travel:
                self._place_to_look = self._spots[number].place
        if not frames.QUESTION.match(text) and not cues.SOMEBODY.match(text):
            for number in clause.things():
                if number in self._negative:
                    specs.pop(number, None)
                    self._remove(number)
        for number, spec in specs.items():
            if travel and self._place_to_look and not spec.location:
                specs[number] = replace(spec, location=self._place_to_look)
        pointing = re.match(r"(?:it|they|that|those) (?:is|are|should be|must be|will be)\b.* P(\d+)", text)
        if pointing and self._wanted.add and not self._wanted.add[-1].location:
            place = self._spots[int(pointing[1])].place
            self._wanted.add = [replace(spec, location=spec.location or place) for spec in self._wanted.add]
        self._shown(text)
        self._wanted.topics += specs.values()
        self._keep_list(text, specs)
        self._nouns += specs.values()

    def _keep_list(self, text: str, specs: Mapping[int, ObjectSpec]) -> None:
        """Note what is named together: "them" means it afterwards."""
        for match in cues.LISTED.finditer(text):
            numbers = [int(number) for number in re.findall(r"T(\d+)", match[0])]
            self._listed = [specs[number] for number in numbers if number in specs]

    def _shown(self, text: str) -> None:
        """Note what a person points out as wrong: "that is salt, I need sugar"."""
        shown = cues.SHOWN.match(text)
        if shown and self._things[int(shown[1])].spec.type in {has.type for has in self._context.recent}:
            self._given_back.append(self._things[int(shown[1])].spec)

    def _objects(self, clause: Clause, kind: str) -> None:
        """A clause that asks: its things are wanted, its places say where from and where to."""
        body = cues.without_purpose(clause.body if clause.kind != "plain" else clause.text)
        lead_things = [n for n in re.findall(r"\bT(\d+)", clause.lead)]
        for number in lead_things:
            self._nouns.append(self._things[int(number)].spec)
        numbers = [int(n) for n in re.findall(r"\bT(\d+)", body)]
        positive = [n for n in numbers if n not in self._negative and not self._too(n, body)]
        for number in numbers:
            if number in self._negative and not self._excluded(body, number):
                self._remove(number)
        later = [
            self._things[n].spec for n in positive if self._things[n].head == "noun" and not self._things[n].unknown
        ]
        positive = [n for n in positive if not re.search(rf"\bT\d+(?: P\d+)? or T{n}\b", body)]
        for index, number in enumerate(positive):
            thing = self._things[number]
            if thing.unknown:
                self._wanted.unknown = thing.spec.type
                continue
            if thing.head != "noun" and not self._nouns and later and index < len(positive) - 1:
                self._nouns.append(later[0])  # "the red and the blue cup"
            self._add(number, clause)
        if not numbers and kind in {"fetch", "put"}:
            self._pronoun(clause, body)
        self._places(body, kind, clause)
        if not numbers and not self._wanted.pronoun and kind in {"fetch", "put"}:
            rest = re.sub(r"\b[TP]\d+\b", " ", body)
            unknown = [
                w
                for w in rest.split()
                if w not in cues.FILLER and w not in {"me", "us", "the", "a", "my", "some", "back", "down", "away"}
            ]
            self._wanted.unknown = self._wanted.unknown or " ".join(unknown[:3])

    def _too(self, number: int, body: str) -> bool:
        """`too big` says what is wrong, not what is wanted."""
        return self._things[number].head == "bare" and re.search(rf"\btoo T{number}\b", body) is not None

    def _pronoun(self, clause: Clause, body: str) -> None:
        if not cues.PRONOUN_OBJECT.match(body):
            return
        self._wanted.pronoun = True
        if re.match(rf"(?:{frames.PRONOUN} )?(?:back|away)\b", body) or re.match(
            rf"(?:back|away) {frames.PRONOUN}", body
        ):
            self._wanted.put_back = self._wanted.contrast = True
            return
        if self._wanted.add:
            return  # "get a cup and put it on the table"
        topics = self._listed if self._listed and cues.SEVERAL.match(body) else self._wanted.topics[-1:]
        self._wanted.add += topics
        self._wanted.definite += [True] * len(topics)

    def _places(self, body: str, kind: str, clause: Clause) -> None:  # noqa: PLR0912 - one rule per branch
        wanted = self._wanted
        numbers = [int(n) for n in re.findall(r"\bT(\d+)", body) if int(n) not in self._negative]
        first = len(wanted.add) - sum(self._things[n].count for n in numbers if not self._things[n].unknown)
        seen = told = 0
        for match in re.finditer(r"\b([TP])(\d+)\b", body):
            number = int(match[2])
            if match[1] == "T":
                seen += (
                    self._things[number].count
                    if number not in self._negative and not self._things[number].unknown
                    else 0
                )
                continue
            spot = self._spots[number]
            if (
                cues.SUBJECT.match(body[match.end() :])
                and not spot.role
                and body.count(" P") + body.startswith("P") > 1
            ):
                continue  # "to the counter, the table is full"
            if told and cues.COMMENTED.search(body[told : match.start()]):
                continue  # "on the shelf, the cat is on the table"
            if cues.NEGATIVE_SPOT.search(body[: match.start()].rstrip()):
                wanted.moves = wanted.moves or bool(wanted.destination) or not numbers
                continue
            if kind == "fetch" and clause.verb == "get" and not numbers and not wanted.pronoun and spot.role == "to":
                self._place_to_look = spot.place  # "get up to the cabinet"
            elif cues.OTHER_PLACE.match(body[match.end() :]) and spot.role != "from":
                wanted.destination = spot.place
            elif self._is_destination(spot, kind, body[: match.start()], numbers, seen):
                wanted.destination = spot.place
                wanted.moves = wanted.moves or not numbers
                told = match.end() if spot.role == "to" else told
            elif not numbers and wanted.add and spot.role == "from" and (wanted.pronoun or kind == "plain"):
                wanted.locate(len(wanted.add) - 1, len(wanted.add), spot.place, "")  # "a fork; take it from the drawer"
            elif seen and wanted.add:
                wanted.locate(max(first, 0), max(first, 0) + seen, spot.place, body[: match.start()])
            else:
                self._place_to_look = spot.place
        if not wanted.destination and self._place_mentioned and re.search(r"\bthere\b", body):
            wanted.destination = self._place_mentioned
        if self._place_to_look and numbers and wanted.add:
            wanted.locate(max(first, 0), len(wanted.add), self._place_to_look, "")
            self._place_to_look = ""

    def _is_destination(self, spot: Spot, kind: str, before: str, numbers: Sequence[int], seen: int) -> bool:
        if spot.role == "to":
            return True
        if spot.role == "from":
            return False
        if not numbers or kind == "put":
            return not (kind == "put" and numbers and not seen)
        if spot.role == "":
            return True
        last = int(re.findall(r"\bT(\d+)", before)[-1]) if seen else numbers[0]
        if self._things[last].spec.location or (re.search(r"\bP\d+", before) and seen):
            return True
        indefinite = not self._things[last].definite
        return kind in {"wish", "plain"} and indefinite and spot.place in {"table", "countertop"}

    def _add(self, number: int, clause: Clause) -> bool:
        thing = self._things[number]
        spec = thing.spec if thing.head == "noun" else self._resolved(thing)
        if spec is None:
            self._wanted.unresolved = True
            return False
        about = {has.type for has in self._context.recent}
        if thing.definite and spec.type in about and re.search(rf"\bafter T{number}\b", clause.text):
            return False  # "put the bowl on the table after the cup", which is on its way
        if thing.head == "noun" and thing.other:
            spec = resolve(replace(thing, head="one"), self._narrowed(spec), (), self._said) or spec
        if thing.count == 1 and not thing.another and self._says_again(number, spec, clause):
            return True  # "a fork, get me a fork"
        if thing.head == "one" and self._says_nothing(thing) and spec.type in {has.type for has in self._wanted.add}:
            return True  # "I am looking for a plate, could you find one"
        self._nouns.append(spec)
        if thing.head != "noun" and thing.definite and clause.kind in {"wish", "plain"} and spec.color + spec.size:
            self._wanted.indirect = True  # "I want the blue one"
        self._wanted.indirect = (
            self._wanted.indirect
            or thing.compared
            or thing.different
            or (thing.other and clause.kind in {"plain", "wish"})
        )
        self._wanted.add += [spec] * thing.count
        self._wanted.definite += [thing.definite] * thing.count
        return True

    def _says_again(self, number: int, spec: ObjectSpec, clause: Clause) -> bool:
        """Whether a thing was asked for already; "a cup and a cup" are two. What is said later may say more."""
        if re.search(rf"\bT\d+(?: for \w+)? and T{number}\b", clause.text):
            return False
        if spec in self._wanted.add:
            return True
        before = self._wanted.add[-1] if self._wanted.add else spec
        tells_more = before.type == spec.type and is_described_by(replace(before, location=""), spec)
        if self._wanted.add and tells_more and not self._things[number].other and self._wanted.add.count(before) == 1:
            self._wanted.add[-1] = replace(spec, location=spec.location or before.location)
            return True
        return False

    @staticmethod
    def _says_nothing(thing: Thing) -> bool:
        """Whether a pointing word is a mere "one"."""
        return not (
            thing.spec.color or thing.spec.size or thing.definite or thing.another or thing.other or thing.ordinal
        )

    def _narrowed(self, spec: ObjectSpec) -> Context:
        """The context, seen by someone who speaks of this type."""
        recent = [has for has in self._context.recent if has.type == spec.type]
        return replace(self._context, task=None, carrying=recent[0] if recent else described(spec.type), delivered=())

    def _resolved(self, thing: Thing) -> ObjectSpec | None:
        if self._nouns and not thing.other and not thing.compared:
            source = self._nouns[-1]
            topic = self._wanted.topics and source in self._wanted.topics
            location = thing.spec.location or (source.location if topic else "")
            if topic and thing.definite and not (thing.spec.color or thing.spec.size):
                return replace(source, location=location)
            return replace(thing.spec, type=source.type, location=location)
        if self._nouns and self._nouns[-1].type in {has.type for has in self._context.recent}:
            return resolve(thing, self._narrowed(self._nouns[-1]), (), self._said)
        if self._nouns:
            return resolve(thing, self._context, self._nouns, self._said)
        return resolve(thing, self._context, (), self._said)

    def _remove(self, number: int) -> None:
        thing = self._things[number]
        wrong = self._wrong.get(number, False)
        if thing.head == "noun" and not (wrong and not thing.spec.color and not thing.spec.size):
            spec: ObjectSpec | None = thing.spec
        elif thing.head == "noun":
            spoken_of = object_spoken_of(self._context, thing.spec)
            spec = spoken_of if spoken_of and spoken_of.type == thing.spec.type else thing.spec
        else:
            nouns = self._nouns or [
                t.spec for n, t in enumerate(self._things) if t.head == "noun" and n not in self._negative
            ]
            has_properties = thing.spec.color or thing.spec.size
            if nouns and has_properties:
                spec = replace(thing.spec, type=nouns[0].type)
            else:
                spec = object_spoken_of(self._context)
        if spec is not None:
            self._wanted.remove.append(replace(spec, location=thing.spec.location if thing.head == "noun" else ""))
            if thing.head == "noun":
                self._nouns.append(thing.spec)
        self._wanted.contrast = True

    @staticmethod
    def _excluded(body: str, number: int) -> bool:
        """`but not the red one`, `not too big`: narrows what is wanted, replaces nothing."""
        return re.search(rf"\bbut not T{number}\b", body) is not None

    def _takes_back(self, previous: Clause, clause: Clause) -> bool:
        """Whether this clause corrects the one before it: "bring me a cup, no, I'd like a bowl"."""
        if clause.kind not in {"fetch", "wish", "put", "plain"} or not self._wanted.add or self._wanted.remove:
            return False
        if not [n for n in clause.things() if n not in self._negative and self._things[n].head == "noun"]:
            return False
        if frames.ADDITIVE.search(clause.text):
            return False
        joint = f"x {previous.text.split()[-6:] and ' '.join(previous.text.split()[-6:])} ."
        return (
            re.search(rf"[TP]\d+{MARKER}(?: [.,])*$", joint.rstrip(" .")) is not None
            or re.match(rf"{MARKER}(?: \S+){{0,3}}?(?: T\d+)", " " + clause.text) is not None
            and clause.kind == "plain"
        )

    def _finish(self) -> None:
        wanted = self._wanted
        if self._given_back and wanted.add and not wanted.remove:
            wanted.remove += [spec for spec in self._given_back if spec not in wanted.add]
            wanted.contrast = True
        if self._place_to_look and len(wanted.add) == 1:
            wanted.locate(0, 1, self._place_to_look, "")  # "what I need from the drawer is a fork"
        if wanted.moves and wanted.add and not wanted.asked and not wanted.destination:
            wanted.moves = False
        if not wanted.add:
            wanted.definite.clear()
