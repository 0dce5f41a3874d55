"""What an interpreter is: it turns what a person said into what the person wants."""

from dataclasses import dataclass
from typing import Literal, Protocol

from attune.core.messages import Band, ObjectSpec
from attune.dialogue.context import Context

CommandIntent = Literal["bring_me", "setting_breakfast", "replace_object", "change_location", "stop", "other"]
"""The intents of the file format of `attune understand`."""

Intent = Literal[
    "bring_me", "setting_breakfast", "replace_object", "change_location", "stop",
    "cancel_object", "put_back", "carry_on", "dont_stop", "repeat", "status", "style", "stated_age", "thanks",
    "greeting",
    "affirm", "deny", "fragment", "unknown_object", "unknown_action", "unclear", "question", "backchannel", "talk",
]  # fmt: skip
"""What was meant. `talk` is for somebody else; `unclear` deserves a question back."""

StyleWish = Literal["", "less", "more", "slower", "faster", "louder", "quieter", "normal"]
StatusTopic = Literal[
    "", "doing", "finished", "place", "object", "duration", "ability", "stock", "wellbeing", "farewell", "called"
]
"""What a question about the robot's doings is about; for a greeting, what kind it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Interpretation:
    """What an utterance means.

    Attributes:
        add: Objects wanted; for another place: those that go there, none for all; for a question: those it points at.
        remove: Objects not wanted any more (replacing and cancelling).
        destination: Where to put things; "" for the person's usual place.
        fetch_from: A place named for something the robot holds already, or "".
        reply: A question or remark that the interpreter suggests; "" leaves it to the dialogue.
        confidence: 0 to 1.
        reason: Why, in one clause, for logs and people.
        definite: For each of `add`: whether the person meant a particular one ("the cup", "my cup").
        unknown: Words that name nothing the robot knows ("newspaper").
        style: How the robot shall speak or tell.
        status: What a status question is about.
        band: The age band that the person stated in words ("I am old").
        age: The age that the person stated [years], 0 for none.
        answers: Whether this chooses what the pending question is about.
        suggestion: What the person may have said (repair): a question about it is worth asking.
        doubted: What it means if it was asked of the robot, which is doubtful: a question about it is worth asking.
    """

    intent: Intent
    add: tuple[ObjectSpec, ...] = ()
    remove: tuple[ObjectSpec, ...] = ()
    destination: str = ""
    reply: str = ""
    confidence: float = 1.0
    reason: str = ""
    definite: tuple[bool, ...] = ()
    unknown: str = ""
    style: StyleWish = ""
    status: StatusTopic = ""
    band: Band = "unknown"
    age: int = 0
    answers: bool = False
    suggestion: str = ""
    doubted: "Interpretation | None" = None


class Interpreter(Protocol):
    """Interprets one utterance. Must not change anything and must not raise on any text."""

    async def interpret(self, text: str, context: Context) -> Interpretation:
        """What `text` means to a robot in this situation."""
        ...
