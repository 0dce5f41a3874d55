"""A session with the physics-free robot in virtual time: conversations in milliseconds."""

from collections.abc import Awaitable, Callable

import pytest

from attune.core.clock import VirtualClock, run
from attune.core.config import Config, load_config, with_values
from attune.session.session import Session


@pytest.fixture
def config() -> Config:
    return with_values(load_config(environment={}), {"robot": {"kind": "symbolic"}, "voice": {"output": "none"}})


@pytest.fixture
def converse(config: Config) -> Callable[[Callable[[Session], Awaitable[None]]], Session]:
    """Run a conversation with a new session; gives the session back for looking at."""

    def play(conversation: Callable[[Session], Awaitable[None]]) -> Session:
        clock = VirtualClock()

        async def main() -> Session:
            session = Session(config, clock)
            async with session.running():
                await conversation(session)
            return session

        return run(main, clock)

    return play
