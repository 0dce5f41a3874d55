"""Chooses the interpreter that the configuration asks for."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Literal

from attune.core.clock import Clock
from attune.core.config import LlmConfig
from attune.core.scene import Scene
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.interpreter import Interpreter
from attune.dialogue.llm import LlmInterpreter, neutral_style


@asynccontextmanager
async def chosen_interpreter(
    kind: Literal["auto", "grammar", "llm"],
    llm: LlmConfig,
    scene: Scene,
    clock: Clock,
    style: Callable[[], str] = neutral_style,
) -> AsyncIterator[Interpreter]:
    """The interpreter, while the block lasts.

    Args:
        kind: `auto` takes the language model if the configuration names an endpoint.
        llm: The endpoint.
        scene: Its words are known to the interpreter.
        clock: Real for the language model.
        style: How the language model shall speak; asked anew for each utterance.

    Raises:
        NoEndpointError: `llm` was asked for, but there is none.
        MissingDependencyError: The `openai` package is not installed.
    """
    lexicon = scene_lexicon(scene)
    embedded = GrammarInterpreter(lexicon)
    if kind == "grammar" or (kind == "auto" and not llm.base_url):
        yield embedded
        return
    interpreter = LlmInterpreter(llm, lexicon, embedded, clock, style)
    try:
        yield interpreter
    finally:
        await interpreter.close()
