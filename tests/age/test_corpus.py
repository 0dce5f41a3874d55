"""Common Voice is read, filtered and cut as the documentation says."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import soundfile

from attune.core.messages import AGE_GROUPS
from attune.training.clips import ClipError, read_clip
from attune.training.common_voice import Clip, CommonVoiceError, read_common_voice, split_clips


def clips(speakers: int, each: int, group: int = 0) -> list[Clip]:
    return [
        Clip(Path(f"{group}-{speaker}-{number}.mp3"), f"{group}-{speaker}", group, "")
        for speaker in range(speakers)
        for number in range(each)
    ]


def test_the_files_are_merged_and_unusable_rows_counted(corpus: Path) -> None:
    found = read_common_voice(corpus)
    assert len(found.clips) == 220
    assert len({clip.speaker for clip in found.clips}) == 40
    assert found.dropped == {"without age": 6, "of speakers with too few clips": 3}
    assert {AGE_GROUPS[clip.group] for clip in found.clips} == {"twenties", "fourties", "sixties", "eighties"}


def test_a_missing_column_is_named_with_those_that_are_there(corpus: Path, tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    text = (corpus / "train.tsv").read_text().replace("\tage\t", "\tyears\t")
    (tmp_path / "train.tsv").write_text(text)
    with pytest.raises(CommonVoiceError, match=r"train\.tsv lacks the column age .*client_id.*years"):
        read_common_voice(tmp_path, ("train",))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    with pytest.raises(CommonVoiceError, match=r"train\.tsv cannot be read"):
        read_common_voice(tmp_path)


def test_the_folder_above_the_language_is_explained(corpus: Path) -> None:
    with pytest.raises(CommonVoiceError, match="Give one of its languages: en"):
        read_common_voice(corpus.parent)


def test_a_corpus_without_ages_says_how_many_were_dropped(tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    (tmp_path / "train.tsv").write_text("client_id\tpath\tage\na\tx.mp3\t\nb\ty.mp3\tancient\n")
    with pytest.raises(CommonVoiceError, match="1 without age, 1 unknown age"):
        read_common_voice(tmp_path, ("train",))


def test_newer_spellings_and_paths_that_lead_elsewhere_are_tamed(tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    (tmp_path / "train.tsv").write_text(
        'client_id\tpath\tage\tgender\tsentence\na\t../../etc/x.mp3\tforties\tfemale_feminine\tshe said "no\n'
        "a\tplain\tfourties\tmale_masculine\tyes\n"
    )
    first, second = read_common_voice(tmp_path, ("train",), minimum=1).clips
    assert first.path == tmp_path / "clips" / "x.mp3"
    assert (first.group, first.gender) == (AGE_GROUPS.index("fourties"), "female")
    assert (second.path.name, second.gender) == ("plain.mp3", "male")


def test_no_voice_is_in_two_parts_and_each_group_is_in_all() -> None:
    every = [clip for group in range(9) for clip in clips(20, 5 + group % 3, group)]
    split = split_clips(every, seed=3)
    parts = (split.training, split.validation, split.test)
    speakers = [{clip.speaker for clip in part} for part in parts]
    assert not (speakers[0] & speakers[1] or speakers[0] & speakers[2] or speakers[1] & speakers[2])
    assert all({clip.group for clip in part} == set(range(9)) for part in parts)
    assert sum(map(len, parts)) == len(every)
    assert len(split.test) / len(every) == pytest.approx(0.3, abs=0.03)


def test_the_papers_split_has_the_same_voices_on_both_sides() -> None:
    split = split_clips(clips(20, 10), by="sample")
    assert len(split.test) == 60
    assert {clip.speaker for clip in split.test} & {clip.speaker for clip in split.training}


def test_a_split_depends_on_its_seed_alone() -> None:
    every = clips(30, 5)
    assert split_clips(every, seed=1) == split_clips(every, seed=1)
    assert split_clips(every, seed=1) != split_clips(every, seed=2)


def test_too_few_speakers_are_refused() -> None:
    with pytest.raises(CommonVoiceError, match="of 1 speakers leave none"):
        split_clips(clips(1, 9))


def test_clips_of_any_rate_become_16_khz_mono(tmp_path: Path) -> None:
    tone = 0.5 * np.sin(2 * np.pi * 440 * np.arange(44_100) / 44_100)
    soundfile.write(tmp_path / "tone.flac", np.stack([tone, tone], axis=1), 44_100)
    samples = read_clip(tmp_path / "tone.flac")
    assert samples.shape == (16_000,)
    assert samples.dtype == np.float32
    assert np.abs(np.fft.rfft(samples)).argmax() == 440


@pytest.mark.parametrize("kind", ["missing", "text", "cut", "silent", "short"])
def test_a_damaged_clip_is_refused_with_its_name(kind: str, tmp_path: Path, corpus: Path) -> None:
    path = tmp_path / "clip.wav"
    if kind == "text":
        path.write_text("no sound")
    elif kind == "cut":
        shutil.copy(read_common_voice(corpus).clips[3].path, path)
        path.write_bytes(path.read_bytes()[:90])
    elif kind == "silent":
        soundfile.write(path, np.zeros(16_000), 16_000)
    elif kind == "short":
        soundfile.write(path, np.ones(100) * 0.1, 16_000)
    with pytest.raises(ClipError, match=r"clip\.wav"):
        read_clip(path)
