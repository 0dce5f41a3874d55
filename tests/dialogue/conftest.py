"""A small HTTP server that speaks the protocol of OpenAI's chat completions, and misbehaves on demand."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

Json = dict[str, Any]


def answer(intent: str, **fields: Any) -> Json:
    """A complete answer; objects may be given partly."""
    filled: Json = {
        "intent": intent,
        "add": [],
        "remove": [],
        "destination": "",
        "style": "",
        "status": "",
        "answers": False,
        "reply": "",
    }
    filled |= fields
    for role in ("add", "remove"):
        filled[role] = [{"type": "", "color": "", "size": "", "location": ""} | spec for spec in filled[role]]
    return filled


@dataclass
class Behaviour:
    """What the server does with one request.

    Attributes:
        content: What the model writes; a dict is written as JSON.
        status: HTTP status; anything but 200 sends an error.
        wait: Before the answer begins [s].
        hang_after: Characters after which it says no more, but keeps the connection.
        cut_after: Characters after which the answer ends as if it were complete.
        drop_after: Characters after which the connection is cut.
    """

    content: str | Json = ""
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)
    error: str = "something is wrong"
    wait: float = 0.0
    hang_after: int | None = None
    cut_after: int | None = None
    drop_after: int | None = None


class ModelServer:
    """Answers each request with the next behaviour; the last one stays. A function decides from the utterance."""

    def __init__(self, *behaviours: Behaviour | Callable[[str], Behaviour]) -> None:
        self._behaviours = list(behaviours)
        self.requests: list[Json] = []
        self.headers: list[dict[str, str]] = []
        self.url = ""

    @asynccontextmanager
    async def running(self) -> AsyncIterator["ModelServer"]:
        tasks: set[asyncio.Task[None]] = set()

        async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            task = asyncio.current_task()
            assert task is not None
            tasks.add(task)
            try:
                await self._serve(reader, writer)
            except (asyncio.CancelledError, ConnectionError, asyncio.IncompleteReadError):
                pass
            finally:
                tasks.discard(task)
                writer.close()

        server = await asyncio.start_server(connected, "127.0.0.1", 0)
        self.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/v1"
        try:
            yield self
        finally:
            server.close()
            for task in tuple(tasks):
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while True:
            head = (await reader.readuntil(b"\r\n\r\n")).decode()
            headers = dict(line.lower().split(": ", 1) for line in head.split("\r\n")[1:] if ": " in line)
            body = await reader.readexactly(int(headers.get("content-length", "0")))
            assert head.startswith("POST /v1/chat/completions "), head
            request = json.loads(body)
            self.requests.append(request)
            self.headers.append(headers)
            next_one = self._behaviours.pop(0) if len(self._behaviours) > 1 else self._behaviours[0]
            if callable(next_one):
                next_one = next_one(json.loads(request["messages"][-1]["content"])["utterance"])
            await self._respond(next_one, writer)

    async def _respond(self, behaviour: Behaviour, writer: asyncio.StreamWriter) -> None:
        await asyncio.sleep(behaviour.wait)  # noqa: TID251 (the server has no clock of ours)
        if behaviour.status != 200:
            text = json.dumps({"error": {"message": behaviour.error, "type": "error"}}).encode()
            lines = [
                f"HTTP/1.1 {behaviour.status} Oops",
                f"content-length: {len(text)}",
                "content-type: application/json",
            ]
            lines += [f"{name}: {value}" for name, value in behaviour.headers.items()]
            writer.write("\r\n".join(lines).encode() + b"\r\n\r\n" + text)
            await writer.drain()
            return
        content = behaviour.content if isinstance(behaviour.content, str) else json.dumps(behaviour.content)
        writer.write(b"HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\ntransfer-encoding: chunked\r\n\r\n")
        end = min(limit for limit in (behaviour.hang_after, behaviour.cut_after, behaviour.drop_after, len(content))
                  if limit is not None)  # fmt: skip
        for start in range(0, end, 20):
            self._event(writer, {"content": content[start : min(start + 20, end)]}, None)
        await writer.drain()
        if behaviour.hang_after is not None:
            await asyncio.Event().wait()
        if behaviour.drop_after is not None:
            raise ConnectionError
        self._event(writer, {}, "stop" if behaviour.cut_after is None else "length")
        self._chunk(writer, b"data: [DONE]\n\n")
        writer.write(b"0\r\n\r\n")
        await writer.drain()

    def _event(self, writer: asyncio.StreamWriter, delta: Json, finish: str | None) -> None:
        choice = {"index": 0, "delta": delta, "finish_reason": finish}
        event = {"id": "x", "object": "chat.completion.chunk", "created": 0, "model": "m", "choices": [choice]}
        self._chunk(writer, f"data: {json.dumps(event)}\n\n".encode())

    def _chunk(self, writer: asyncio.StreamWriter, data: bytes) -> None:
        writer.write(f"{len(data):x}\r\n".encode() + data + b"\r\n")


@pytest.fixture
def model_server() -> type[ModelServer]:
    return ModelServer


@pytest.fixture
def behaviour() -> type[Behaviour]:
    return Behaviour


@pytest.fixture
def model_answer() -> Callable[..., Json]:
    return answer
