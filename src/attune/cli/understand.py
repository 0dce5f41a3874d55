"""`attune understand`: what sentences mean to the robot, as JSON Lines."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer


class InterpreterName(str, Enum):
    """Who interprets."""

    grammar = "grammar"
    llm = "llm"


def understand(
    interpreter: Annotated[
        InterpreterName, typer.Option(help="The embedded grammar, or the configured language model.")
    ] = (InterpreterName.grammar),
    source: Annotated[Path | None, typer.Option("--in", help="File of JSON Lines; standard input without it.")] = None,
    target: Annotated[
        Path | None, typer.Option("--out", help="Where the results go; standard output without it.")
    ] = None,
) -> None:
    """Tell what sentences mean: JSON Lines in, JSON Lines out.

    Each input line is {"id", "utterance", "context"}; each output line is {"id", "command", "add", "remove",
    "destination", "reply", "confidence", "reason"}, in the same order. A bad line gives {"line", "error"}.

    Example: echo '{"id": 1, "utterance": "bring me the red cup"}' | attune understand
    """
    import sys

    from attune.cli.understanding import interpret_lines, make_interpreter, write_whole
    from attune.core.clock import RealClock, run
    from attune.core.errors import AttuneError

    chosen = make_interpreter(interpreter.value)
    if source is None:
        lines = sys.stdin.buffer.read()
    else:
        try:
            lines = source.read_bytes()
        except OSError as error:
            raise AttuneError(f"{source} cannot be read: {error.strerror}", "Give a file of JSON Lines") from None
    results: list[str] = []
    emit = typer.echo if target is None else results.append
    run(lambda: interpret_lines(lines, chosen, emit), RealClock())
    if target is not None:
        write_whole(target, results)
