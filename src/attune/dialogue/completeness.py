"""What a text so far is: a whole sentence or not, an order to stop or not. The speech side asks it as people speak."""

from collections.abc import Callable
from functools import lru_cache

from attune.core.scene import Scene
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter

_WHOLE = frozenset(
    {"bring_me", "setting_breakfast", "replace_object", "change_location", "stop", "carry_on", "put_back"}
)


def completeness(scene: Scene) -> Callable[[str], bool | None]:
    """A function that looks at a partial text.

    Returns:
        True for a whole command, False for a fragment such as "bring me the", None for anything else. Asked again with
        the same text, as happens at every audio frame, it does not think again.
    """
    interpreter = GrammarInterpreter(scene_lexicon(scene))

    @lru_cache(maxsize=64)
    def is_complete(text: str) -> bool | None:
        intent = interpreter.read(text).intent
        if intent in _WHOLE:
            return True
        return False if intent == "fragment" else None

    return is_complete


def reads_as_stop(scene: Scene) -> Callable[[str], bool]:
    """A function that tells whether a partial text is an order to stop, as far as it goes."""
    interpreter = GrammarInterpreter(scene_lexicon(scene))

    @lru_cache(maxsize=64)
    def is_stop(text: str) -> bool:
        return bool(text) and interpreter.read(text).intent == "stop"

    return is_stop
