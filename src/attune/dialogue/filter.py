"""Decides what is none of the robot's business: noise, background talk, backchannels. Each decision has a reason."""

from dataclasses import dataclass
from typing import Literal

from attune.core.config import DialogueConfig
from attune.core.messages import Utterance
from attune.dialogue.interpreter import Intent, Interpretation

Verdict = Literal["act", "ask", "wait", "ignore"]

_SILENT: dict[Intent, str] = {
    "talk": "not meant for the robot",
    "backchannel": "only shows that somebody listens",
    "question": "a question that is not about the robot or its kitchen",
}
_WORTH_ASKING: frozenset[Intent] = frozenset({"unclear", "unknown_object", "unknown_action"})


@dataclass(frozen=True, slots=True)
class Decision:
    """What to do with an utterance.

    Attributes:
        verdict: `act` on it, `ask` back, `wait` for its continuation, or `ignore` it.
        reason: Why, in one clause, without the words that were said.
    """

    verdict: Verdict
    reason: str = ""


class Filter:
    """Keeps noise from the robot.

    Args:
        config: The thresholds.
    """

    def __init__(self, config: DialogueConfig) -> None:
        self._config = config

    def hears_nothing(self, utterance: Utterance) -> str:
        """Why the audio is not worth interpreting, or ""."""
        if not utterance.text.strip():
            return "no words"
        if utterance.typed:
            return ""
        if not utterance.in_domain:
            return "sounds unlike talk about the kitchen"
        if utterance.confidence < self._config.confidence_ignore:
            return f"recognised with a confidence of only {utterance.confidence:.2f}"
        return ""

    def decide(self, utterance: Utterance, meaning: Interpretation, *, expecting: bool) -> Decision:  # noqa: PLR0911 - one rule per return
        """What to do with an utterance that was interpreted.

        Args:
            utterance: What was heard.
            meaning: What it seems to mean.
            expecting: The robot has asked something and waits for an answer.
        """
        sure = 1.0 if utterance.typed else utterance.confidence
        if meaning.intent == "fragment":
            return Decision("wait", meaning.reason)
        if meaning.intent in _SILENT:
            return Decision("ignore", f"{_SILENT[meaning.intent]} ({meaning.reason})")
        if meaning.intent in {"affirm", "deny"} and not expecting:
            return Decision("ignore", "an answer to nothing that was asked")
        if meaning.intent in {"thanks", "greeting"} and sure < self._config.confidence_ask:
            return Decision("ignore", "a politeness that was heard badly")
        if meaning.intent in _WORTH_ASKING:
            # Whoever mumbles in the background is not asked back.
            if sure >= self._config.confidence_ask:
                return Decision("ask", meaning.reason)
            return Decision("ignore", f"{meaning.reason}, and heard badly")
        if sure < self._config.confidence_ask and meaning.intent != "stop":
            return Decision("ask", f"recognised with a confidence of only {sure:.2f}")
        return Decision("act", meaning.reason)
