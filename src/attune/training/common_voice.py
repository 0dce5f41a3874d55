"""Common Voice as it is published: `train.tsv`, `dev.tsv`, `test.tsv` and a folder `clips`.

The columns that are read: `client_id` (the speaker), `path` (the clip's file name), `age` (`teens` to `nineties`, with
Common Voice's own `fourties`) and, if it is there, `gender`.
"""

import csv
import hashlib
import random
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS

COLUMNS = ("client_id", "path", "age")
PAPER_FILES = ("train", "dev")
"""What the paper merges."""
PAPER_MINIMUM = 5
"""Samples that a speaker must have in the paper."""
PAPER_TRAINING_SHARE = 0.7

_SPELLINGS = {"forties": "fourties"}
_GENDERS = {"male_masculine": "male", "female_feminine": "female"}


class CommonVoiceError(AttuneError):
    """The folder is not laid out as Common Voice, or holds nothing to learn from."""


@dataclass(frozen=True, slots=True)
class Clip:
    """One recording.

    Attributes:
        speaker: Common Voice's own hash of the speaker.
        group: Index in `AGE_GROUPS`.
        gender: As published (`male`, `female` ...), "" when not given.
    """

    path: Path
    speaker: str
    group: int
    gender: str


@dataclass(frozen=True, slots=True)
class Corpus:
    """The clips that are used, and how many were not, by reason."""

    clips: tuple[Clip, ...]
    dropped: dict[str, int]


@dataclass(frozen=True, slots=True)
class Split:
    """Clips for learning, for deciding when to stop (held-out speakers), and for the final measurement."""

    training: tuple[Clip, ...]
    validation: tuple[Clip, ...]
    test: tuple[Clip, ...]


def read_common_voice(folder: Path, files: Sequence[str] = PAPER_FILES, minimum: int = PAPER_MINIMUM) -> Corpus:
    """Read the clips whose speaker gave an age.

    Args:
        folder: Of one language; holds the TSV files and `clips`.
        files: Names of the TSV files without ending, merged.
        minimum: Clips with an age that a speaker must have.

    Raises:
        CommonVoiceError: A file or column is missing, or no clip remains; the message says which and why.
    """
    if not (folder / "clips").is_dir():
        inside = sorted(path.parent.name for path in folder.glob("*/clips"))
        remedy = f"Give one of its languages: {', '.join(inside)}" if inside else "Give the folder of one language"
        raise CommonVoiceError(f"{folder} has no folder 'clips'", remedy)
    dropped: Counter[str] = Counter()
    clips: dict[str, Clip] = {}
    for name in files:
        for row in _rows(folder / f"{name}.tsv"):
            age = (row["age"] or "").strip().lower()
            age = _SPELLINGS.get(age, age)
            gender = (row.get("gender") or "").strip().lower()
            # Only the name: a path in the file must not lead out of the folder.
            file_name = Path((row["path"] or "").strip()).name
            if not age:
                dropped["without age"] += 1
            elif age not in AGE_GROUPS:
                dropped["unknown age"] += 1
            elif not file_name or not row["client_id"]:
                dropped["without clip or speaker"] += 1
            elif file_name in clips:
                dropped["listed twice"] += 1
            else:
                path = folder / "clips" / (file_name if Path(file_name).suffix else f"{file_name}.mp3")
                clips[file_name] = Clip(path, row["client_id"], AGE_GROUPS.index(age), _GENDERS.get(gender, gender))
    counts = Counter(clip.speaker for clip in clips.values())
    kept = tuple(clip for clip in clips.values() if counts[clip.speaker] >= minimum)
    dropped["of speakers with too few clips"] = len(clips) - len(kept)
    if not kept:
        reasons = ", ".join(f"{count} {reason}" for reason, count in dropped.items() if count) or "the files are empty"
        raise CommonVoiceError(f"{folder} has no clip to learn from ({reasons})", "Lower --minimum-clips or take more")
    return Corpus(kept, {reason: count for reason, count in dropped.items() if count})


