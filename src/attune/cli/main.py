"""The `attune` command: it only assembles. One file per command; each imports what is heavy when it runs."""

import os
import sys
from collections.abc import Callable, Iterator
from typing import Any, NoReturn

import typer

from attune import __version__
from attune.cli.demo import demo
from attune.cli.devices import devices
from attune.cli.doctor import doctor
from attune.cli.eval_age import eval_age
from attune.cli.eval_language import eval_language
from attune.cli.eval_planner import eval_planner
from attune.cli.eval_robot import eval_robot
from attune.cli.eval_speech import eval_speech
from attune.cli.listen import listen
from attune.cli.live import live
from attune.cli.profile import profile_app
from attune.cli.say import say
from attune.cli.train_age import train_age
from attune.cli.understand import understand
from attune.core.errors import AttuneError

app = typer.Typer(
    name="attune",
    help="Talk to a household robot, interrupt it at any moment, and be understood.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

COMMANDS: tuple[Callable[..., Any], ...] = (demo, live, say, understand, listen, devices, doctor, train_age)
for command in COMMANDS:
    app.command()(command)

eval_app = typer.Typer(name="eval", help="Measure: one command per module, each with a report.", no_args_is_help=True)
eval_app.command(name="language")(eval_language)
eval_app.command(name="speech")(eval_speech)
eval_app.command(name="planner")(eval_planner)
eval_app.command(name="robot")(eval_robot)
eval_app.command(name="age")(eval_age)
app.add_typer(eval_app)
app.add_typer(profile_app, name="profile")


@app.callback(invoke_without_command=True)
def _options(version: bool = typer.Option(False, "--version", help="Show the version.")) -> None:
    if version:
        typer.echo(f"attune {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command line. An error that a person can mend is one line, not a traceback; exit status 2."""
    try:
        app()
    except (AttuneError, BrokenPipeError) as error:
        _fail(error)
    except BaseExceptionGroup as group:
        # A task group wraps what its tasks raise: show the first error that a person can mend.
        known = next((leaf for leaf in _leaves(group) if isinstance(leaf, (AttuneError, BrokenPipeError))), None)
        if known is None:
            raise
        _fail(known)


def _leaves(group: BaseExceptionGroup[BaseException]) -> Iterator[BaseException]:
    for error in group.exceptions:
        if isinstance(error, BaseExceptionGroup):
            yield from _leaves(error)
        else:
            yield error


def _fail(error: BaseException) -> NoReturn:
    if isinstance(error, BrokenPipeError):
        # Whoever read our output has enough (`| head`): end quietly, and do not flush into the closed pipe.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    typer.echo(f"attune: {error}", err=True)
    sys.exit(2)
