"""Which recogniser listens."""

from collections.abc import Sequence
from typing import Literal

from attune.core.errors import MissingDependencyError
from attune.speech.recogniser import Recogniser
from attune.speech.sphinx import SphinxRecogniser


def make_recogniser(asr: Literal["auto", "sphinx", "whisper"], sentences: Sequence[str]) -> Recogniser:
    """The recogniser that the configuration asks for. Takes about a second the first time, then 0.1 s.

    Args:
        asr: `auto` is PocketSphinx, because no other recogniser's weights are here.
        sentences: What people may say; see `SphinxRecogniser`.

    Raises:
        MissingDependencyError: It is not installed.
        UnpronounceableWordError: A word of the sentences cannot be learned.
    """
    if asr == "whisper":
        raise MissingDependencyError(
            "the Whisper recogniser",
            "`asr = whisper`",
            "This version listens with PocketSphinx only: set `speech.asr` to sphinx or auto",
        )
    return SphinxRecogniser(sentences)
