"""Another process can talk to a running session, and gets a clear answer when there is none."""

import json
import os
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

from attune.core.clock import RealClock, run
from attune.core.config import Config
from attune.core.errors import AttuneError
from attune.session.remote import NoSessionError, ask, serve
from attune.session.session import Session


@pytest.fixture
def socket(tmp_path: Path) -> Path:
    return tmp_path / "session.sock"


async def until_it_answers(socket: Path) -> None:
    while True:
        try:
            async with await anyio.connect_unix(socket):
                return
        except OSError:
            await RealClock().sleep(0.01)


def test_one_turn_gives_what_was_understood_and_the_answer(config: Config, socket: Path) -> None:
    async def main() -> list[dict[str, object]]:
        session = Session(config, RealClock())
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(serve, session, socket)
            await until_it_answers(socket)
            assert os.stat(socket).st_mode & 0o077 == 0
            answers = [line async for line in ask(socket, {"say": "bring me a cup"})]
            group.cancel_scope.cancel()
        return answers

    answers = run(main, RealClock())
    assert [a["message"]["kind"] for a in answers if a["topic"] == "robot/command"] == ["bring_me"]  # type: ignore[index]
    assert any(a["topic"] == "dialogue/reply" for a in answers)
    assert not socket.exists()


def test_a_malformed_request_is_answered_and_the_session_goes_on(config: Config, socket: Path) -> None:
    async def main() -> tuple[list[dict[str, object]], list[dict[str, object]]]:
        session = Session(config, RealClock())
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(serve, session, socket)
            await until_it_answers(socket)
            bad = [line async for line in ask(socket, {"sing": "a song"})]
            good = [line async for line in ask(socket, {"say": "stop"})]
            group.cancel_scope.cancel()
        return bad, good

    bad, good = run(main, RealClock())
    assert "not a request" in str(bad[0]["error"])
    assert any(line["topic"] == "robot/command" for line in good)


def test_without_a_session_the_error_says_how_to_start_one(socket: Path) -> None:
    async def main() -> None:
        async for _ in ask(socket, {"say": "hello"}):
            pass

    with pytest.raises(NoSessionError, match="attune live"):
        run(main, RealClock())


def test_a_second_session_does_not_take_over_the_socket(config: Config, socket: Path) -> None:
    async def main() -> None:
        session = Session(config, RealClock())
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(serve, session, socket)
            await until_it_answers(socket)
            with pytest.raises(AttuneError, match="another session is running"):
                await serve(session, socket)
            group.cancel_scope.cancel()

    run(main, RealClock())


def test_say_prints_the_answer_of_the_session(config: Config, socket: Path) -> None:
    async def main() -> str:
        session = Session(config, RealClock())
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(serve, session, socket)
            await until_it_answers(socket)
            command = [sys.executable, "-m", "attune", "say", "--json", "--socket", str(socket), "bring me a cup"]
            result = await anyio.run_process(command, stderr=subprocess.STDOUT)
            group.cancel_scope.cancel()
        return result.stdout.decode()

    lines = [json.loads(line) for line in run(main, RealClock()).splitlines()]
    assert "robot/command" in [line["topic"] for line in lines]
