"""Whether what was said so far is a whole sentence: it tells the speech side how long a pause may be."""

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
