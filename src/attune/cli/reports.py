"""What the evaluation commands share: a progress bar, and a report as Markdown and JSON, in files and on the screen."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from attune.core.errors import AttuneError


@contextmanager
def progress(title: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on the error stream; call what it gives with how many of how many are done."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task(title, total=None)
        yield lambda done, total: bars.update(bar, completed=done, total=total)


def show_report(name: str, text: str, data: dict[str, Any], folder: Path, *, as_json: bool) -> None:
    """Write `name`.md and `name`.json into a folder, and print one of them.

    Raises:
        AttuneError: The folder cannot be written.
    """
    from rich.console import Console
    from rich.markdown import Markdown

    as_text = json.dumps(data, indent=2)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
        (folder / f"{name}.json").write_text(as_text + "\n", encoding="utf-8")
    except OSError as error:
        raise AttuneError(f"{folder} cannot be written: {error.strerror}", "Give another folder with --out") from None
    if as_json:
        typer.echo(as_text)
    else:
        console = Console()
        # The tables are wide: cut them for nobody who reads them from a file.
        wide = console if console.is_terminal else Console(width=max(console.width, 112))
        wide.print(Markdown(text))
        typer.echo(f"written to {folder}")