def split_clips(
    clips: Sequence[Clip],
    *,
    training_share: float = PAPER_TRAINING_SHARE,
    validation_share: float = 0.1,
    by: Literal["speaker", "sample"] = "speaker",
    seed: int = 0,
) -> Split:
    """Cut a corpus in three, the same way for the same arguments.

    Args:
        clips: What to cut.
        training_share: Of the clips, for learning and validation together; the rest is for testing.
        validation_share: Of those for learning.
        by: `speaker`: no voice is in two parts, and each age group is cut by itself. `sample`: as in the paper, where
            the same voices are on both sides; only for comparison. Validation is by speaker in both.
        seed: Of the choice.

    Raises:
        CommonVoiceError: A part would be empty.
    """
    shuffle = random.Random(seed)
    if by == "sample":
        order = list(clips)
        shuffle.shuffle(order)
        cut = round(len(order) * training_share)
        learning, test = order[:cut], order[cut:]
    else:
        learning, test = _cut_by_speaker(clips, training_share, shuffle)
    training, validation = _cut_by_speaker(learning, 1 - validation_share, shuffle)
    for part, name in ((training, "learning"), (validation, "validation"), (test, "testing")):
        if not part:
            speakers = len({clip.speaker for clip in clips})
            raise CommonVoiceError(
                f"{len(clips)} clips of {speakers} speakers leave none for {name}",
                "Take more speakers, or other shares",
            )
    return Split(tuple(training), tuple(validation), tuple(test))


def describe(clips: Iterable[Clip]) -> dict[str, object]:
    """Counts for reports: clips, speakers, and clips by age group and by gender."""
    chosen = list(clips)
    return {
        "clips": len(chosen),
        "speakers": len({clip.speaker for clip in chosen}),
        "by_group": {group: sum(clip.group == index for clip in chosen) for index, group in enumerate(AGE_GROUPS)},
        "by_gender": dict(Counter(clip.gender or "not given" for clip in chosen).most_common()),
    }


def fingerprint_of_clips(clips: Sequence[Clip]) -> str:
    """Hash of the names of clips, by which an evaluation knows that it has the same ones."""
    return hashlib.sha256("\n".join(sorted(clip.path.name for clip in clips)).encode()).hexdigest()


def _rows(path: Path) -> Iterable[dict[str, str | None]]:
    try:
        file = path.open(encoding="utf-8", newline="")
    except OSError as error:
        raise CommonVoiceError(f"{path} cannot be read: {error.strerror}", "Give Common Voice's own folder") from None
    with file:
        rows = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        found = list(rows.fieldnames or [])
        missing = [column for column in COLUMNS if column not in found]
        if missing:
            raise CommonVoiceError(
                f"{path} lacks the column {', '.join(missing)} (it has: {', '.join(found) or 'none'})",
                "Take the TSV files as Common Voice publishes them",
            )
        yield from rows


def _cut_by_speaker(clips: Sequence[Clip], share: float, shuffle: random.Random) -> tuple[list[Clip], list[Clip]]:
    """Whole speakers on either side, group by group, so that both sides have every group that has two speakers."""
    by_speaker: defaultdict[str, list[Clip]] = defaultdict(list)
    for clip in clips:
        by_speaker[clip.speaker].append(clip)
    by_group: defaultdict[int, list[str]] = defaultdict(list)
    for speaker, own in by_speaker.items():
        by_group[Counter(clip.group for clip in own).most_common(1)[0][0]].append(speaker)
    first: list[Clip] = []
    second: list[Clip] = []
    for group in sorted(by_group):
        speakers = sorted(by_group[group])
        shuffle.shuffle(speakers)
        wanted = share * sum(len(by_speaker[speaker]) for speaker in speakers)
        taken = 0
        for index, speaker in enumerate(speakers):
            own = by_speaker[speaker]
            last_of_several = index == len(speakers) - 1 and index > 0
            if index == 0 or (taken + len(own) / 2 <= wanted and not last_of_several):
                first += own
                taken += len(own)
            else:
                second += own
    return first, second
