"""What hearing is measured on: Common Voice, a list of recordings, or synthetic speech, which is never called human.

A list of recordings is JSON Lines: `{"audio": "clips/1.wav", "text": "bring me a cup", "speaker": "anna", "kind":
"request"}`. `audio` counts from the list's folder; `speaker` ("") and `kind` (`request`, `off_topic`, `stop` or
`not_stop`; "request") may be left out.
"""

import csv
import json
import shutil
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from attune.core.errors import AttuneError
from attune.evaluation.speakers import Speaker
from attune.speech.audio import Samples, read_recording

Kind = Literal["request", "off_topic", "stop", "not_stop"]
KINDS: tuple[Kind, ...] = get_args(Kind)

T = TypeVar("T")


class ManifestError(AttuneError):
    """A list of recordings cannot be used."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One thing that somebody says.

    Attributes:
        text: What is said.
        speaker: Whose voice it is; the samples of one speaker are heard one after the other.
        kind: What the robot should make of it.
        path: The recording; None for synthetic speech.
        voice: Who says it, for synthetic speech.
    """

    text: str
    speaker: str = ""
    kind: Kind = "request"
    path: Path | None = None
    voice: Speaker | None = None

    def sound(self) -> Samples:
        """As 16 kHz mono.

        Raises:
            AudioError: The recording cannot be used.
        """
        if self.voice is not None:
            return self.voice.say(self.text)
        if self.path is None:
            raise ValueError("a sample needs a recording or a voice")
        return read_recording(self.path)


@dataclass(frozen=True, slots=True)
class SampleSet:
    """Samples, and what they are.

    Attributes:
        name: For the report.
        description: One sentence that says on what audio the figures are.
        source: `common_voice` and `recordings` may be human; `synthetic` never is.
        domain: Whether people talk to the robot in them; else only the transcript is measured.
    """

    name: str
    description: str
    source: Literal["common_voice", "recordings", "synthetic"]
    samples: tuple[Sample, ...]
    domain: bool = True


class _Sentences(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    requests: tuple[str, ...]
    off_topic: tuple[str, ...]
    stops: tuple[str, ...]
    not_stops: tuple[str, ...]


class _Line(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)
    audio: str
    text: str
    speaker: str = ""
    kind: Kind = "request"


def held_out_speakers() -> tuple[Speaker, ...]:
    """Synthetic people whom nothing was tuned with: espeak-ng's, then flite's (better ones) where it is installed.

    Rejection was fitted with flite's `rms`, so that is not among them.
    """
    espeak = (
        Speaker("nora", "en-us+f5", 155, 50),
        Speaker("oscar", "en-us+m3", 150, 50),
        Speaker("paula", "en-gb+f4", 145, 55),
        Speaker("quentin", "en-gb-x-rp+m7", 140, 40, sounds="older"),
    )
    if not shutil.which("flite"):
        return espeak
    return espeak + tuple(Speaker(f"flite-{voice}", f"flite:{voice}") for voice in ("slt", "awb", "kal16"))


def synthetic_set(speakers: Sequence[Speaker], most: int = 0, kinds: Sequence[Kind] = KINDS) -> SampleSet:
    """Every speaker says the sentences of `data/benchmarks/speech`.

    Args:
        speakers: Who speaks.
        most: At most so many sentences of each kind, spread over the list; 0 takes all.
        kinds: Which kinds.
    """
    by_kind = _sentences()
    samples = [
        Sample(text, speaker.name, kind, voice=speaker)
        for speaker in speakers
        for kind in kinds
        for text in _spread(by_kind[kind], most)
    ]
    engines = sorted({"flite" if speaker.voice.startswith("flite:") else "espeak-ng" for speaker in speakers})
    return SampleSet(
        "synthetic",
        f"synthetic speech, no human: {len(speakers)} voices of {' and '.join(engines)}, held-out sentences",
        "synthetic",
        tuple(samples),
    )


def read_samples(path: Path, most: int = 0) -> SampleSet:
    """The samples of a JSON Lines list, of a Common Voice TSV file, or of a Common Voice folder (its test.tsv).

    Args:
        path: The list, file or folder.
        most: At most so many, spread; 0 takes all.

    Raises:
        ManifestError: It is missing, empty, or has a line that is not as it should be; the message says where.
    """
    table = path / "test.tsv" if path.is_dir() else path
    if not table.is_file():
        raise ManifestError(f"{table} is not a file", "Give a .jsonl list, a Common Voice .tsv file, or its folder")
    common_voice = table.suffix == ".tsv"
    samples = _common_voice(table) if common_voice else _lines(table)
    if not samples:
        raise ManifestError(f"{table} lists no recordings", "Give a list with at least one")
    chosen = _spread(samples, most)
    if common_voice:
        about = f"Common Voice, {table.name}: {len(chosen)} of {len(samples)} clips, read aloud by people"
        return SampleSet(f"Common Voice {table.stem}", about, "common_voice", tuple(chosen), domain=False)
    about = f"{len(chosen)} of {len(samples)} recordings listed in {table.name}"
    return SampleSet(table.stem, about, "recordings", tuple(chosen))


@cache
def _sentences() -> dict[Kind, tuple[str, ...]]:
    text = (resources.files("attune.data") / "benchmarks" / "speech" / "sentences.toml").read_text("utf-8")
    found = _Sentences.model_validate(tomllib.loads(text))
    return {"request": found.requests, "off_topic": found.off_topic, "stop": found.stops, "not_stop": found.not_stops}


def _spread(items: Sequence[T], most: int) -> Sequence[T]:
    count = min(most, len(items)) if most else len(items)
    return [items[index * len(items) // count] for index in range(count)]


def _common_voice(table: Path) -> list[Sample]:
    with table.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        missing = {"path", "sentence"} - set(rows.fieldnames or ())
        if missing:
            raise ManifestError(
                f"{table} lacks the column {', '.join(sorted(missing))}", "Take the file as Common Voice publishes it"
            )
        samples = []
        for row in rows:
            # Only the name: a path in the file must not lead out of the folder.
            name = Path(row["path"] or "").name
            if name and row["sentence"]:
                clip = table.parent / "clips" / (name if Path(name).suffix else f"{name}.mp3")
                samples.append(Sample(row["sentence"], row.get("client_id") or "", path=clip))
    return samples


def _lines(table: Path) -> list[Sample]:
    samples = []
    for number, line in enumerate(table.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip():
            continue
        try:
            entry = _Line.model_validate(json.loads(line))
        except (json.JSONDecodeError, ValidationError) as error:
            problem = error.errors()[0]["msg"] if isinstance(error, ValidationError) else error.msg
            raise ManifestError(
                f"{table}, line {number}: {problem}", 'Write {"audio": "clip.wav", "text": "what is said"}'
            ) from None
        samples.append(Sample(entry.text, entry.speaker, entry.kind, path=table.parent / entry.audio))
    return samples
