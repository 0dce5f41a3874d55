"""`attune profile`: what is remembered about people, for them to see, take away and erase."""

from pathlib import Path
from typing import Annotated

import typer

profile_app = typer.Typer(
    help="See, take away and erase what is remembered about people.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)

_File = Annotated[Path | None, typer.Option("--file", help="The file with the profiles, if it is not the usual one.")]
_Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
_Person = Annotated[str, typer.Argument(help="Whose profile; without a name, your own.")]


@profile_app.command("list")
def list_profiles(as_json: _Json = False, file: _File = None) -> None:
    """List everybody about whom something is remembered.

    Example: attune profile list
    """
    import json

    from attune.dialogue.profiles import ProfileStore

    store = ProfileStore(file)
    profiles = store.all()
    if as_json:
        people = [{"person": p.person, "consented_at": p.consented_at, "changed_at": p.changed_at} for p in profiles]
        typer.echo(json.dumps(people, indent=2))
    elif profiles:
        for profile in profiles:
            typer.echo(f"{profile.person}  (agreed {profile.consented_at}, changed {profile.changed_at})")
    else:
        typer.echo("Nothing is remembered about anybody.")


@profile_app.command()
def show(person: _Person = "me", as_json: _Json = False, file: _File = None) -> None:
    """Show what is remembered about one person.

    Example: attune profile show
    """
    import json

    from attune.dialogue.profiles import ProfileStore

    (data,) = ProfileStore(file).export(person)
    if as_json:
        typer.echo(json.dumps(data, indent=2))
        return
    typer.echo(f"{data['person']}: agreed {data['consented_at']}, changed {data['changed_at']}")
    typer.echo(f"  age: {data['age']}")
    for key, value in data["preferences"].items():
        typer.echo(f"  {key.replace('_', ' ')}: {value if value is not None else 'as usual'}")


@profile_app.command()
def export(
    person: Annotated[str, typer.Argument(help="Whose profile; without a name, everybody's.")] = "",
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write to this file instead of printing.")] = None,
    file: _File = None,
) -> None:
    """Write everything that is remembered as JSON.

    Example: attune profile export --out profiles.json
    """
    import json
    import os

    from attune.core.errors import AttuneError
    from attune.dialogue.profiles import ProfileStore

    text = json.dumps(ProfileStore(file).export(person or None), indent=2) + "\n"
    if out is None:
        typer.echo(text, nl=False)
        return
    try:
        with os.fdopen(os.open(out, os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600), "w", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise AttuneError(f"{out} cannot be written: {error.strerror}", "Give another file with --out") from None
    typer.echo(f"Written to {out}.")


@profile_app.command()
def erase(
    person: _Person = "me",
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")] = False,
    file: _File = None,
) -> None:
    """Forget a person for good.

    Example: attune profile erase me --yes
    """
    from attune.dialogue.profiles import NoProfileError, ProfileStore

    store = ProfileStore(file)
    if person not in store.people():
        raise NoProfileError(person, store.people())
    if not yes:
        typer.confirm(f"Forget everything about {person!r}?", abort=True)
    store.erase(person)
    typer.echo(f"Everything about {person!r} is forgotten.")
