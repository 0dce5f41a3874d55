"""The typed, immutable messages that modules exchange.

Each message has an `id`, the id of what `cause`d it, and the `time` [s] of the session's clock. Plain frozen
dataclasses inside; `attune.core.codec` turns them into JSON and back at every edge.

Empty strings mean "not given".
"""

from dataclasses import dataclass, field
from typing import Literal, get_args
from uuid import uuid4

Band = Literal["younger", "older", "unknown"]
AgeGroup = Literal[
    "teens", "twenties", "thirties", "fourties", "fifties", "sixties", "seventies", "eighties", "nineties"
]
AGE_GROUPS: tuple[AgeGroup, ...] = get_args(AgeGroup)
"""The nine groups of the paper, spelled as in Common Voice's own labels."""


def years_of(group: AgeGroup) -> int:
    """The age at which a group begins [years]."""
    return 10 * (AGE_GROUPS.index(group) + 1)


Size = Literal["", "small", "normal", "big"]


def new_id(kind: str) -> str:
    """A fresh id such as `utterance-5f0c3b9a`."""
    return f"{kind}-{uuid4().hex[:8]}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """What every message has."""

    time: float
    cause: str = ""
    id: str = field(default_factory=lambda: new_id("message"))


# --- speech -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class AgeEstimate:
    """Who is speaking, as far as age goes.

    Attributes:
        probabilities: One per group of `AGE_GROUPS`, summing to 1; empty when nothing was estimated.
        band: What the dialogue uses. `unknown` never forces a style.
        confidence: Of the band, 0 to 1.
        source: `model` (trained), `norms` (embedded default), `stated` by the person, or a stored `profile`.
    """

    probabilities: tuple[float, ...] = ()
    band: Band = "unknown"
    confidence: float = 0.0
    source: Literal["model", "norms", "stated", "profile"] = "norms"


@dataclass(frozen=True, slots=True, kw_only=True)
class Utterance(Message):
    """What a person said, as heard and not normalised.

    Attributes:
        alternatives: Other readings, best first, without `text`.
        confidence: Of the recognition, 0 to 1. Typed text has 1.
        start: When the speech began [s].
        end: When the speech ended [s], before the endpoint was decided.
        in_domain: False when the audio fits the domain's language model badly (noise, other talk).
        is_final: False for a partial result.
        typed: True when it came from a keyboard.
    """

    id: str = field(default_factory=lambda: new_id("utterance"))
    text: str
    alternatives: tuple[str, ...] = ()
    confidence: float = 1.0
    in_domain: bool = True
    language: str = "en"
    age: AgeEstimate = AgeEstimate()
    start: float = 0.0
    end: float = 0.0
    is_final: bool = True
    typed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeechActivity(Message):
    """Somebody begins or ends speaking; the voice falls silent for a person who goes on speaking (barge-in)."""

    id: str = field(default_factory=lambda: new_id("activity"))
    speaking: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class StopSignal(Message):
    """Halt, at once. It never waits for a queue, a recogniser or an LLM.

    `spotted` pauses the robot; the final text then makes it `confirmed` (the plan ends) or `withdrawn`
    (the robot carries on by itself). A button or Ctrl-C is `confirmed` from the start.
    """

    id: str = field(default_factory=lambda: new_id("stop"))
    state: Literal["spotted", "confirmed", "withdrawn"] = "confirmed"
    source: Literal["spotter", "utterance", "button", "keyboard", "ros", "program"] = "program"
    word: str = ""


# --- commands -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectSpec:
    """A partial description of an object; "" means not given.

    Attributes:
        location: Where to fetch it from: a kind of place (`cabinet`) as people name it.
        name: The one object meant, when it is known (its name in the scene).
    """

    type: str = ""
    color: str = ""
    size: Size = ""
    location: str = ""
    name: str = ""

    def __str__(self) -> str:
        """As people say it, without article: `small red cup`."""
        size = "" if self.size == "normal" else self.size
        return " ".join(word for word in (size, self.color, self.type or "object") if word)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Command(Message):
    id: str = field(default_factory=lambda: new_id("command"))
    band: Band = "unknown"
    """The age band of who asked: it chooses the default place of delivery."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BringMe(_Command):
    """Fetch objects. `destination` is a kind of place, or "" for where the person usually wants things."""

    kind: Literal["bring_me"] = "bring_me"
    objects: tuple[ObjectSpec, ...]
    destination: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingBreakfast(_Command):
    """Set the table for breakfast with the configured set of objects."""

    kind: Literal["setting_breakfast"] = "setting_breakfast"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplaceObject(_Command):
    """Bring `add` instead of `remove`."""

    kind: Literal["replace_object"] = "replace_object"
    remove: ObjectSpec
    add: ObjectSpec
    destination: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeLocation(_Command):
    """Deliver somewhere else. Empty `objects`: what is carried and all that is still to come."""

    kind: Literal["change_location"] = "change_location"
    destination: str
    objects: tuple[ObjectSpec, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class CancelObject(_Command):
    """Forget one object of the task; it is put back if it is carried."""

    kind: Literal["cancel_object"] = "cancel_object"
    object: ObjectSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class PutBack(_Command):
    """Return objects to where they came from. Empty spec: what is carried, else what was delivered last."""

    kind: Literal["put_back"] = "put_back"
    object: ObjectSpec = ObjectSpec()


@dataclass(frozen=True, slots=True, kw_only=True)
class CarryOn(_Command):
    """Resume after a stop, from the world as it is."""

    kind: Literal["carry_on"] = "carry_on"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop(_Command):
    """The major interruption: halt, and give up the plan unless the person says to carry on."""

    kind: Literal["stop"] = "stop"


Command = BringMe | SettingBreakfast | ReplaceObject | ChangeLocation | CancelObject | PutBack | CarryOn | Stop

OutcomeStatus = Literal["accepted", "deferred", "done", "failed", "refused", "cancelled", "interrupted"]
OutcomeReason = Literal[
    "", "not_found", "unreachable", "grasp_failed", "dropped", "blocked", "no_space", "already_there",
    "unknown_place", "unknown_object", "nothing_to_do", "atomic_step", "replaced", "stopped", "robot_fault",
]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandOutcome(Message):
    """What became of a command, or of one object of it. Each accepted command ends in one, with a reason.

    Attributes:
        command: Id of the command.
        kind: The command's kind.
        status: `deferred` means: accepted, in force once the atomic step (`reason`) has ended.
        object: The object it is about, when it is about one.
        place: The place it is about, if any.
        alternative: The nearest thing that exists, when `object` was not found.
        behind: What `object` may be hidden by, when it was not found.
        detail: For logs; not spoken.
    """

    id: str = field(default_factory=lambda: new_id("outcome"))
    command: str
    kind: str
    status: OutcomeStatus
    reason: OutcomeReason = ""
    object: ObjectSpec = ObjectSpec()
    place: str = ""
    alternative: ObjectSpec | None = None
    behind: ObjectSpec | None = None
    detail: str = ""


# --- robot and world ----------------------------------------------------------------------------------------

Step = Literal[
    "idle", "set_parameters", "transporting_search", "transporting_fetch", "transporting_deliver", "recovering",
    "clearing", "already_done", "task_done", "paused", "stopped", "failed",
]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class QueuedTask:
    """One delivery that is wanted: which object, to which place, and how far it is; `returning` goes home."""

    object: ObjectSpec
    destination: str
    status: Literal["waiting", "active", "delivered", "returning"] = "waiting"
    command: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotState(Message):
    """The robot's symbolic state S (paper, section 3.1), published on every change.

    Attributes:
        step: What the plan does now.
        interruptible: False during an atomic part (opening a door, closing the fingers). Stop ignores it.
        object: What the current step is about.
        move_arm: Whether an arm moves, or is about to.
        move_base: Whether the base moves, or is about to.
        current_location: The place the robot is at.
        destination_location: The place the current step leads to.
        holding: What is in the grippers.
        queue: All deliveries of the running task, with their status.
        progress: 0 to 1, deliveries done of deliveries wanted.
        command: Id of the command that the current step serves.
    """

    id: str = field(default_factory=lambda: new_id("state"))
    step: Step = "idle"
    interruptible: bool = True
    object: ObjectSpec = ObjectSpec()
    move_arm: bool = False
    move_base: bool = False
    current_location: str = ""
    destination_location: str = ""
    holding: tuple[ObjectSpec, ...] = ()
    queue: tuple[QueuedTask, ...] = ()
    progress: float = 0.0
    command: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class BelievedObject:
    """An object the robot believes to exist.

    Attributes:
        spec: All properties known; `location` is the kind of place it is at, "" while it is held.
        place: Name of the furniture or compartment it is at; "" while it is held.
        position: x, y, z in the map frame [m], or None if it has not been seen.
        held_by: The arm that holds it, or "".
        confidence: 0 to 1 that it is there.
        seen: When it was last seen [s], or None: only expected there.
    """

    spec: ObjectSpec
    place: str = ""
    position: tuple[float, float, float] | None = None
    held_by: Literal["", "left", "right"] = ""
    confidence: float = 0.5
    seen: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldState(Message):
    """What the robot believes about the objects of the kitchen."""

    id: str = field(default_factory=lambda: new_id("world"))
    objects: tuple[BelievedObject, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectsInUse(Message):
    """The objects the running task is about (the paper's `objects_in_use`)."""

    id: str = field(default_factory=lambda: new_id("objects"))
    objects: tuple[ObjectSpec, ...] = ()


NodeStatus = Literal["pending", "running", "succeeded", "failed", "interrupted"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanNode:
    """One node of the running plan.

    Attributes:
        started: Time [s], or None while pending.
        ended: Time [s], or None until it ended.
        reason: Why it failed, or how far it got when interrupted.
        atomic: Whether a minor interruption waits for its end.
    """

    name: str
    status: NodeStatus = "pending"
    started: float | None = None
    ended: float | None = None
    reason: str = ""
    atomic: bool = False
    children: tuple["PlanNode", ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanTree(Message):
    """The plan that runs now, as a tree."""

    id: str = field(default_factory=lambda: new_id("plan"))
    root: PlanNode


# --- dialogue and voice -------------------------------------------------------------------------------------

Urgency = Literal["background", "normal", "urgent"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply(Message):
    """Something the robot wants to say.

    Attributes:
        style: The age style it was written in (`unknown` is the neutral style).
        urgency: `background` (an announcement) waits behind answers and is dropped for a newer one, `urgent` cuts off
            what is being said.
        supersedes: Ids of replies that must not be spoken any more, if they have not been yet.
        rate: Speaking rate [words per minute].
        loudness: 0 to 1.
    """

    id: str = field(default_factory=lambda: new_id("reply"))
    text: str
    style: Band = "unknown"
    urgency: Urgency = "normal"
    supersedes: tuple[str, ...] = ()
    rate: int = 170
    loudness: float = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Retraction(Message):
    """Replies that are overtaken: they are not spoken; one that is being spoken ends with its sentence.

    Attributes:
        replies: Their ids.
    """

    id: str = field(default_factory=lambda: new_id("retraction"))
    replies: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner(Message):
    """How the robot shall behave towards the person, as far as it is not a matter of words.

    Attributes:
        warn_before_movement: Longest time that a movement waits until what was announced (replies of urgency
            `background`) has been said [s]; 0: nothing waits.
    """

    id: str = field(default_factory=lambda: new_id("manner"))
    warn_before_movement: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class VoiceStatus(Message):
    """How far a reply has been spoken, so that the dialogue knows what was really said.

    Attributes:
        reply: Id of the reply.
        spoken: The text spoken so far.
    """

    @property
    def over(self) -> bool:
        """Whether no more of the reply will be heard."""
        return self.state in {"finished", "interrupted", "dropped"}

    id: str = field(default_factory=lambda: new_id("voice"))
    reply: str
    state: Literal["started", "word", "finished", "interrupted", "dropped"]
    spoken: str = ""
