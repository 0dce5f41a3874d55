"""Talk to a running session from another process, over a Unix socket that only the same user can open.

One connection is one turn: the client sends one JSON line `{"say": TEXT}` or `{"stop": true}`; the session answers
with JSON lines, each one message of the bus as `{"topic", "message"}`, until the robot has answered.
"""

import json
import math
import os
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import anyio
import anyio.abc
import platformdirs
from anyio.streams.buffered import BufferedByteReceiveStream

from attune.core.bus import COMMAND, EVENT, REPLY, Bus, Topic
from attune.core.codec import to_data
from attune.core.errors import AttuneError
from attune.core.log import get_logger
from attune.session.session import Session

MAX_LINE = 10_000
QUIET_AFTER_REPLY = 0.5
"""Seconds without a message after the first reply that end a turn."""
ANSWER_WITHIN = 10.0
"""Seconds in which the first reply must come."""


class NoSessionError(AttuneError):
    """No session runs, or it does not answer."""

    def __init__(self, socket: Path) -> None:
        super().__init__(f"no session is running (nothing answers at {socket})", "Start one: attune live")


def default_socket() -> Path:
    """Where a session of this user listens."""
    return platformdirs.user_state_path("attune", ensure_exists=True) / "session.sock"


async def serve(session: Session, socket: Path) -> None:
    """Let other processes talk to the session until cancelled.

    Raises:
        AttuneError: Another session already listens there.
    """
    if socket.exists():
        if await _answers(socket):
            raise AttuneError(f"another session is running at {socket}", "End it first, or use it: attune say TEXT")
        socket.unlink()
    listener = await anyio.create_unix_listener(socket, mode=0o600)
    try:
        async with listener:
            await listener.serve(lambda stream: _turn(session, stream))
    finally:
        socket.unlink(missing_ok=True)


async def _answers(socket: Path) -> bool:
    try:
        async with await anyio.connect_unix(socket):
            return True
    except OSError:
        return False


async def _turn(session: Session, stream: anyio.abc.SocketStream) -> None:
    async with stream:
        try:
            request = json.loads(await BufferedByteReceiveStream(stream).receive_until(b"\n", MAX_LINE))
            if request.get("stop") is True:
                session.stop("program")
                return
            text = request["say"]
            if not isinstance(text, str) or not text.strip():
                raise ValueError("say must be a text")
        except (anyio.IncompleteRead, anyio.DelimiterNotFound):
            return  # somebody only looked whether a session is there
        except (ValueError, KeyError, AttributeError) as error:
            await _send(stream, {"error": f"not a request: {error}"})
            return
        try:
            async for line in _answers_to(session, text):
                await _send(stream, line)
        except anyio.BrokenResourceError:
            get_logger("remote").info("client_left")


async def _answers_to(session: Session, text: str) -> AsyncIterator[dict[str, Any]]:
    send, receive = anyio.create_memory_object_stream[dict[str, Any]](math.inf)
    bus: Bus = session.bus

    def forward(topic: Topic[Any]) -> Any:
        return lambda message: send.send_nowait({"topic": topic.name, "message": to_data(message)})

    forget = [bus.on(topic, forward(topic)) for topic in (EVENT, COMMAND, REPLY)]
    try:
        session.say(text)
        wait = ANSWER_WITHIN
        while True:
            try:
                with anyio.fail_after(wait):
                    line = await receive.receive()
            except TimeoutError:
                return
            yield line
            if line["topic"] == REPLY.name:
                wait = QUIET_AFTER_REPLY
    finally:
        for end in forget:
            end()
        send.close()
        receive.close()


async def _send(stream: anyio.abc.SocketStream, line: dict[str, Any]) -> None:
    await stream.send(json.dumps(line).encode() + b"\n")


async def ask(socket: Path, request: dict[str, Any]) -> AsyncIterator[dict[str, Any]]:
    """Send one request to the running session and yield its answers.

    Raises:
        NoSessionError: Nobody listens at `socket`.
    """
    try:
        stream = await anyio.connect_unix(os.fspath(socket))
    except OSError:
        raise NoSessionError(socket) from None
    async with stream:
        await _send(stream, request)
        buffered = BufferedByteReceiveStream(stream)
        while True:
            try:
                yield json.loads(await buffered.receive_until(b"\n", 1_000_000))
            except (anyio.IncompleteRead, anyio.EndOfStream):
                return
