"""`attune devices`: the microphones and loudspeakers that Attune can use."""

import json
from typing import Annotated, Any

import typer


def devices(as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """List microphones and loudspeakers; `*` marks the system's defaults.

    Choose one with `speech.microphone` and `voice.device` in attune.toml, by its number or name.

    Example: attune devices
    """
    from attune.speech.audio import load_sounddevice

    sounddevice = load_sounddevice()
    default_input, default_output = sounddevice.default.device
    found: list[dict[str, Any]] = [
        {
            "number": number,
            "name": device["name"],
            "inputs": device["max_input_channels"],
            "outputs": device["max_output_channels"],
            "sample_rate": device["default_samplerate"],
            "default": number in {default_input, default_output},
        }
        for number, device in enumerate(sounddevice.query_devices())
    ]
    if as_json:
        typer.echo(json.dumps(found, indent=2, ensure_ascii=False))
        return
    if not found:
        typer.echo("No microphone and no loudspeaker found. Attune can still listen to files and take typed text.")
    for device in found:
        kinds = [kind for kind, count in (("hears", device["inputs"]), ("speaks", device["outputs"])) if count]
        typer.echo(f"{'*' if device['default'] else ' '} {device['number']:>2}  {device['name']}  ({', '.join(kinds)})")
