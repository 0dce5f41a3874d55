"""Where models come from: a folder, or the Hugging Face hub by name, kept in its cache."""

import importlib.util
from pathlib import Path

from attune.core.errors import AttuneError, MissingDependencyError

PAPER_MODEL = "TPekarekRosin/uhh_ub_cv_ar_big_ds"
"""The checkpoint that the paper's authors published."""
WHISPER_SMALL = "openai/whisper-small"
"""The encoder that the paper builds on."""

_WEIGHTS = ["model.safetensors", "model.onnx"]
_SETTINGS = ["config.json", "preprocessor_config.json", "attune_age.json", "training_report.json"]
_PICKLE = "pytorch_model.bin"
"""Fetched only where there is nothing better: many repositories hold the same weights several times."""


class ModelNotFoundError(AttuneError):
    """The model is neither a folder nor can it be fetched."""

    retryable = True

    def __init__(self, name: str, reason: str, remedy: str = "") -> None:
        super().__init__(
            f"the model {name!r} cannot be had: {reason}",
            remedy or "Connect to the network once, or copy the model's folder here and give its path",
        )


def require(*modules: str, extra: str = "age", needed_for: str = "the age model") -> None:
    """Make sure that libraries of an extra are installed, without importing them.

    Raises:
        MissingDependencyError: One is not; the message says how to get it.
    """
    for module in modules:
        if importlib.util.find_spec(module) is None:
            raise MissingDependencyError(module, needed_for, f"Run `pip install 'attune-hri[{extra}]'`")


def fetch(name: str, revision: str | None = None) -> Path:
    """The folder of a model.

    Args:
        name: Path of a folder, or name on the Hugging Face hub such as `openai/whisper-small`. What was fetched once
            is found in the hub's cache, also offline.
        revision: Branch, tag or commit on the hub.

    Raises:
        ModelNotFoundError: There is no such folder, and the hub does not know it or cannot be reached.
        MissingDependencyError: `huggingface_hub` is needed and not installed.
    """
    if Path(name).expanduser().is_dir():
        return Path(name).expanduser()
    if name.count("/") != 1 or name.startswith((".", "/", "~")):
        raise ModelNotFoundError(name, "there is no such folder", "Give the path of a model's folder, or a hub name")
    require("huggingface_hub")
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import (
        GatedRepoError,
        HFValidationError,
        LocalEntryNotFoundError,
        RepositoryNotFoundError,
    )

    try:
        folder = Path(snapshot_download(name, revision=revision, allow_patterns=_SETTINGS + _WEIGHTS))
        if not any((folder / weights).exists() for weights in _WEIGHTS):
            folder = Path(snapshot_download(name, revision=revision, allow_patterns=[*_SETTINGS, _PICKLE]))
        return folder
    except LocalEntryNotFoundError:
        raise ModelNotFoundError(name, "the hub cannot be reached and the cache does not have it") from None
    except GatedRepoError:
        raise ModelNotFoundError(
            name, "its owner asks for a login", "Accept its terms on the hub, then log in with `hf auth login`"
        ) from None
    except (RepositoryNotFoundError, HFValidationError):
        raise ModelNotFoundError(name, "the hub does not know it", "Check the spelling: owner/name") from None
    except Exception as error:  # noqa: BLE001 - its HTTP library changes between versions, and so do the errors
        raise ModelNotFoundError(name, f"fetching it failed ({type(error).__name__})") from None
