"""A small domain of its own, so that these tests do not move with the dialogue's phrasings."""

import itertools
from pathlib import Path

import pytest

from attune.speech.sphinx import SphinxRecogniser

THINGS = ("cup", "bowl", "spoon", "plate", "milk")
COLORS = ("", "red ", "green ", "blue ")


@pytest.fixture(scope="session")
def domain() -> list[str]:
    """A few hundred ways to ask for things, and the stop words."""
    asked = ["bring me a {}", "please bring me the {}", "i would like a {} instead", "get the {} from the table"]
    things = ["".join(pair) for pair in itertools.product(COLORS, THINGS)]
    others = ["stop", "please stop", "stop it", "don't stop", "wait", "hold on", "freeze", "thank you"]
    others += ["please make breakfast", "set the table for breakfast", "put it on the table", "yes", "no"]
    return [sentence.format(thing) for sentence in asked for thing in things] + others * 5


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@pytest.fixture
def recogniser(domain: list[str], cache: Path) -> SphinxRecogniser:
    """A recogniser that has not heard anybody yet."""
    return SphinxRecogniser(domain, cache)
