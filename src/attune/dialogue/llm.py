"""The interpreter that asks a language model, with the embedded interpreter at its side.

The embedded interpreter reads every utterance first: an order to stop never waits for a network. It also answers
whenever the model does not, so that a person is always understood.
"""

import json
import tomllib
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import cache
from importlib import resources
from string import Template
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from attune.core.clock import Clock, RealClock
from attune.core.config import LlmConfig
from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.interpreter import Intent, Interpretation, Interpreter
from attune.dialogue.lexicon import Lexicon
from attune.dialogue.llm_answer import ModelAnswer, answer_schema, to_interpretation
from attune.dialogue.llm_endpoint import Endpoint, Message, NoAnswerError
from attune.dialogue.policies import Announce, Policy, Wording, load_policies

SETTLED: frozenset[Intent] = frozenset({"stop", "stated_age"})
"""What the embedded interpreter decides alone: safety first, and what the model's answer has no field for."""
FAILURES_UNTIL_REST = 3
REST = 30.0
"""After so many failures in a row the endpoint is not asked for this long [s]."""
SLOW = 150
"""Speaking rate up to which a person wants it slowly [words per minute]."""


class _Style(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    wording: dict[Wording, str]
    announce: dict[Announce, str]
    pace: dict[Literal["slow"], str]


@cache
def _style_file() -> _Style:
    text = (resources.files("attune.data") / "prompts/style.toml").read_text(encoding="utf-8")
    return _Style.model_validate(tomllib.loads(text))


class _Example(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    situation: dict[str, Any] = {}
    utterance: str
    answer: dict[str, Any]

    def written(self) -> str:
        """As the model sees it: its input and the whole answer, with empty fields."""
        wanted = {"type": "", "color": "", "size": "", "location": ""}
        whole: dict[str, Any] = {"add": [], "remove": [], "destination": "", "style": "", "status": "", "reply": ""}
        answer = whole | self.answer
        for field in ("add", "remove"):
            answer[field] = [wanted | named for named in answer[field]]
        shown = ModelAnswer.model_validate_json(_json(answer)).model_dump_json()
        return f"Input: {_json({'situation': self.situation, 'utterance': self.utterance})}\nAnswer: {shown}"


@cache
def _examples() -> str:
    text = (resources.files("attune.data") / "prompts/examples.toml").read_text(encoding="utf-8")
    examples = [_Example.model_validate(example) for example in tomllib.loads(text)["examples"]]
    return "\n".join(example.written() for example in examples)


@cache
def _instructions() -> Template:
    return Template((resources.files("attune.data") / "prompts/interpreter.md").read_text(encoding="utf-8"))


def describe_style(policy: Policy) -> str:
    """How to speak to a person, in words for the model, from the policy that follows their age and their wishes."""
    file = _style_file()
    slow = (file.pace["slow"],) if policy.rate <= SLOW else ()
    return " ".join([file.wording[policy.wording], file.announce[policy.announce], *slow])


def neutral_style() -> str:
    """How to speak to somebody of whom nothing is known."""
    return describe_style(load_policies().unknown)


class LlmInterpreter:
    """Asks a language model what an utterance means.

    Args:
        config: The endpoint.
        lexicon: The words of the kitchen, those of the scene included.
        embedded: Decides about stopping, and answers when the model does not.
        clock: A real clock: a network does not run in virtual time.
        style: How to speak to the person now, in words; asked anew for each request. See `describe_style`.

    Raises:
        NoEndpointError: The configuration names no base URL or no model.
        MissingDependencyError: The `openai` package is not installed.
    """

    def __init__(
        self,
        config: LlmConfig,
        lexicon: Lexicon,
        embedded: Interpreter,
        clock: Clock,
        style: Callable[[], str] = neutral_style,
    ) -> None:
        self._endpoint = Endpoint(config, clock)
        self._lexicon = lexicon
        self._embedded = embedded
        self._clock = clock
        self.style = style
        self._history: deque[tuple[Message, Message]] = deque(maxlen=config.history)
        self._failures = 0
        self._rest_until = 0.0

    async def close(self) -> None:
        """Close the connections to the endpoint."""
        await self._endpoint.close()

    def forget(self) -> None:
        """Leave out of further requests what was said up to now."""
        self._history.clear()

    async def interpret(self, text: str, context: Context) -> Interpretation:
        """What `text` means, decided by the model if it answers in time, else by the embedded interpreter."""
        first = await self._embedded.interpret(text, context)
        if first.intent in SETTLED:
            return first
        if self._clock.now() < self._rest_until:
            return replace(first, reason=f"{first.reason} (the language model is left alone for a while)")
        known = self._lexicon.extended(context.scene)
        try:
            answer = await self._endpoint.ask(self._messages(text, context, known), answer_schema(known))
        except NoAnswerError as error:
            self._failures += 1
            if self._failures >= FAILURES_UNTIL_REST:
                self._failures = 0
                self._rest_until = self._clock.now() + REST
            return replace(first, reason=f"{first.reason} ({error.problem})")
        self._failures = 0
        said: Message = {"role": "user", "content": _json({"utterance": text})}
        self._history.append((said, {"role": "assistant", "content": answer.model_dump_json()}))
        found = to_interpretation(answer, context, self._lexicon, f"language model {self._endpoint.name}")
        # "The" or "a" is a matter of words, which the embedded interpreter reads.
        return replace(found, definite=first.definite) if len(first.definite) == len(found.add) else found

    def _messages(self, text: str, context: Context, known: Lexicon) -> list[Message]:
        # The instructions and the style are written anew each time: they cannot fade behind a long talk.
        style = self.style()
        instructions = _instructions().substitute(
            types=", ".join(known.values("type")),
            colors=", ".join(known.values("color")),
            places=", ".join(known.values("place")),
            examples=_examples(),
            style=style,
        )
        earlier = [message for turn in self._history for message in turn]
        asked = {"situation": _situation(context), "utterance": text, "speak": style}
        return [
            {"role": "system", "content": instructions},
            *earlier,
            {"role": "user", "content": _json(asked)},
        ]


def _json(data: object) -> str:
    # Half a surrogate pair, as a broken terminal may send it, is no text that can travel.
    return json.dumps(data, ensure_ascii=False).encode("utf-8", "replace").decode()


def _situation(context: Context) -> dict[str, object]:
    task = context.task
    situation = {
        "task": task and {
            "command": task.command,
            "objects": [_described(spec) for spec in task.objects],
            "destination": task.destination,
        },
        "carrying": context.carrying and _described(context.carrying),
        "delivered": [_described(spec) for spec in context.delivered],
        "last_robot_utterance": context.last_robot_utterance,
        "pending_question": context.pending_question,
        "scene": [_described(spec) for spec in context.scene],
    }  # fmt: skip
    return {name: value for name, value in situation.items() if value}


def _described(spec: ObjectSpec) -> dict[str, str]:
    return {key: value for key, value in asdict(spec).items() if value and key != "name"}


class _NoInterpreter:
    """Stands in where only the endpoint is looked at."""

    async def interpret(self, text: str, context: Context) -> Interpretation:
        return Interpretation(intent="unclear", reason="no answer")


async def check_endpoint(config: LlmConfig, lexicon: Lexicon) -> tuple[bool, str]:
    """Try the endpoint with one simple request, as the interpreter would ask it.

    Returns:
        Whether it answers correctly in time, and one sentence about it.
    """
    clock = RealClock()
    try:
        interpreter = LlmInterpreter(config, lexicon, _NoInterpreter(), clock)
    except AttuneError as error:
        return False, str(error)
    started = clock.now()
    try:
        found = await interpreter.interpret("Bring me the red cup, please.", Context())
    finally:
        await interpreter.close()
    took = clock.now() - started
    if found.intent == "unclear" and not found.reply:
        return False, f"{config.model} at {config.base_url}: {found.reason}"
    if found.intent != "bring_me" or [spec.type for spec in found.add] != ["cup"]:
        return False, f"{config.model} at {config.base_url} answers, but misunderstands a simple request"
    return True, f"{config.model} at {config.base_url} answers in {took:.1f} s"
