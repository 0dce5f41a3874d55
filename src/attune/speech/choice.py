"""Which recogniser listens, and why."""

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass

from attune.core.config import SpeechConfig
from attune.speech.recogniser import Recogniser
from attune.speech.sphinx import SphinxRecogniser


@dataclass(frozen=True, slots=True)
class ChosenRecogniser:
    """A recogniser and the reason for it.

    Attributes:
        reason: A clause for people: "PocketSphinx, because ...".
    """

    recogniser: Recogniser
    reason: str

    def __str__(self) -> str:
        """What listens and why, in one line."""
        return f"listening with {self.recogniser.name}, because {self.reason}"


def choose_recogniser(config: SpeechConfig, sentences: Sequence[str]) -> ChosenRecogniser:
    """The recogniser that the configuration asks for. `auto` takes Whisper when any of its weights are on this machine.

    The configured weights come first, then those of the installed package; only `whisper` fetches any. PocketSphinx
    takes about a second the first time, then 0.1 s; Whisper takes a second for the packaged weights.

    Args:
        config: Names the recogniser, and Whisper's weights.
        sentences: What people may say; see `SphinxRecogniser`.

    Raises:
        MissingDependencyError: It is not installed.
        WhisperWeightsError: The weights are not here and cannot be fetched.
        UnpronounceableWordError: A word of the sentences cannot be learned.
    """
    from attune.speech.whisper import WhisperRecogniser
    from attune.speech.whisper_weights import PACKAGED, cached_weights, fetch_weights, packaged_weights, require_whisper

    if config.asr == "whisper":
        require_whisper()
        weights = fetch_weights(config.whisper_model)
        return ChosenRecogniser(WhisperRecogniser(weights, sentences), "the configuration says so")
    if config.asr == "sphinx":
        return ChosenRecogniser(SphinxRecogniser(sentences), "the configuration says so")
    if importlib.util.find_spec("faster_whisper") is None:
        return ChosenRecogniser(SphinxRecogniser(sentences), "faster-whisper is not installed")
    if found := cached_weights(config.whisper_model):
        return ChosenRecogniser(WhisperRecogniser(found, sentences), "its weights are on this machine")
    absent = f"the weights of Whisper {config.whisper_model} are not on this machine"
    if found := packaged_weights():
        # So small a model loses more time with several threads, which wait for each other, than it gains.
        whisper = WhisperRecogniser(found, sentences, SphinxRecogniser(sentences, judges=False), threads=1)
        return ChosenRecogniser(whisper, f"{absent}, but those of {PACKAGED} are installed")
    return ChosenRecogniser(SphinxRecogniser(sentences), f"{absent}, nor are those of {PACKAGED}")
