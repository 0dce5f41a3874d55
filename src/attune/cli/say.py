"""`attune say`: one turn against a running session."""

from pathlib import Path
from typing import Annotated

import typer


def say(
    text: Annotated[str, typer.Argument(help="What you say to the robot.")],
    socket: Annotated[Path | None, typer.Option(help="The session's socket, if it is not the usual one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print every message as one line of JSON.")] = False,
) -> None:
    """Say one thing to a running session and print its answer.

    Example: attune say "bring me the red cup"
    """
    import json

    import anyio

    from attune.cli.view import describe_command
    from attune.core.codec import from_data
    from attune.core.errors import AttuneError
    from attune.core.messages import Command
    from attune.session.remote import NoSessionError, ask, default_socket

    if not text.strip():
        raise AttuneError("there is nothing to say", 'Give a text: attune say "bring me a cup"')
    where = socket or default_socket()

    async def turn() -> bool:
        answered = False
        async for line in ask(where, {"say": text}):
            answered = True
            if as_json:
                typer.echo(json.dumps(line))
            elif "error" in line:
                raise AttuneError(line["error"])
            elif line["topic"] == "robot/command":
                typer.echo(f"understood: {describe_command(from_data(Command, line['message']))}")
            elif line["topic"] == "dialogue/reply":
                typer.echo(f"robot: {line['message']['text']}")
            elif line["message"]["kind"] == "ignored":
                typer.echo(f"ignored: {line['message']['text']}")
        return answered

    if not anyio.run(turn):
        raise NoSessionError(where)
