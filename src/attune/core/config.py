"""Configuration: one validated TOML file, `attune.toml`, with a default for everything.

Environment variables override the file: `ATTUNE_SPEECH__ASR=sphinx` sets `asr` of `[speech]`. Secrets come from the
environment only.
"""

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, SecretStr, ValidationError

from attune.core.errors import AttuneError
from attune.core.messages import AgeGroup

FILE_NAME = "attune.toml"


class ConfigError(AttuneError):
    """The configuration is wrong; the message names key, value and what is allowed."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SpeechConfig(_Section):
    """Hearing."""

    asr: Literal["auto", "sphinx", "whisper"] = "auto"
    voice_on: float = Field(0.5, gt=0, lt=1)
    """Voice activity probability at which speech begins."""
    voice_off: float = Field(0.35, gt=0, lt=1)
    """Voice activity probability under which a pause begins."""
    pre_roll: float = Field(0.3, ge=0, le=2)
    """Audio kept from before the beginning [s]."""
    end_silence: float = Field(0.8, gt=0, le=5)
    """Pause after which an utterance ends [s], when it is not known whether it is complete."""
    end_silence_complete: float = Field(0.5, gt=0, le=5)
    """The same after what is a whole command [s]."""
    end_silence_fragment: float = Field(1.4, gt=0, le=5)
    """The same after a fragment such as "bring me the" [s]."""
    more_time_for_older: float = Field(1.5, ge=1, le=3)
    """For older adults, these three pauses are so many times longer."""
    max_utterance: float = Field(20.0, gt=0, le=120)
    """Longest utterance [s]; it ends there, and what was heard is used."""
    whisper_model: str = "small.en"
    """Whisper's weights: a size, a name on the Hugging Face hub, or a folder (converted for CTranslate2)."""
    echo_cancellation: bool = True
    """Whether the robot's own voice is taken out of what the microphone hears while the loudspeaker is on."""
    noise_suppression: bool = True
    """Whether steady noise is lowered before anything is recognised; needs the extra `echo`."""
    microphone: str = ""
    """Name or number of the input device; "" takes the system's default."""
    age: str = "norms"
    """How the speaker's age group is estimated: `norms`, `off`, or the folder or hub name of a trained model."""
    older_from: AgeGroup = "sixties"
    """The first age group that counts as older."""


class DialogueConfig(_Section):
    """Understanding and answering."""

    interpreter: Literal["auto", "grammar", "llm"] = "auto"
    """`auto`: the language model of `[llm]` if one is named there, else the embedded interpreter."""
    confidence_ignore: float = Field(0.15, ge=0, le=1)
    """What was recognised less surely than this is ignored."""
    confidence_ask: float = Field(0.3, ge=0, le=1)
    """What was recognised less surely than this is asked back instead of done."""
    fragment_wait: float = Field(1.5, ge=0, le=10)
    """How long a fragment ("bring me the") waits for its continuation [s]."""
    question_expires: float = Field(20.0, gt=0, le=300)
    """How long an answer is taken for one to the robot's question [s]."""
    stop_waits_for_text: float = Field(3.0, gt=0, le=30)
    """A spotted stop is taken back if no final text has confirmed it after this long [s]."""
    policies: str = ""
    """Path of a file of policies; "" takes the one that comes with Attune."""
    replies: str = ""
    """Path of a file of replies; "" takes the one that comes with Attune."""
    lexicon: str = ""
    """Path of a lexicon; "" takes the one that comes with Attune."""


class LlmConfig(_Section):
    """A language model at any endpoint that speaks OpenAI's protocol: OpenAI, Ollama, vLLM, llama.cpp."""

    base_url: str = Field("", pattern="^(https?://.+)?$")
    """Where it is: `http://localhost:11434/v1`. "" means that there is none."""
    model: str = ""
    """Its name there."""
    api_key: SecretStr = SecretStr("")
    """From the environment only: `ATTUNE_LLM__API_KEY`. Endpoints on the own machine need none."""
    deadline: float = Field(2.5, gt=0, le=60)
    """The embedded interpreter answers if the model has not after this long [s]."""
    history: int = Field(4, ge=0, le=20)
    """Earlier turns that the model is told."""
    temperature: float = Field(0.0, ge=0, le=2)
    max_tokens: int = Field(300, ge=50, le=4000)
    """Longest answer."""


class PlannerConfig(_Section):
    """Planning."""

    breakfast: tuple[str, ...] = ("bowl", "cereal", "milk", "spoon")
    """Object types that setting_breakfast brings."""
    destination_younger: str = "countertop"
    destination_older: str = "table"
    destination_unknown: str = "table"
    """Where things are delivered when the person names no place, by age band (paper, section 3)."""


