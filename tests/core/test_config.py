"""A wrong configuration is refused with the key, the value and what is allowed."""

from pathlib import Path

import pytest

from attune.core.config import Config, ConfigError, load_config


def write(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "attune.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_everything_has_a_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_config(environment={}) == Config()


def test_the_file_in_the_working_directory_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "[speech]\nend_silence = 0.9\n")
    monkeypatch.chdir(tmp_path)
    assert load_config(environment={}).speech.end_silence == 0.9


def test_the_environment_overrides_the_file(tmp_path: Path) -> None:
    file = write(tmp_path, '[speech]\nasr = "whisper"\n')
    assert load_config(file, {"ATTUNE_SPEECH__ASR": "sphinx"}).speech.asr == "sphinx"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[speech]\nasrr = 'sphinx'\n", ("speech.asrr", "sphinx", "end_silence")),
        ("[speach]\nasr = 'sphinx'\n", ("speach", "speech, dialogue, planner")),
        ("[speech]\nasr = 'siri'\n", ("speech.asr", "siri", "'auto', 'sphinx' or 'whisper'")),
        ("[speech]\nvoice_on = 7\n", ("speech.voice_on", "7", "less than 1")),
        ("[speech]\nvoice_on = \n", ("not valid TOML", "line 2")),
        ("speech = 3\n", ("speech", "3")),
    ],
)
def test_a_wrong_file_is_refused_and_named(tmp_path: Path, text: str, named: tuple[str, ...]) -> None:
    file = write(tmp_path, text)
    with pytest.raises(ConfigError) as error:
        load_config(file, {})
    for part in (str(file), *named):
        assert part in str(error.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="nowhere.toml cannot be read"):
        load_config(tmp_path / "nowhere.toml", {})


def test_the_key_of_a_language_model_comes_from_the_environment_only(tmp_path: Path) -> None:
    config = load_config(write(tmp_path, '[llm]\nmodel = "small"\n'), {"ATTUNE_LLM__API_KEY": "sk-secret"})
    assert config.llm.api_key.get_secret_value() == "sk-secret"
    assert "sk-secret" not in repr(config)
    with pytest.raises(ConfigError, match="ATTUNE_LLM__API_KEY") as caught:
        load_config(write(tmp_path, '[llm]\napi_key = "sk-secret"\n'), {})
    assert "sk-secret" not in str(caught.value)


def test_a_misspelt_key_is_not_repeated(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="llm.api_kei") as caught:
        load_config(write(tmp_path, ""), {"ATTUNE_LLM__API_KEI": "sk-secret"})
    assert "sk-secret" not in str(caught.value)
