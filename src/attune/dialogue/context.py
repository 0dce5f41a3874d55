"""The situation in which something is said: what the robot does, holds and has done, and what it asked."""

from dataclasses import dataclass

from attune.core.messages import ObjectSpec


@dataclass(frozen=True, slots=True)
class TaskContext:
    """What the robot does now."""

    command: str = "bring_me"
    objects: tuple[ObjectSpec, ...] = ()
    destination: str = ""


@dataclass(frozen=True, slots=True)
class Context:
    """What an interpreter knows besides the words.

    Attributes:
        task: The running task, None when the robot waits.
        carrying: What the robot holds.
        delivered: What it has brought, last one last.
        last_robot_utterance: What it said last.
        pending_question: What it asked and still wants to know; "" for nothing.
        scene: Objects known to be there; need not be complete.
    """

    task: TaskContext | None = None
    carrying: ObjectSpec | None = None
    delivered: tuple[ObjectSpec, ...] = ()
    last_robot_utterance: str = ""
    pending_question: str = ""
    scene: tuple[ObjectSpec, ...] = ()

    @property
    def busy(self) -> bool:
        """Whether there is something that a correction can be about."""
        return self.task is not None or self.carrying is not None or bool(self.delivered)

    @property
    def recent(self) -> tuple[ObjectSpec, ...]:
        """Objects that a pointing word may mean, the likeliest first."""
        task = self.task.objects if self.task else ()
        held = (self.carrying,) if self.carrying else ()
        return (*held, *reversed(task), *reversed(self.delivered))
