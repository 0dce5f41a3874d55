"""Grammar of the robot's own sentences: articles, lists, plurals."""

from collections.abc import Callable, Sequence

from attune.core.messages import ObjectSpec

_INSIDE = frozenset({"cabinet", "drawer", "fridge", "dishwasher"})
_MASS = frozenset({"milk", "juice", "cereal", "bread"})


def noun(spec: ObjectSpec) -> str:
    """`small red cup`; a thing without a type is a `thing`."""
    size = "" if spec.size == "normal" else spec.size
    kind = (spec.type or "thing").replace("_", " ")
    return " ".join(word for word in (size, spec.color, kind) if word)


def the(spec: ObjectSpec) -> str:
    """`the small red cup`."""
    return f"the {noun(spec)}"


def an(spec: ObjectSpec) -> str:
    """`a small red cup`, `an orange bowl`, `some milk`, `some scissors`."""
    words = noun(spec)
    if spec.type in _MASS:
        return f"some {words}" if words == spec.type else f"the {words}"
    if is_plural(spec.type):
        return f"some {words}"
    return f"{'an' if words[0] in 'aeiou' else 'a'} {words}"


def an_existing(spec: ObjectSpec) -> str:
    """`some milk`, `a small red cup`: as one tells what there is."""
    return f"some {spec.type}" if spec.type in _MASS else an(spec)


def is_plural(name: str) -> bool:
    """Whether a thing is called by a plural: `scissors`, `keys`, but not `glass`."""
    return name.endswith("s") and not name.endswith("ss")


def be(subject: str) -> str:
    """`is` or `are`, as the subject needs it: `the cup`, `the scissors`, `the cup and the bowl`."""
    return "are" if is_plural(subject) or " and " in subject else "is"


def listed(items: Sequence[str], joint: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`."""
    if len(items) <= 1:
        return "".join(items)
    return f"{', '.join(items[:-1])} {joint} {items[-1]}"


def things(specs: Sequence[ObjectSpec], definite: Sequence[bool] = ()) -> str:
    """`the red cup, a spoon and two bowls`: definite where the person was, or where properties tell it apart."""
    words: list[str] = []
    seen: list[ObjectSpec] = []
    for index, spec in enumerate(specs):
        if spec in seen:
            continue
        seen.append(spec)
        count = list(specs).count(spec)
        if count > 1:
            words.append(f"{_NUMBERS.get(count, str(count))} {_plural(noun(spec))}")
        elif index < len(definite) and definite[index]:
            words.append(the(spec))
        else:
            words.append(an(spec))
    return listed(words)


def placed(specs: Sequence[ObjectSpec], name: Callable[[ObjectSpec], str], *, verb: bool = False) -> str:
    """`a red cup and a blue cup on the table and a mug in the cabinet`; with a verb `... are on the table and ...`."""
    at: dict[str, list[str]] = {}
    for spec in specs:
        at.setdefault(spec.location, []).append(name(spec))
    verbs = {place: f" {be(listed(names))}" if verb else "" for place, names in at.items()}
    return listed(
        [f"{listed(names)}{verbs[place]} {where(place) if place else 'in my hand'}" for place, names in at.items()]
    )


def counted(spec: ObjectSpec, count: int) -> str:
    """`four cups`, `two red cups`, `two kinds of milk`."""
    number = number_word(count)
    if spec.type in _MASS or is_plural(spec.type):
        return f"{number} kinds of {noun(spec)}"
    return f"{number} {_plural(noun(spec))}"


def choices(specs: Sequence[ObjectSpec]) -> str:
    """`the red cup or the blue one`: only what tells them apart."""
    words: list[str] = []
    same_type = len({spec.type for spec in specs}) == 1
    tell_color = len({spec.color for spec in specs}) > 1
    tell_size = len({spec.size for spec in specs}) > 1
    tell_place = same_type and not tell_color and not tell_size
    for index, spec in enumerate(specs):
        shown = ObjectSpec(
            type="one" if same_type and index else spec.type,
            color=spec.color if tell_color or not same_type else "",
            size=spec.size if tell_size else "",
        )
        name = noun(shown)
        if tell_size and spec.size == "normal" and not (tell_color and spec.color):
            name = f"normal {name}"
        place = f" {where(spec.location)}" if tell_place and spec.location else ""
        words.append(f"the {name}{place}")
    return listed(words, "or")


def where(place: str) -> str:
    """`on the table`, `in the fridge`."""
    return f"{'in' if place in _INSIDE else 'on'} the {place}" if place else "in its place"


def called(spec: ObjectSpec) -> str:
    """As people speak of it once it is clear which one: `the milk`, but `the red cup`."""
    return f"the {spec.type}" if spec.type in _MASS else the(spec)


def sentence_case(text: str) -> str:
    """With a capital letter at the beginning."""
    return text[:1].upper() + text[1:]


def number_word(count: int) -> str:
    """`one`, `two`, ... as far as people write them out."""
    return "one" if count == 1 else _NUMBERS.get(count, str(count))


_NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
_IRREGULAR = {"knife": "knives", "loaf": "loaves", "shelf": "shelves", "glass": "glasses"}


def _plural(words: str) -> str:
    *before, last = words.split()
    if is_plural(last):
        return words
    regular = f"{last}es" if last.endswith(("s", "x", "ch", "sh")) else f"{last}s"
    return " ".join([*before, _IRREGULAR.get(last, regular)])
