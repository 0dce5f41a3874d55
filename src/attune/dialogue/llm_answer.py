"""What a language model must answer, and the check of it against the schema, the vocabulary and the situation.

Between a language model and the robot stands a list: an answer that names anything else becomes a question to the
person, never a command.
"""

from collections.abc import Iterable
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator, model_validator
from pydantic_core import from_json

from attune.core.codec import describe
from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec, Size
from attune.dialogue.context import Context
from attune.dialogue.interpreter import Intent, Interpretation, StatusTopic, StyleWish
from attune.dialogue.lexicon import Group, Lexicon

MOST_OBJECTS = 8
LONGEST_NAME = 40
LONGEST_REPLY = 300
"""Characters of a reply; the rest is not spoken."""
CONFIDENCE = 0.9
"""Of a valid answer. What a model says about its own confidence means little."""

ModelIntent = Literal[
    "bring_me", "setting_breakfast", "replace_object", "change_location", "stop", "cancel_object", "put_back",
    "carry_on", "dont_stop", "repeat", "status", "style", "thanks", "greeting", "affirm", "deny", "fragment",
    "unknown_object", "unknown_action", "unclear", "question", "backchannel", "talk",
]  # fmt: skip
"""The intents that a model may choose."""


class InvalidAnswerError(AttuneError):
    """The model's answer does not fit the schema."""

    def __init__(self, errors: list[str]) -> None:
        super().__init__(f"the language model's answer is not valid: {'; '.join(errors)}")


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Wanted(_Strict):
    type: str
    color: str
    size: Size
    location: str

    @field_validator("type", "color", "location")
    @classmethod
    def _is_a_name(cls, value: str) -> str:
        name = " ".join(value.lower().replace("_", " ").split())
        if len(name) > LONGEST_NAME or not name.isprintable():
            raise ValueError("this is no name")
        return name


class ModelAnswer(_Strict):
    """The answer of a language model. The order of the fields is the order in which they are written."""

    intent: ModelIntent
    add: tuple[_Wanted, ...]
    remove: tuple[_Wanted, ...]
    destination: str
    style: StyleWish
    status: StatusTopic
    answers: bool = False
    unknown: str = ""
    reply: str

    @model_validator(mode="after")
    def _makes_sense(self) -> "ModelAnswer":
        if max(len(self.add), len(self.remove)) > MOST_OBJECTS:
            raise ValueError("too many objects")
        for field in ("destination", "unknown"):
            if len(getattr(self, field)) > LONGEST_NAME:
                raise ValueError(f"{field} is no name")
        needed = {
            "bring_me": bool(self.add) and all(wanted.type for wanted in self.add),
            "replace_object": len(self.add) == 1 and len(self.remove) <= 1 and bool(self.add[0].type),
            "change_location": bool(self.destination.strip()),
            "cancel_object": bool(self.remove),
            "style": bool(self.style),
        }
        if not needed.get(self.intent, True):
            raise ValueError(f"{self.intent} lacks what it is about")
        return self


