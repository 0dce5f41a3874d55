"""`attune eval language`: how well an interpreter understands people, beside the paper's table."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer


class PartChoice(StrEnum):
    """Which part of the benchmark."""

    ALL = "all"
    PAPER = "paper"
    HARD = "hard"
    FRESH = "fresh"


class InterpreterChoice(StrEnum):
    """Who understands."""

    GRAMMAR = "grammar"
    LLM = "llm"


def eval_language(
    interpreter: Annotated[
        InterpreterChoice, typer.Option(help="The embedded one, or the language model of [llm].")
    ] = InterpreterChoice.GRAMMAR,
    part: Annotated[
        PartChoice, typer.Option(help="The paper's recipe, harder sentences, fresh ones, or all.")
    ] = PartChoice.ALL,
    sample: Annotated[int, typer.Option(min=0, help="At most so many items of each part, spread; 0 takes all.")] = 0,
    at_once: Annotated[int, typer.Option(min=1, help="Questions to the language model at the same time.")] = 4,
    out: Annotated[Path, typer.Option(help="Gets language.md and language.json.")] = Path("language-evaluation"),
    config: Annotated[Path | None, typer.Option(help="Configuration file, if not attune.toml.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Measure commands and properties on 2611 instructions after the paper's recipe, and on harder ones.

    Example: attune eval language --part hard
    """
    import json

    from rich.console import Console
    from rich.markdown import Markdown
    from rich.progress import Progress

    from attune.cli.understanding import interpret_lines
    from attune.core.clock import RealClock, run
    from attune.core.config import load_config, with_values
    from attune.core.errors import AttuneError
    from attune.core.scene import load_scene
    from attune.dialogue.choice import chosen_interpreter
    from attune.evaluation.language.items import Item, Part
    from attune.evaluation.language.report import LanguageReport
    from attune.evaluation.language.run import benchmark_items, evaluate

    settings = with_values(load_config(config), {"dialogue": {"interpreter": interpreter.value}, "llm": {"history": 0}})
    parts: dict[PartChoice, tuple[Part, ...]] = {
        PartChoice.ALL: ("paper", "hard", "fresh"), PartChoice.PAPER: ("paper",), PartChoice.HARD: ("hard",),
        PartChoice.FRESH: ("fresh",),
    }  # fmt: skip
    items = benchmark_items(parts[part], sample)
    scene = load_scene(Path(settings.robot.scene) if settings.robot.scene else None)
    model = settings.llm.model if interpreter is InterpreterChoice.LLM else ""
    clock = RealClock()

    async def ask_all() -> LanguageReport:
        with Progress(console=Console(stderr=True), transient=True) as bars:
            bar = bars.add_task("understanding", total=len(items))
            async with chosen_interpreter(settings, scene, clock) as chosen:

                async def respond(asked: Sequence[Item], receive: Callable[[dict[str, Any]], None]) -> None:
                    lines = [
                        json.dumps({"id": item.id, "utterance": item.utterance, "context": dict(item.context)})
                        for item in asked
                    ]
                    data = "\n".join(lines).encode()
                    await interpret_lines(data, chosen, lambda line: receive(json.loads(line)))

                return await evaluate(
                    model or "embedded", items, respond, clock,
                    model=model, at_once=at_once if model else 1, on_progress=lambda: bars.advance(bar),
                )  # fmt: skip

    report = run(ask_all, clock)
    text, data = report.to_markdown(), json.dumps(report.to_data(), indent=2)
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "language.md").write_text(text, encoding="utf-8")
        (out / "language.json").write_text(data + "\n", encoding="utf-8")
    except OSError as error:
        raise AttuneError(f"{out} cannot be written: {error.strerror}", "Give another folder with --out") from None
    if as_json:
        typer.echo(data)
    else:
        console = Console()
        # The table is wide: cut it for nobody who reads it from a file.
        wide = console if console.is_terminal else Console(width=max(console.width, 112))
        wide.print(Markdown(text.split("\n## Errors")[0]))
        typer.echo(f"{len(report.errors)} errors are listed in {out / 'language.md'}.")
