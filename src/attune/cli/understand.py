"""`attune understand`: what sentences mean to the robot, as JSON Lines."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class InterpreterName(StrEnum):
    """Who interprets."""

    grammar = "grammar"
    llm = "llm"


def understand(
    interpreter: Annotated[
        InterpreterName, typer.Option(help="The embedded grammar, or the configured language model.")
    ] = InterpreterName.grammar,
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

    from attune.cli.understanding import interpret_lines, write_whole
    from attune.core.clock import RealClock, run
    from attune.core.config import load_config, with_values
    from attune.core.errors import AttuneError
    from attune.core.scene import load_scene
    from attune.dialogue.choice import chosen_interpreter

    # Each line stands for itself: the language model is told of no earlier ones.
    config = with_values(load_config(), {"dialogue": {"interpreter": interpreter.value}, "llm": {"history": 0}})
    scene = load_scene(Path(config.robot.scene) if config.robot.scene else None)
    clock = RealClock()
    if source is None:
        lines = sys.stdin.buffer.read()
    else:
        try:
            lines = source.read_bytes()
        except OSError as error:
            raise AttuneError(f"{source} cannot be read: {error.strerror}", "Give a file of JSON Lines") from None
    results: list[str] = []
    emit = typer.echo if target is None else results.append

    async def interpret() -> None:
        async with chosen_interpreter(config, scene, clock) as chosen:
            await interpret_lines(lines, chosen, emit)

    run(interpret, clock)
    if target is not None:
        write_whole(target, results)
