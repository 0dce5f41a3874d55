"""The session's own stream of events: one place that logs, the terminal view and the evaluation all read."""

from dataclasses import dataclass, field
from typing import Any, Literal

from attune.core.messages import Message, new_id

EventKind = Literal[
    "session_started", "session_ended", "heard", "ignored", "understood", "stop_spotted", "stop_confirmed",
    "stop_withdrawn", "warning", "error",
]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Event(Message):
    """Something that happened in the session.

    Attributes:
        text: One line for people. Never contains what was said: that is in `data`, so that it can be left out.
        data: Facts, ready for JSON.
    """

    id: str = field(default_factory=lambda: new_id("event"))
    kind: EventKind
    text: str = ""
    data: dict[str, Any] = field(default_factory=dict)
