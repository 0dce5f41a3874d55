"""The in-process bus: typed topics between modules. ROS 2 topics carry the same names under `/attune/`."""

import math
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

import anyio
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

from attune.core import messages as m
from attune.core.events import Event

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Topic(Generic[T]):
    """A named channel for one type of message. A latched topic gives its last message to late subscribers."""

    name: str
    type: Any
    latched: bool = False


UTTERANCE: Topic[m.Utterance] = Topic("speech/utterance", m.Utterance)
SPEECH_ACTIVITY: Topic[m.SpeechActivity] = Topic("speech/activity", m.SpeechActivity)
SPEECH_STOP: Topic[m.StopSignal] = Topic("speech/stop", m.StopSignal)
COMMAND: Topic[m.Command] = Topic("robot/command", m.Command)
ROBOT_STOP: Topic[m.StopSignal] = Topic("robot/stop", m.StopSignal)
ROBOT_STATE: Topic[m.RobotState] = Topic("robot/state", m.RobotState, latched=True)
OUTCOME: Topic[m.CommandOutcome] = Topic("robot/outcome", m.CommandOutcome)
OBJECTS_IN_USE: Topic[m.ObjectsInUse] = Topic("robot/objects_in_use", m.ObjectsInUse, latched=True)
PLAN: Topic[m.PlanTree] = Topic("robot/plan", m.PlanTree, latched=True)
WORLD: Topic[m.WorldState] = Topic("world/objects", m.WorldState, latched=True)
REPLY: Topic[m.Reply] = Topic("dialogue/reply", m.Reply)
RETRACTION: Topic[m.Retraction] = Topic("dialogue/retraction", m.Retraction)
MANNER: Topic[m.Manner] = Topic("dialogue/manner", m.Manner, latched=True)
VOICE_STATUS: Topic[m.VoiceStatus] = Topic("voice/status", m.VoiceStatus)
EVENT: Topic[Event] = Topic("session/event", Event)

TOPICS: tuple[Topic[Any], ...] = (
    UTTERANCE, SPEECH_ACTIVITY, SPEECH_STOP, COMMAND, ROBOT_STOP, ROBOT_STATE, OUTCOME, OBJECTS_IN_USE, PLAN, WORLD,
    REPLY, RETRACTION, MANNER, VOICE_STATUS, EVENT,
)  # fmt: skip


class Subscription(Generic[T]):
    """An ordered, lossless queue of a topic's messages: `async for message in subscription`."""

    def __init__(self, stream: MemoryObjectReceiveStream[T]) -> None:
        self._stream = stream

    def __aiter__(self) -> AsyncIterator[T]:
        return self

    async def __anext__(self) -> T:
        try:
            return await self._stream.receive()
        except anyio.EndOfStream:
            raise StopAsyncIteration from None

    async def receive(self) -> T:
        """Wait for the next message."""
        return await self._stream.receive()


class Bus:
    """Delivers each message to the handlers (at once, in the caller) and to the subscriptions (queued).

    Publish and subscribe from the event loop's thread only; a thread hands over with
    `anyio.from_thread.run_sync(bus.publish, topic, message)`.
    """

    def __init__(self) -> None:
        self._handlers: dict[str, list[Callable[[Any], None]]] = {}
        self._streams: dict[str, list[MemoryObjectSendStream[Any]]] = {}
        self._latest: dict[str, Any] = {}

    def publish(self, topic: Topic[T], message: T) -> None:
        """Deliver a message. Handlers run before this returns; none may block.

        Raises:
            TypeError: The message is not of the topic's type.
        """
        if not isinstance(message, topic.type):
            raise TypeError(f"{topic.name} carries {topic.type}, not {type(message).__name__}")
        if topic.latched:
            self._latest[topic.name] = message
        for handler in tuple(self._handlers.get(topic.name, ())):
            handler(message)
        for stream in tuple(self._streams.get(topic.name, ())):
            stream.send_nowait(message)

    def latest(self, topic: Topic[T]) -> T | None:
        """The last message of a latched topic, or None."""
        return cast("T | None", self._latest.get(topic.name))

    def on(self, topic: Topic[T], handler: Callable[[T], None]) -> Callable[[], None]:
        """Call `handler` inside every publish. Returns the function that ends this."""
        handlers = self._handlers.setdefault(topic.name, [])
        handlers.append(handler)
        return lambda: handlers.remove(handler)

    @contextmanager
    def subscribe(self, topic: Topic[T]) -> Iterator[Subscription[T]]:
        """Queue messages from now on (and the latched one first) until the block ends."""
        send, receive = anyio.create_memory_object_stream[Any](math.inf)
        streams = self._streams.setdefault(topic.name, [])
        streams.append(send)
        if topic.name in self._latest:
            send.send_nowait(self._latest[topic.name])
        try:
            yield Subscription(receive)
        finally:
            streams.remove(send)
            send.close()
            receive.close()
