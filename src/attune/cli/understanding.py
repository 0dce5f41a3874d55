"""The file format of `attune understand`: reading a line, interpreting it, writing the result."""

import json
import os
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from attune.core.codec import describe
from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec, Size, Utterance
from attune.core.scene import load_scene
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.grammar.references import fits
from attune.dialogue.interpreter import Interpretation, Interpreter
from attune.dialogue.policies import load_policies
from attune.dialogue.repair import Repairer
from attune.dialogue.replies import Phrasebook
from attune.dialogue.wording import the, things, where

COMMANDS = frozenset({"bring_me", "setting_breakfast", "replace_object", "change_location", "stop"})
LONGEST = 2000
"""Characters of an utterance; nobody says more in one breath."""


class _Lenient(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class _Object(_Lenient):
    type: str = ""
    color: str = ""
    size: str = ""
    location: str = ""

    @field_validator("type", "color", "size", "location", mode="before")
    @classmethod
    def _nothing_is_empty(cls, value: Any) -> Any:
        return "" if value is None else value

    def spec(self) -> ObjectSpec:
        """As the interpreters take it."""
        size: Size = self.size if self.size in {"small", "normal", "big"} else ""  # type: ignore[assignment]
        return ObjectSpec(type=self.type.lower(), color=self.color.lower(), size=size, location=self.location.lower())


class _Task(_Lenient):
    command: str = "bring_me"
    objects: tuple[_Object, ...] = ()
    destination: str | None = ""

    def context(self) -> TaskContext:
        """As the interpreters take it."""
        return TaskContext(self.command, tuple(o.spec() for o in self.objects), self.destination or "")


class LineContext(_Lenient):
    """The situation in which a line was said."""

    task: _Task | None = None
    carrying: _Object | None = None
    delivered: tuple[_Object, ...] | None = ()
    last_robot_utterance: str | None = ""
    pending_question: str | None = None
    scene: tuple[_Object, ...] | None = ()

    def context(self) -> Context:
        """As the interpreters take it."""
        task = self.task.context() if self.task else None
        return Context(
            task=task,
            carrying=self.carrying.spec() if self.carrying else None,
            delivered=tuple(o.spec() for o in self.delivered or ()),
            last_robot_utterance=self.last_robot_utterance or "",
            pending_question=self.pending_question or "",
            scene=tuple(o.spec() for o in self.scene or ()),
        )


class _Line(_Lenient):
    id: Any = None
    utterance: str = Field(max_length=LONGEST)
    context: LineContext | None = None


async def interpret_lines(data: bytes, interpreter: Interpreter, emit: Callable[[str], None]) -> None:
    """Interpret each line that is not empty, in order.

    Args:
        data: JSON Lines.
        interpreter: Who interprets.
        emit: Takes each result, one line of JSON.
    """
    lexicon = scene_lexicon(load_scene())
    repairer, embedded = Repairer(lexicon), GrammarInterpreter(lexicon)
    replies = _Replies()
    for number, raw in enumerate(data.removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        if not raw.strip():
            continue
        try:
            line = _read(raw)
        except ValueError as error:
            emit(json.dumps({"line": number, "error": str(error)}, ensure_ascii=False))
            continue
        context = (line.context or LineContext()).context()
        meaning = await interpreter.interpret(line.utterance, context)
        heard = Utterance(time=0.0, text=line.utterance, typed=True)
        meaning = await repairer.repaired(meaning, heard, context, embedded)
        emit(json.dumps(_result(line, meaning, context, replies.reply(meaning)), ensure_ascii=False))


def _read(raw: bytes) -> _Line:
    try:
        data = json.loads(raw.decode("utf-8"))
    except UnicodeDecodeError:
        raise ValueError("this is not UTF-8 text") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"this is not JSON: {error.msg} at column {error.colno}") from None
    except RecursionError:
        raise ValueError("this JSON is nested too deeply") from None
    if not isinstance(data, dict):
        raise ValueError('this is no object; expected {"id", "utterance", "context"}')
    try:
        return _Line.model_validate(data)
    except ValidationError as error:
        raise ValueError("; ".join(describe(error))) from None


def _as_command(meaning: Interpretation, context: Context) -> dict[str, Any]:
    """The four fields of the format that say what was understood: command, add, remove, destination.

    The format has no word for leaving one thing out; where it was the only one, the task is given up.
    """
    task = context.task
    if meaning.intent == "cancel_object" and task is not None and task.objects:
        given_up = all(any(fits(spec, has) for spec in meaning.remove) for has in task.objects)
        meaning = replace(meaning, intent="stop", remove=()) if given_up else meaning
    known = meaning.intent in COMMANDS
    return {
        "command": meaning.intent if known else "other",
        "add": [_object(spec) for spec in meaning.add] if known and meaning.intent != "change_location" else [],
        "remove": [_object(spec) for spec in meaning.remove] if known else [],
        "destination": meaning.destination if known else "",
    }


def _result(line: _Line, meaning: Interpretation, context: Context, reply: str) -> dict[str, Any]:
    command = _as_command(meaning, context)
    return {
        "id": line.id,
        **command,
        "reply": reply,
        "confidence": round(meaning.confidence, 3),
        "reason": meaning.reason if command["command"] != "other" else f"{meaning.intent}: {meaning.reason}",
    }


def _object(spec: ObjectSpec) -> dict[str, str]:
    return {"type": spec.type, "color": spec.color, "size": spec.size, "location": spec.location}


class _Replies:
    """A reply in the neutral style for each meaning; nothing for what is not for the robot."""

    def __init__(self) -> None:
        self._phrasebook = Phrasebook()
        self._wording = load_policies().unknown.wording

    def reply(self, meaning: Interpretation) -> str:
        """What the robot would say."""
        if meaning.reply:
            return meaning.reply
        doubted = meaning.doubted
        meaning = doubted or meaning
        old = the(meaning.remove[0]) if meaning.remove else "that"
        slots = {
            "objects": things(meaning.add, meaning.definite),
            "to": f" to the {meaning.destination}" if meaning.destination else "",
            "old": old,
            "thing": old.removeprefix("the "),
            "place": f"the {meaning.destination}",
            "where": where(meaning.destination),
            "unknown": meaning.unknown or "such thing",
            "nearest": meaning.suggestion,
        }
        if doubted:
            return self._phrasebook.say("ask", f"whether_{doubted.intent}", self._wording, **slots)
        if meaning.suggestion:
            return self._phrasebook.say("ask", "repair", self._wording, **slots)
        for group, situation in (
            ("accept", meaning.intent), ("cannot", meaning.intent), ("talk", meaning.intent),
            ("talk", f"style_{meaning.style}"),
            ("ask", {"unclear": "which_object"}.get(meaning.intent, meaning.intent)),
        ):  # fmt: skip
            if self._phrasebook.has(group, situation):
                return self._phrasebook.say(group, situation, self._wording, **slots)
        return ""


def write_whole(target: Path, lines: Iterable[str]) -> None:
    """Write a file at once: it is either complete or as it was.

    Raises:
        AttuneError: It cannot be written there.
    """
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", dir=target.parent, prefix=f".{target.name}.", delete=False
        ) as file:
            temporary = Path(file.name)
            try:
                file.writelines(f"{line}\n" for line in lines)
            except BaseException:
                temporary.unlink(missing_ok=True)
                raise
        temporary.chmod(0o666 & ~_umask())
        os.replace(temporary, target)
    except OSError as error:
        raise AttuneError(
            f"{target} cannot be written: {error.strerror}", "Give a path in an existing folder"
        ) from None


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
