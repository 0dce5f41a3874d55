"""Whatever fills them, the robot's sentences are sentences: articles, plurals, verbs, punctuation."""

import random
import re

import pytest

from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.dialogue.replies import Phrasebook, sentences
from attune.dialogue.wording import an, an_existing, called, choices, counted, noun, placed, the, things, where

SCENE = [ObjectSpec(type=o.type, color=o.color, size=o.size, location="table") for o in load_scene().objects]
STRANGE = [
    ObjectSpec(type="apple", color="orange"), ObjectSpec(type="scissors"), ObjectSpec(type="glass"), ObjectSpec(),
    ObjectSpec(type="hair_dryer", size="big"), ObjectSpec(color="red"), ObjectSpec(type="milk"),
    ObjectSpec(type="loaf"),
]  # fmt: skip
WRONG = {
    "an article that does not fit": r"\ba [aeiou]|\ban [^aeiou]",
    "an article before a plural": r"\b(?:a|an) (?:\w+ )?(?:cups|bowls|spoons|scissors|glasses|knives)\b",
    "a verb that does not fit": r"\b(?:spoons|cups|scissors|knives|glasses) is\b|\b(?:the|a) \w+(?<!s) are\b",
    "two articles": r"\b(?:the|a|an|some|no|any|further|one) (?:the|a|an|some)\b",
    "a space before punctuation, or two": r" [.,?!:]|  ",
    "an open slot": r"[{}]",
    "a plural that is none": r"\b(?:knifes|glasss|loafs|milkes)\b",
    "no capital letter at the beginning": r"^[^A-Z]",
    "no end": r"[^.?!]$",
    "a word twice": r"\b(\w+) \1\b",
    "an underscore": r"_",
}


def slots(draw: random.Random) -> dict[str, str]:
    first, second = draw.choice([*SCENE, *STRANGE]), draw.choice([*SCENE, *STRANGE])
    place = draw.choice(["table", "fridge", "countertop", "drawer"])
    wanted = draw.choice([(first,), (first, second), (first, first), (second, second, first)])
    to = draw.choice(["", f" to the {place}"])
    return {
        "objects": things(wanted, [draw.random() < 0.3 for _ in wanted]),
        "object": called(first) if draw.random() < 0.5 else the(first),
        "old": called(second), "to": to, "to_now": to, "place": f"the {place}", "where": where(place),
        "options": choices(draw.sample(SCENE, draw.randint(2, 4))), "nearest": the(second), "unknown": "tea pot",
        "thing": noun(first), "done": "Two of three", "all": counted(first, 2), "wish": "louder",
        "doing": "I'm getting ready.", "question": "Would you like the red cup?",
        "kept": "that you like to be told little",
    }  # fmt: skip


def test_every_sentence_is_one_with_whatever_fills_it() -> None:
    draw = random.Random(5)
    book = Phrasebook()
    spoken: set[str] = set()
    for group, situation, wording, count in sentences():
        for _ in range(30 * count):
            filled = slots(draw)
            if group == "ask":  # Of what is not there, the bare noun: "I know of no red cup".
                filled["object"] = noun(draw.choice(SCENE))
            if situation == "unknown_place":
                filled["place"] = "attic"
            spoken.add(book.say(group, situation, wording, **filled))
    assert len(spoken) > 2000
    for fault, pattern in WRONG.items():
        wrong = [text for text in spoken if re.search(pattern, text)]
        assert not wrong, f"{fault}: {wrong[:3]}"


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (an(ObjectSpec(type="cup", color="orange")), "an orange cup"),
        (an(ObjectSpec(type="scissors")), "some scissors"),
        (an_existing(ObjectSpec(type="milk", color="blue")), "some milk"),
        (things([ObjectSpec(type="knife")] * 2), "two knives"),
        (things([ObjectSpec(type="milk")] * 2), "two milks"),
        (things([ObjectSpec(type="cup", color="red"), ObjectSpec(type="spoon")], [True]), "the red cup and a spoon"),
        (counted(ObjectSpec(type="cup"), 4), "four cups"),
        (counted(ObjectSpec(type="milk"), 2), "two kinds of milk"),
        (placed(SCENE[:2], the, verb=True), "the white bowl and the green cereal are on the table"),
        (placed([ObjectSpec(type="cup")], the, verb=True), "the cup is in my hand"),
        (choices([ObjectSpec(type="cup", location="table"), ObjectSpec(type="cup", location="fridge")]),
         "the cup on the table or the one in the fridge"),
    ],
)  # fmt: skip
def test_words_are_put_together_as_people_do(words: str, expected: str) -> None:
    assert words == expected


def test_where_there_is_a_choice_no_sentence_comes_twice_in_a_row() -> None:
    book = Phrasebook()
    for group, situation, wording, count in sentences():
        said = [book.say(group, situation, wording, **slots(random.Random(1))) for _ in range(6)]
        assert count == 1 or all(one != next_ for one, next_ in zip(said, said[1:], strict=False)), (group, situation)
