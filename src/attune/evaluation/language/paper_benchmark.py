"""The paper's benchmark of the dialogue bridge, generated from the templates in `data/benchmarks/language/paper.toml`.

Ten request templates give 800 instructions, fifteen replacement templates 1770, and there are 41 ways to ask for
breakfast. Each template is filled with every combination of the properties that it uses.
"""

import itertools
import tomllib
from collections.abc import Iterator
from importlib import resources
from typing import Literal

from pydantic import Field, ValidationError

from attune.core.codec import describe
from attune.evaluation.language.items import BenchmarkError, Item, Meaning, ObjectSlots, _Strict

Property = Literal["color", "size", "location"]


class _Prepositions(_Strict):
    at: str
    out: str


class _Template(_Strict):
    text: str
    says: dict[str, str] = Field(default_factory=dict)
    """Words that this template uses for property values."""


class _Request(_Template):
    uses: tuple[Property, ...]


class _Replacement(_Template):
    add: tuple[Property, ...]
    remove: tuple[Property, ...]
    same_type: bool = False
    """Whether the two objects differ in their properties instead of their type."""


class _Breakfast(_Strict):
    texts: tuple[str, ...]


class _PaperFile(_Strict):
    types: tuple[str, ...]
    colors: tuple[str, ...]
    sizes: tuple[str, ...]
    locations: tuple[str, ...]
    uncountable: tuple[str, ...]
    prepositions: dict[str, _Prepositions]
    request: tuple[_Request, ...]
    replace: tuple[_Replacement, ...]
    breakfast: _Breakfast

    def combinations(self, uses: tuple[Property, ...]) -> tuple[ObjectSlots, ...]:
        """Every object with the properties in use."""
        return tuple(
            ObjectSlots(type=type_, color=color, size=size, location=location)
            for type_, color, size, location in itertools.product(
                self.types,
                self.colors if "color" in uses else ("",),
                self.sizes if "size" in uses else ("",),
                self.locations if "location" in uses else ("",),
            )
        )

    def phrases(self, role: str, slots: ObjectSlots, says: dict[str, str]) -> dict[str, str]:
        """What the placeholders of one object are replaced by."""
        noun = " ".join(says.get(word, word) for word in (slots.size, slots.color, slots.type) if word)
        phrases = {role: noun, f"a {role}": f"{'some' if slots.type in self.uncountable else 'a'} {noun}"}
        if slots.location:
            place = says.get(slots.location, slots.location)
            preposition = self.prepositions[slots.location]
            phrases |= {
                "location": place,
                "at": f"{preposition.at} the {place}",
                "out": f"{preposition.out} the {place}",
            }
        return phrases


def paper_items() -> tuple[Item, ...]:
    """All 2611 instructions, each with empty context.

    Raises:
        BenchmarkError: The template file is wrong.
    """
    try:
        text = (resources.files("attune.data") / "benchmarks/language/paper.toml").read_text(encoding="utf-8")
        file = _PaperFile.model_validate(tomllib.loads(text))
    except ValidationError as error:
        raise BenchmarkError("paper.toml", describe(error)) from None
    pairs = itertools.chain(_requests(file), _replacements(file), _breakfasts(file))
    return tuple(
        Item(f"paper-{number:04}", "paper", meaning.command, sentence, meaning)
        for number, (sentence, meaning) in enumerate(pairs, 1)
    )


def _requests(file: _PaperFile) -> Iterator[tuple[str, Meaning]]:
    for template in file.request:
        for slots in file.combinations(template.uses):
            sentence = _fill(template.text, file.phrases("object", slots, template.says))
            yield sentence, Meaning(command="bring_me", add=(slots,))


def _replacements(file: _PaperFile) -> Iterator[tuple[str, Meaning]]:
    for template in file.replace:
        for add, remove in itertools.product(file.combinations(template.add), file.combinations(template.remove)):
            if add == remove or (add.type == remove.type) != template.same_type:
                continue
            phrases = file.phrases("add", add, template.says) | file.phrases("remove", remove, template.says)
            yield _fill(template.text, phrases), Meaning(command="replace_object", add=(add,), remove=(remove,))


def _breakfasts(file: _PaperFile) -> Iterator[tuple[str, Meaning]]:
    for sentence in file.breakfast.texts:
        yield sentence, Meaning(command="setting_breakfast")


def _fill(text: str, phrases: dict[str, str]) -> str:
    for name, phrase in phrases.items():
        text = text.replace(f"{{{name}}}", phrase)
    return text
