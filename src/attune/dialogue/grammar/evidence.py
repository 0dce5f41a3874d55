"""Evidence in an utterance that something is, or is not, asked of the robot: signs that hold for whatever is named.

"Bring me the cup" is an order; "he said bring me the cup", "tomorrow I'll bring the cup" and "if you bring a cup"
are none, and what makes the difference is not the words of the request but those around it.
"""

from collections.abc import Container, Iterator, Sequence

from attune.dialogue.words import words

_REPORTS = words(
    "said says say saying told tells telling asked asks goes went heard hear whispered shouted shouts yelled cried "
    "sighed replied answered wrote writes writing quote called calls mentioned explained claims thinks thought "
    "wondered read reads sang sings song story film movie book joke word words"
)
_PAST = words(
    "was were had did went came took brought got gave put left found made saw ate drank broke dropped kept bought "
    "lost forgot knew ran sat stood felt meant used began fell spilled spilt threw cut set told said asked wanted "
    "needed liked washed thought never always once ago yesterday last before when back"
)
_LATER = words(
    "tomorrow tonight later soon next weekend week month year someday monday tuesday wednesday thursday friday "
    "saturday sunday christmas easter birthday summer winter autumn spring evening afternoon morning noon oclock "
    "until after before while during whenever eventually"
)
_SUPPOSES = words("if suppose supposing imagine unless whether would could might maybe perhaps wish hope pretend as")
_ELSEWHERE = words(
    "shop shops store supermarket market bakery baker restaurant cafe hotel office work school town city park garden "
    "street road station bus train car hospital church pub party picnic camping holiday trip home house upstairs "
    "downstairs bathroom bedroom phone television tv radio news traffic internet online video"
)
_OTHERS = words("he she they him her them his hers their theirs himself herself themselves everybody everyone nobody "
                "somebody someone who people man woman boy girl guy lady kids child children baby dog cat")  # fmt: skip
_OURSELVES = words("we us our ours ourselves let")
_MYSELF = words("i me my mine myself")
_FIGURES = words(
    "two three four five six seven eight nine ten eleven twelve fifteen twenty thirty forty fifty hundred thousand "
    "million half quarter first second third percent degrees minutes minute hours hour days grams gram kilo kilos "
    "litre litres millilitres tablespoon tablespoons teaspoon teaspoons euros euro pounds dollars cents"
)
_COOKING = words(
    "stir boil simmer bake fry roast whisk knead chop slice dice mince season sprinkle preheat oven dough flour eggs "
    "egg butter sugar salt pepper sauce soup mixture recipe cook cooking serve pour heat pan pot tin tray grease fold "
    "beat drain rinse soak melt cool rest"
)
_SIGNS: tuple[tuple[str, frozenset[str]], ...] = (
    ("reports", _REPORTS), ("past", _PAST), ("later", _LATER), ("supposes", _SUPPOSES), ("elsewhere", _ELSEWHERE),
    ("others", _OTHERS), ("ourselves", _OURSELVES), ("myself", _MYSELF), ("figures", _FIGURES), ("cooking", _COOKING),
)  # fmt: skip
_GRAMMAR = words(
    "i you it we he she they me him her us them my your his our their this that these those the a an some any no not "
    "is are am was were be been being do does did have has had can could would will shall should may might must "
    "to of in on at for from with by about into out up down off over back and or but so then if when while because "
    "than as what where who which how why please thanks thank okay yes oh well now just here there too also again "
    "instead more another other one let us sorry wait stop like want need get got go going come"
)
_ENDINGS = ("ing", "ed", "ly", "s")
_GROUP_OF = {word: name.upper() for name, group in reversed(_SIGNS) for word in group}
_BREAKS = frozenset({",", ".", "?", "and", "but", "so", "then", "or", "because"})
_ASKING = frozenset({"FETCH", "PUT", "SWAP", "DROP"})
_NO_SUBJECTS = frozenset({"please", "just", "now", "well", "oh", "yes", "no", "okay", "actually", "sorry", "also"})
_FAR = 6
_MANY = 4


def abstract(kinds: Sequence[str], familiar: Container[str]) -> list[str]:
    """The words with all that carry no grammar reduced to what kind of word they are, for sentences with new words.

    Args:
        kinds: The words of an utterance, by their kinds where they have one.
        familiar: The words that people use in commands.
    """
    return [
        word
        if word in _GRAMMAR or not word.islower() or not word.isalpha()
        else _GROUP_OF.get(word) or _shape(word, familiar)
        for word in kinds
    ]


def _shape(word: str, familiar: Container[str]) -> str:
    ending = next((ending for ending in _ENDINGS if word.endswith(ending)), "")
    return f"{'usual' if word in familiar else 'STRANGE'}-{ending}"


def signs(plain: Sequence[str], kinds: Sequence[str], familiar: Container[str]) -> Iterator[str]:
    """The signs in one utterance.

    Args:
        plain: Its skeleton's words, with all things as `T` and all places as `P`.
        kinds: The same words by their kinds.
        familiar: The words that people use in commands.
    """
    first_thing = next((at for at, word in enumerate(plain) if word == "T"), len(plain))
    found = {name for name, group in _SIGNS for word in plain if word in group}
    early = {name for name, group in _SIGNS for word in plain[:first_thing] if word in group}
    if any(word.endswith("ed") and word not in familiar for word in plain):
        found.add("past")
    yield from (f"sign {name}" for name in found)
    yield from (f"sign early {name}" for name in early)
    yield f"signs {min(len(found), _MANY)}"
    strange = sum(word not in familiar and word.isalpha() and word not in {"T", "P"} for word in plain)
    strange_early = sum(word not in familiar and word.isalpha() and word != "P" for word in plain[:first_thing])
    yield f"strange {min(strange, _MANY)}"
    yield f"strange early {min(strange_early, 2)}"
    yield from (f"strange {count} or more" for count in range(1, min(strange, _MANY) + 1))
    starts = True
    clause = 0
    for at, kind in enumerate(kinds):
        if starts and kind not in _BREAKS and kind not in _NO_SUBJECTS:
            following = kinds[at + 1] if at + 1 < len(kinds) else ">"
            yield f"begins {kind}"
            yield f"begins {kind} {following}"
            yield f"clause {min(clause, 2)} begins {kind}"
            clause += 1
            starts = False
        if kind in _BREAKS:
            starts = True
    yield f"clauses {min(clause, _MANY)}"
    asking = next((at for at, kind in enumerate(kinds) if kind in _ASKING), None)
    yield f"asks at {min(asking, _FAR) if asking is not None else 'never'}"
    if asking is not None:
        yield from (f"{name} before asking" for name, group in _SIGNS if any(word in group for word in kinds[:asking]))