class RobotConfig(_Section):
    """The robot."""

    kind: Literal["mujoco", "symbolic"] = "mujoco"
    """`mujoco`: the PR2 with physics. `symbolic`: no physics, for developing plans."""
    scene: str = ""
    """Path of a scene file; "" takes the kitchen that comes with Attune."""
    seed: int = 0
    friction_only: bool = False
    """Hold objects by the pads' friction alone, instead of fixing what both pads press to the palm."""
    camera_noise: float = Field(0.002, ge=0, le=0.05)
    """Standard deviation of the positions that perception reports [m]."""
    camera_miss: float = Field(0.0, ge=0, lt=1)
    """Probability that perception misses an object it could see, in one look."""


class VoiceConfig(_Section):
    """Speaking."""

    output: Literal["speaker", "file", "none"] = "speaker"
    """`file` writes what is spoken into `file`; `none` speaks to nobody, at the same pace."""
    file: str = "attune-voice.wav"
    engine: Literal["espeak", "piper"] = "espeak"
    """`piper` sounds more natural and needs a voice's file."""
    voice: str = "en-gb"
    """For espeak the language, and after a `+` a variant: `en-gb`, `en-us+f3`. For Piper a voice's name or file."""
    device: str = ""
    """Name or number of the output device; "" takes the system's default."""
    barge_in: float = Field(0.8, ge=0, le=5)
    """The robot pauses for a person who speaks, and drops the rest if they go on for this long [s]; after a shorter
    "uh-huh" it goes on. Counts until 0.2 s after the last sound."""


class Config(_Section):
    """The whole configuration."""

    speech: SpeechConfig = SpeechConfig()
    dialogue: DialogueConfig = DialogueConfig()
    planner: PlannerConfig = PlannerConfig()
    robot: RobotConfig = RobotConfig()
    voice: VoiceConfig = VoiceConfig()
    llm: LlmConfig = LlmConfig()


def load_config(path: Path | None = None, environment: Mapping[str, str] = os.environ) -> Config:
    """Read the configuration.

    Args:
        path: The file; None takes `attune.toml` of the working directory if there is one.
        environment: Where the overrides come from.

    Raises:
        ConfigError: The file is missing or malformed, a key is unknown, or a value is not allowed.
    """
    data: dict[str, Any] = {}
    source = path or (Path(FILE_NAME) if Path(FILE_NAME).exists() else None)
    if source is not None:
        try:
            data = tomllib.loads(source.read_text(encoding="utf-8"))
        except OSError as error:
            raise ConfigError(f"{source} cannot be read: {error.strerror}", "Give the path of a TOML file") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ConfigError(f"{source} is not valid TOML: {error}", "Correct the file at the named place") from None
        if isinstance(data.get("llm"), dict) and "api_key" in data["llm"]:
            raise ConfigError(f"{source}: llm.api_key is a secret", "Give it as ATTUNE_LLM__API_KEY in the environment")
    for name, value in environment.items():
        section, separator, key = name.removeprefix("ATTUNE_").lower().partition("__")
        if name.startswith("ATTUNE_") and separator:
            table = data.setdefault(section, {})
            if isinstance(table, dict):
                table[key] = value
    try:
        return Config.model_validate(data)
    except ValidationError as error:
        raise _explain(error, str(source or "the environment")) from None


def with_values(config: Config, values: Mapping[str, Mapping[str, Any]]) -> Config:
    """A copy with some values changed, validated like a file: `{"voice": {"output": "none"}}`.

    Raises:
        ConfigError: A key or value is not allowed.
    """
    data = config.model_dump()
    for section, entries in values.items():
        data[section] |= entries
    try:
        return Config.model_validate(data)
    except ValidationError as error:
        raise _explain(error, "the command line") from None


def _explain(error: ValidationError, source: str) -> ConfigError:
    item = error.errors()[0]
    key = ".".join(str(part) for part in item["loc"])
    if item["type"] == "extra_forbidden":
        known: type[BaseModel] = Config
        for part in item["loc"][:-1]:
            known = type(getattr(known(), str(part)))
        allowed = ", ".join(known.model_fields)
        # A misspelt api_key must not end up in a log.
        value = "" if item["loc"][0] == "llm" else f" (value {item['input']!r})"
        return ConfigError(f"{source}: unknown key {key!r}{value}", f"Known keys: {allowed}")
    return ConfigError(f"{source}: {key} = {item['input']!r} is not allowed", item["msg"])
