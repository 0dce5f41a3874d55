"""The dialogue's picture of the situation, kept up to date from the bus."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

from attune.core.messages import CommandOutcome, ObjectSpec, RobotState
from attune.core.scene import Scene
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.grammar.references import is_described_by
from attune.dialogue.grounding import believed
from attune.dialogue.interpreter import Interpretation

_REMEMBERED = 12
_RESTING = frozenset({"idle", "task_done", "already_done"})


@dataclass(frozen=True, slots=True)
class PendingQuestion:
    """What the robot asked and still wants to know.

    Attributes:
        text: The question as it was spoken.
        asked: When [s].
        about: What the person wanted, to be completed by the answer; None if nothing is.
        index: Which of its objects the question is about.
        options: The objects that it offers, with all that is known of them.
        reply: Id of the reply that asks it.
        whole: It asks whether all of `about` is wanted; yes means all of it.
    """

    text: str
    asked: float
    about: Interpretation | None = None
    index: int = 0
    options: tuple[ObjectSpec, ...] = ()
    reply: str = ""
    whole: bool = False


class Situation:
    """Robot state, deliveries and the pending question.

    Args:
        scene: What is known before the robot has told anything.
        expires: How long a question waits for its answer [s].
    """

    def __init__(self, scene: Scene, expires: float) -> None:
        self._scene = scene
        self._expires = expires
        self.state: RobotState | None = None
        self.known: tuple[ObjectSpec, ...] = believed((), scene)
        self.places: tuple[str, ...] = scene.vocabulary.places
        self.pending: PendingQuestion | None = None
        self.last_said = ""
        self._delivered: deque[ObjectSpec] = deque(maxlen=_REMEMBERED)

    @property
    def busy(self) -> bool:
        """Whether the robot works on something, or holds something."""
        return self.state is not None and (self.state.step not in _RESTING or bool(self.state.holding))

    @property
    def in_use(self) -> tuple[ObjectSpec, ...]:
        """Objects that the robot brings or has brought."""
        queue = self.state.queue if self.state else ()
        return (*(_plain(item.object) for item in queue if item.status != "returning"), *self._delivered)

    def outcome(self, outcome: CommandOutcome) -> None:
        """Remember what was delivered and what was taken back."""
        if outcome.object == ObjectSpec() or outcome.status != "done":
            return
        spec = _plain(outcome.object)
        if spec in self._delivered:
            self._delivered.remove(spec)
        if outcome.kind in {"bring_me", "setting_breakfast", "replace_object", "change_location"}:
            self._delivered.append(spec)

    def question(self, now: float) -> PendingQuestion | None:
        """The question that still waits for its answer."""
        if self.pending is not None and now - self.pending.asked > self._expires:
            self.pending = None
        return self.pending

    def place_of(self, spec: ObjectSpec) -> str:
        """Where a known object is, in words: `the fridge`."""
        known = next((has.location for has in self.known if is_described_by(spec, has) and has.location), "")
        return f"the {known}" if known else "elsewhere"

    def is_returning(self, specs: Sequence[ObjectSpec]) -> bool:
        """Whether all of these are being brought back already."""
        returning = [item.object for item in self.state.queue if item.status == "returning"] if self.state else []
        return bool(specs) and all(any(is_described_by(_plain(spec), has) for has in returning) for spec in specs)

    def with_what_to_put_back(self, meaning: Interpretation, now: float) -> Interpretation:
        """What "put it back" is about: what the robot holds, what it was about to fetch, or what it brought last."""
        context = self.context(now)
        if meaning.intent != "put_back" or meaning.remove:
            return meaning
        if context.carrying is None and context.task and context.task.objects:
            return replace(meaning, intent="cancel_object", remove=context.task.objects[-1:])
        return replace(meaning, remove=context.recent[:1])

    def context(self, now: float) -> Context:
        """What an interpreter should know."""
        question = self.question(now)
        state = self.state
        open_tasks = [item for item in state.queue if item.status in {"waiting", "active"}] if state else []
        task: TaskContext | None = None
        if open_tasks and state is not None and state.step not in {"idle", "task_done"}:
            # Pointing words mean the likeliest object first, which the context looks for at the end.
            ordered = sorted(open_tasks, key=lambda item: item.status == "active")
            task = TaskContext(
                objects=tuple(_plain(item.object) for item in ordered), destination=open_tasks[0].destination
            )
        return Context(
            task=task,
            carrying=_plain(state.holding[0]) if state and state.holding else None,
            delivered=tuple(self._delivered),
            last_robot_utterance=self.last_said,
            pending_question=question.text if question else "",
            scene=tuple(dict.fromkeys(replace(spec, name="") for spec in self.known)),
        )


def _plain(spec: ObjectSpec) -> ObjectSpec:
    return replace(spec, location="", name="")


def completed(meaning: Interpretation, pending: PendingQuestion) -> Interpretation:
    """Put the answer to a question in its place in what was wanted before; any other meaning stays as it is."""
    about, index = pending.about, pending.index
    if about is not None and pending.whole:
        agreed = meaning.intent == "affirm" or (
            meaning.answers and all(spec in pending.options for spec in meaning.add)
        )
        place = meaning.destination or about.destination
        return (
            replace(about, destination=place, reason=meaning.reason, confidence=meaning.confidence)
            if agreed
            else meaning
        )
    if about is None or not meaning.answers or meaning.intent != "bring_me":
        return meaning
    definite = (*about.definite, *(False for _ in about.add))[: len(about.add)]
    return replace(
        about,
        add=(
            *about.add[:index],
            *(_as_offered(spec, pending.options) for spec in meaning.add),
            *about.add[index + 1 :],
        ),
        definite=(*definite[:index], *(True for _ in meaning.add), *definite[index + 1 :]),
        destination=meaning.destination or about.destination,
        reply=meaning.reply,
        reason=meaning.reason,
        confidence=meaning.confidence,
    )


def _as_offered(spec: ObjectSpec, options: Sequence[ObjectSpec]) -> ObjectSpec:
    """The option that an answer chose, with what the question had no need to say: the small one is red, too."""
    fitting = [option for option in options if is_described_by(replace(spec, location=""), option)]
    # Of the red and the small red cup, "the red one" is the first: nobody calls a size normal.
    exact = [option for option in fitting if _size(option) == _size(spec)]
    chosen = exact if len(exact) == 1 else fitting
    return replace(chosen[0], location=spec.location, name="") if len(chosen) == 1 else spec


def _size(spec: ObjectSpec) -> str:
    return "" if spec.size == "normal" else spec.size
