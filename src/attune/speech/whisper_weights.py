"""Where Whisper's weights come from: a folder, or the Hugging Face hub, fetched once and then kept in its cache."""

from pathlib import Path

from attune.core.errors import AttuneError
from attune.speech.age.hub import require

NEEDED_FOR = "the Whisper recogniser"
_FILES = ["config.json", "preprocessor_config.json", "model.bin", "tokenizer.json", "vocabulary.*"]


class WhisperWeightsError(AttuneError):
    """The weights are not here and cannot be fetched."""

    retryable = True

    def __init__(self, model: str, reason: str) -> None:
        super().__init__(
            f"the weights of Whisper {model!r} cannot be had: {reason}",
            "Connect to the network once, or set `speech.whisper_model` to a folder with converted weights, or "
            "`speech.asr` to sphinx",
        )


def require_whisper() -> None:
    """Make sure that the libraries are installed.

    Raises:
        MissingDependencyError: One is not.
    """
    require("faster_whisper", "huggingface_hub", extra="whisper", needed_for=NEEDED_FOR)


def cached_weights(model: str) -> Path | None:
    """The folder of weights that are on this machine, or None. Needs no network.

    Args:
        model: Folder of converted weights, size (`small.en`), or name on the hub.

    Raises:
        MissingDependencyError: The libraries are not installed.
    """
    folder = Path(model).expanduser()
    if folder.is_dir():
        return _complete(folder)
    if _looks_like_a_path(model):
        return None
    require_whisper()
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import HFValidationError, LocalEntryNotFoundError

    try:
        return _complete(Path(snapshot_download(_on_hub(model), allow_patterns=_FILES, local_files_only=True)))
    except (LocalEntryNotFoundError, HFValidationError):
        return None


def fetch_weights(model: str) -> Path:
    """The folder of the weights; fetched first if need be, with a progress bar on standard error.

    Args:
        model: As for `cached_weights`.

    Raises:
        WhisperWeightsError: There is no such model, or the hub cannot be reached.
        MissingDependencyError: The libraries are not installed.
    """
    if found := cached_weights(model):
        return found
    if Path(model).expanduser().is_dir():
        raise WhisperWeightsError(model, "the folder has no model.bin")
    if _looks_like_a_path(model):
        raise WhisperWeightsError(model, "there is no such folder")
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import HFValidationError, LocalEntryNotFoundError, RepositoryNotFoundError

    try:
        folder = Path(snapshot_download(_on_hub(model), allow_patterns=_FILES))
    except LocalEntryNotFoundError:
        raise WhisperWeightsError(model, "the hub cannot be reached, and its cache does not have them") from None
    except (RepositoryNotFoundError, HFValidationError):
        raise WhisperWeightsError(model, f"the hub does not know {_on_hub(model)}") from None
    except Exception as error:  # noqa: BLE001 - the hub's HTTP library changes between versions, and so do its errors
        raise WhisperWeightsError(model, f"fetching them failed ({type(error).__name__})") from None
    if not _complete(folder):
        raise WhisperWeightsError(model, f"{_on_hub(model)} has no model.bin: it is not converted for CTranslate2")
    return folder


def _complete(folder: Path) -> Path | None:
    return folder if (folder / "model.bin").is_file() else None


def _looks_like_a_path(model: str) -> bool:
    return model.startswith((".", "/", "~")) or model.count("/") > 1


def _on_hub(model: str) -> str:
    return model if "/" in model else f"Systran/faster-whisper-{model}"
