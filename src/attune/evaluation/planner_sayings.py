"""What is said in the planner's evaluation: commands with the moment at which each is given."""

from dataclasses import dataclass, replace
from typing import Literal

from attune.core.messages import (
    Band,
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    Command,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    Stop,
)

Moment = int | Literal["carrying", "settled"]
"""When a command is given: after so many state changes, when the robot carries something to its goal, or at rest."""
Kind = Literal[
    "bring_me", "replace_object", "setting_breakfast", "change_location", "cancel_object", "put_back", "stop",
    "carry_on",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Saying:
    """One command, and when it is given.

    Attributes:
        kind: Of the command.
        type: The object type it is about, "" when it names none.
        instead_of: The type that a replacement removes.
        at: The moment, counted from the command before.
        also: A second object type that bring_me asks for.
        source: The place that bring_me takes the first object from, "" when it names none.
        place: The place that bring_me or change_location names.
    """

    kind: Kind
    type: str = ""
    instead_of: str = ""
    at: Moment = 0
    also: str = ""
    source: str = ""
    place: str = ""

    @property
    def types(self) -> tuple[str, ...]:
        """The object types it asks for."""
        return tuple(type_ for type_ in (self.type, self.also) if type_)

    def command(self, band: Band) -> Command:
        """As a message."""
        objects = tuple(ObjectSpec(type=type_) for type_ in self.types)
        command: Command
        match self.kind:
            case "bring_me":
                first = ObjectSpec(type=self.type, location=self.source)
                command = BringMe(time=0.0, objects=(first, *objects[1:]), destination=self.place)
            case "replace_object":
                command = ReplaceObject(time=0.0, remove=ObjectSpec(type=self.instead_of), add=objects[0])
            case "setting_breakfast":
                command = SettingBreakfast(time=0.0)
            case "change_location":
                command = ChangeLocation(time=0.0, destination=self.place, objects=objects)
            case "cancel_object":
                command = CancelObject(time=0.0, object=objects[0])
            case "put_back":
                command = PutBack(time=0.0)
            case "stop":
                command = Stop(time=0.0)
            case "carry_on":
                command = CarryOn(time=0.0)
        return replace(command, band=band)

    def __str__(self) -> str:
        what = f" {' and '.join(self.types)}" if self.types else ""
        old = f" for {self.instead_of}" if self.instead_of else ""
        where = (f" from {self.source}" if self.source else "") + (f" to {self.place}" if self.place else "")
        moment = f" after {self.at} changes" if isinstance(self.at, int) else f" when {self.at}"
        return f"{self.kind}{what}{old}{where}{'' if self.at == 0 else moment}"


Part = Literal["paper", "every step", "each other"]


@dataclass(frozen=True, slots=True)
class Permutation:
    """One run of the test.

    Attributes:
        part: `paper`: the paper's own. `every step`: its commands, with the interruption at every step. `each other`:
            all commands, also what the paper does not have, each interrupting each other at every step.
        scenario: The command that is interrupted last.
    """

    part: Part
    scenario: Kind
    band: Band
    sayings: tuple[Saying, ...]

    def __str__(self) -> str:
        return f"{self.band}: {', then '.join(str(saying) for saying in self.sayings)}"