def answer_schema(lexicon: Lexicon) -> dict[str, Any]:
    """The JSON schema that the endpoint is asked to keep to.

    It lists every name, so that an endpoint that keeps to it cannot invent one; other things go into `unknown`.

    Args:
        lexicon: The names that may occur.
    """
    places = _one_of(lexicon.values("place"))
    wanted = {
        "type": "object",
        "properties": {
            "type": _one_of(lexicon.values("type")),
            "color": _one_of(lexicon.values("color")),
            "size": _one_of(get_args(Size)),
            "location": places,
        },
        "required": ["type", "color", "size", "location"],
        "additionalProperties": False,
    }
    properties: dict[str, Any] = {
        "intent": {"type": "string", "enum": list(get_args(ModelIntent))},
        "add": {"type": "array", "items": wanted, "maxItems": MOST_OBJECTS},
        "remove": {"type": "array", "items": wanted, "maxItems": MOST_OBJECTS},
        "destination": places,
        "style": _one_of(get_args(StyleWish)),
        "status": _one_of(get_args(StatusTopic)),
        "answers": {"type": "boolean"},
        "unknown": {"type": "string"},
        "reply": {"type": "string"},
    }
    return {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def _one_of(names: Iterable[str]) -> dict[str, Any]:
    return {"type": "string", "enum": ["", *(name for name in names if name)]}


def parse_answer(text: str) -> ModelAnswer:
    """The answer in `text`, as the endpoint sent it.

    Raises:
        InvalidAnswerError: It is no JSON, or does not fit the schema.
    """
    try:
        return ModelAnswer.model_validate_json(_bare(text))
    except ValidationError as error:
        raise InvalidAnswerError(describe(error)[:1]) from None


def parse_decision(text: str) -> ModelAnswer | None:
    """The decision in the beginning of an answer, when everything but the reply is there already; else None."""
    try:
        data = from_json(_bare(text), allow_partial="trailing-strings")
    except ValueError:
        return None
    if not isinstance(data, dict) or list(data)[-1:] != ["reply"]:
        return None
    try:
        # Half a sentence is not spoken: the dialogue writes its own reply.
        return ModelAnswer.model_validate(data | {"reply": ""})
    except ValidationError:
        return None


def is_truncated(text: str) -> bool:
    """Whether the text is the beginning of a JSON object that was cut off."""
    try:
        from_json(_bare(text))
    except ValueError:
        try:
            from_json(_bare(text), allow_partial=True)
        except ValueError:
            return False
        return True
    return False


def to_interpretation(answer: ModelAnswer, context: Context, lexicon: Lexicon, reason: str) -> Interpretation:
    """What the answer means, with every name checked; a question where a name is unknown.

    Args:
        answer: A valid answer.
        context: The situation; it brings types and places of its own.
        lexicon: The words that are known anyway.
        reason: For the log.
    """
    known = lexicon.extended(context.scene)
    intent: Intent = answer.intent
    slots = _SLOTS.get(intent, frozenset())
    asked = {"add": answer.add if "add" in slots else (), "remove": answer.remove if "remove" in slots else ()}
    for wanted in (*asked["add"], *asked["remove"]):
        for group, name in (("type", wanted.type), ("color", wanted.color), ("place", wanted.location)):
            if name and not canonical(known, group, name):
                return _unknown(group, name, reason)
    destination = answer.destination if "destination" in slots else ""
    place = canonical(known, "place", destination)
    if destination.strip() and not place:
        return _unknown("place", destination, reason)
    add = tuple(_spec(known, wanted) for wanted in asked["add"])
    remove = tuple(_spec(known, wanted) for wanted in asked["remove"])
    if intent == "replace_object" and not remove and context.recent:
        recent = context.recent[0]
        remove = (ObjectSpec(type=recent.type, color=recent.color, size=recent.size),)
    return Interpretation(
        intent=intent, add=add, remove=remove, destination=place, reply=_spoken(answer.reply), confidence=CONFIDENCE,
        reason=reason, definite=(False,) * len(add), style=answer.style if intent == "style" else "",
        status=answer.status if intent == "status" else "",
        unknown=answer.unknown if intent == "unknown_object" else "",
        answers=answer.answers and intent == "bring_me" and bool(context.pending_question),
    )  # fmt: skip


_SLOTS: dict[Intent, frozenset[str]] = {
    "bring_me": frozenset({"add", "destination"}),
    "replace_object": frozenset({"add", "remove", "destination"}),
    "change_location": frozenset({"destination"}),
    "cancel_object": frozenset({"remove"}),
    "put_back": frozenset({"remove"}),
}
"""What each intent may carry; anything else in an answer is dropped."""


def canonical(lexicon: Lexicon, group: Group | str, name: str) -> str:
    """The name that Attune uses for what a person or a model calls `name`; "" if there is none."""
    words = name.lower().replace("_", " ").replace("-", " ").split()
    for start in (1, 0) if words[:1] in (["the"], ["a"], ["some"]) else (0,):
        entry = lexicon.phrases.get(tuple(words[start:]))
        if entry is not None and entry.group == group:
            return entry.value
    return ""


def _spec(lexicon: Lexicon, wanted: _Wanted) -> ObjectSpec:
    return ObjectSpec(
        type=canonical(lexicon, "type", wanted.type),
        color=canonical(lexicon, "color", wanted.color),
        size=wanted.size,
        location=canonical(lexicon, "place", wanted.location),
    )


def _unknown(group: str, name: str, reason: str) -> Interpretation:
    name = " ".join(name.split())
    what = {"type": "what that is", "color": "that colour", "place": "that place"}[group]
    return Interpretation(
        intent="unknown_object" if group == "type" else "unclear",
        unknown=name,
        reply=f"You said {name}, but I do not know {what}. Could you say it in other words?",
        confidence=CONFIDENCE,
        reason=f"{reason}; {group} {name!r} is not known",
    )


def _spoken(reply: str) -> str:
    text = " ".join("".join(letter if letter.isprintable() else " " for letter in reply).split())
    return text if len(text) <= LONGEST_REPLY else text[:LONGEST_REPLY].rsplit(". ", 1)[0]


def _bare(text: str) -> str:
    # Endpoints that do not keep to the schema like to wrap their JSON in a code block.
    stripped = text.strip()
    if stripped.startswith("```"):
        return stripped.removeprefix("```json").removeprefix("```").removesuffix("```").strip()
    return stripped
