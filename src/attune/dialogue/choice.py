"""Chooses the interpreter that the configuration asks for."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from attune.core.clock import Clock, RealClock
from attune.core.config import Config
from attune.core.scene import Scene
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.interpreter import Interpreter
from attune.dialogue.lexicon import load_lexicon
from attune.dialogue.llm import LlmInterpreter


def make_interpreter(config: Config, scene: Scene, clock: Clock) -> GrammarInterpreter | LlmInterpreter:
    """The interpreter of `dialogue.interpreter`.

    `auto` takes the language model if `llm.base_url` names one and the clock is real: a network knows no virtual time.
    A `LlmInterpreter` wants to be closed; it speaks in the neutral style until the bridge gives it the person's.

    Args:
        config: Names the interpreter, the lexicon and the endpoint.
        scene: Its words are known to the interpreter.
        clock: Real for the language model.

    Raises:
        NoEndpointError: The language model was asked for, but there is none.
        MissingDependencyError: The `openai` package is not installed.
    """
    kind = config.dialogue.interpreter
    path = config.dialogue.lexicon
    lexicon = scene_lexicon(scene, load_lexicon(Path(path) if path else None))
    embedded = GrammarInterpreter(lexicon)
    if kind == "grammar" or (kind == "auto" and not (config.llm.base_url and isinstance(clock, RealClock))):
        return embedded
    return LlmInterpreter(config.llm, lexicon, embedded, clock)


@asynccontextmanager
async def chosen_interpreter(config: Config, scene: Scene, clock: Clock) -> AsyncIterator[Interpreter]:
    """As `make_interpreter`, closed when the block ends."""
    interpreter = make_interpreter(config, scene, clock)
    try:
        yield interpreter
    finally:
        if isinstance(interpreter, LlmInterpreter):
            await interpreter.close()
