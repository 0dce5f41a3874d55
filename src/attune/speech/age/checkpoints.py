"""Reading and writing the Whisper age classifier, in the layout of the paper's authors.

A model is a folder: `config.json` (Whisper's, with `attune_age` for the variant) and `model.safetensors`. A folder
without `attune_age` is taken as the authors' checkpoint: mean over time, last layer, padded to 30 s.
"""

import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

import torch
from transformers import WhisperConfig

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS
from attune.speech.age.groups import groups_from_labels
from attune.speech.age.hub import fetch
from attune.speech.age.options import AgeModelOptions
from attune.speech.age.whisper_classifier import WhisperAgeClassifier

CONFIG_FILE = "config.json"
WEIGHTS_FILE = "model.safetensors"
PICKLED_FILE = "pytorch_model.bin"
OPTIONS_KEY = "attune_age"
ARCHITECTURE = "ClassificationWhisperModel"


class CheckpointError(AttuneError):
    """A folder does not hold the model that was expected."""


def load_classifier(name: str, revision: str | None = None) -> WhisperAgeClassifier:
    """Load a trained age classifier, ready to run.

    Args:
        name: Folder, or name on the hub (`attune.speech.age.hub.PAPER_MODEL`).
        revision: Branch, tag or commit on the hub.

    Raises:
        ModelNotFoundError: The folder or hub entry cannot be had.
        CheckpointError: What is there is not a Whisper age classifier with nine groups.
        LabelMappingError: Its labels name no ages.
    """
    folder = fetch(name, revision)
    data = read_config(folder)
    if data.get("model_type") != "whisper":
        raise CheckpointError(f"{folder} holds a {data.get('model_type')!r} model, not Whisper", "Give another model")
    options = _options_of(data, folder)
    model = WhisperAgeClassifier(_whisper_config(data), options)
    _fill(model, _renamed(read_weights(folder)), folder)
    _order_groups(model, data, folder)
    model.eval()
    return model


def new_classifier(encoder: str, options: AgeModelOptions, seed: int = 0) -> WhisperAgeClassifier:
    """A classifier to be trained: the encoder of a pre-trained Whisper model, and a fresh head.

    Args:
        encoder: Folder or hub name of a Whisper model (`openai/whisper-small`).
        options: The variant.
        seed: Of the head's first weights.

    Raises:
        ModelNotFoundError: The encoder cannot be had.
        CheckpointError: It is not a Whisper model, or its width cannot be split into the heads.
    """
    folder = fetch(encoder)
    data = read_config(folder)
    if data.get("model_type") != "whisper":
        raise CheckpointError(f"{folder} holds a {data.get('model_type')!r} model, not Whisper", "Give another model")
    _check_heads(data, options, folder)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        model = WhisperAgeClassifier(_whisper_config(data), options)
    weights = read_weights(folder)
    found = {
        key.split("encoder.", 1)[1]: value
        for key, value in weights.items()
        if key.startswith(("encoder.", "model.encoder."))
    }
    missing, unexpected = model.encoder.load_state_dict(found, strict=False)
    if missing or unexpected:
        raise CheckpointError(
            f"{folder} lacks the encoder's weights {missing[:3]} or has others {unexpected[:3]}",
            "Give a Whisper model of the hub, such as openai/whisper-small",
        )
    model.eval()
    return model


def save_classifier(model: WhisperAgeClassifier, folder: Path, extra: Mapping[str, str] | None = None) -> None:
    """Write a model so that a crash leaves either the old folder or the new one.

    Args:
        model: What to write.
        folder: Where; replaced if it is there.
        extra: More text files, by name.
    """
    from safetensors.torch import save_file

    data = model.config.to_dict() | {
        "architectures": [ARCHITECTURE],
        "num_labels": len(AGE_GROUPS),
        "id2label": {str(index): group for index, group in enumerate(AGE_GROUPS)},
        "label2id": {group: index for index, group in enumerate(AGE_GROUPS)},
        "classifier_proj_size": model.options.projection,
        "num_classifier_attention_heads": model.options.heads,
        "num_classification_layers": 1,
        "use_weighted_layer_sum": model.options.layers == "weighted",
        OPTIONS_KEY: model.options.to_data(),
    }
    weights = {key.removeprefix("head."): value.detach().cpu().contiguous() for key, value in _state(model).items()}
    with replaced_folder(folder) as fresh:
        save_file(weights, fresh / WEIGHTS_FILE, metadata={"format": "pt"})
        (fresh / CONFIG_FILE).write_text(json.dumps(data, indent=2, sort_keys=True) + "\n", encoding="utf-8")
        for name, text in (extra or {}).items():
            (fresh / name).write_text(text, encoding="utf-8")


@contextmanager
def replaced_folder(folder: Path) -> Iterator[Path]:
    """A fresh folder that takes the place of `folder` when the block ends well, and leaves nothing when it does not."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    fresh = folder.with_name(f".{folder.name}-{uuid4().hex[:8]}")
    fresh.mkdir()
    try:
        yield fresh
        for path in fresh.iterdir():
            with path.open("rb") as file:
                os.fsync(file.fileno())
        if folder.exists():
            old = folder.with_name(f"{fresh.name}-old")
            folder.rename(old)
            fresh.rename(folder)
            shutil.rmtree(old)
        else:
            fresh.rename(folder)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def read_config(folder: Path) -> dict[str, Any]:
    """`config.json` of a model.

    Raises:
        CheckpointError: There is none, or it is no JSON object.
    """
    path = folder / CONFIG_FILE
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise CheckpointError(f"{path} cannot be read: {error}", "Give the folder of a complete model") from None
    if not isinstance(data, dict):
        raise CheckpointError(f"{path} holds no JSON object", "Give the folder of a complete model")
    return dict(data)


def read_weights(folder: Path) -> dict[str, torch.Tensor]:
    """All weights of a model, from safetensors or from a pickle that may hold tensors only.

    Raises:
        CheckpointError: There are none, or the file is damaged.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    try:
        if (folder / WEIGHTS_FILE).exists():
            return dict(load_file(folder / WEIGHTS_FILE))
        if (folder / PICKLED_FILE).exists():
            return dict(torch.load(folder / PICKLED_FILE, map_location="cpu", weights_only=True))
    except (SafetensorError, RuntimeError, OSError, EOFError, ValueError) as error:
        raise CheckpointError(
            f"the weights in {folder} are damaged: {error}", "Fetch or copy the model again"
        ) from None
    raise CheckpointError(
        f"{folder} has neither {WEIGHTS_FILE} nor {PICKLED_FILE}", "Give the folder of a complete model in one file"
    )


def _options_of(data: dict[str, Any], folder: Path) -> AgeModelOptions:
    labels = data.get("id2label")
    count = len(labels) if isinstance(labels, dict) else data.get("num_labels", len(AGE_GROUPS))
    if count != len(AGE_GROUPS):
        raise CheckpointError(f"{folder} tells {count} classes apart, not nine age groups", "Give another model")
    if data.get("num_classification_layers", 1) != 1:
        raise CheckpointError(f"{folder} has more than one attention layer", "Give a model with one")
    if OPTIONS_KEY in data:
        options = AgeModelOptions.from_data(data[OPTIONS_KEY])
    else:
        options = AgeModelOptions(
            length="padded",
            layers="weighted" if data.get("use_weighted_layer_sum") else "last",
            heads=data.get("num_classifier_attention_heads", 4),
            projection=data.get("classifier_proj_size", 256),
        )
    _check_heads(data, options, folder)
    return options


def _check_heads(data: dict[str, Any], options: AgeModelOptions, folder: Path) -> None:
    width = int(data.get("d_model", 0))
    if width % options.heads:
        raise CheckpointError(
            f"the width {width} of {folder} cannot be split into {options.heads} heads", "Choose another number"
        )


def _whisper_config(data: dict[str, Any]) -> WhisperConfig:
    ours = (OPTIONS_KEY, "num_classifier_attention_heads", "num_classification_layers", "architectures", "num_labels")
    return WhisperConfig(**{key: value for key, value in data.items() if key not in (*ours, "id2label", "label2id")})


def _renamed(weights: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """To the names of our modules; wrappers and other names of the attention layer are taken as well."""
    renamed = {}
    for key, value in weights.items():
        name = re.sub(r"^(?:module\.|model\.|classification_model\.)+", "", key)
        name = re.sub(r"^projector\.(?:\w+\.)?([kqv]|out)_proj\.", r"projector.attention.\1_proj.", name)
        renamed[name if name.startswith("encoder.") else f"head.{name}"] = value
    return renamed


def _fill(model: WhisperAgeClassifier, weights: dict[str, torch.Tensor], folder: Path) -> None:
    expected = _state(model)
    missing = sorted(set(expected) - set(weights))
    unexpected = sorted(set(weights) - set(expected))
    shapes = [key for key in expected if key in weights and expected[key].shape != weights[key].shape]
    if missing or unexpected or shapes:
        raise CheckpointError(
            f"{folder} is not laid out as an age classifier (missing: {missing[:3] or 'nothing'}; "
            f"unknown: {unexpected[:3] or 'nothing'}; of another shape: {shapes[:3] or 'nothing'})",
            "Give a checkpoint of this kind, or use `load_age_model` for general audio classifiers",
        )
    model.load_state_dict(weights)


def _order_groups(model: WhisperAgeClassifier, data: dict[str, Any], folder: Path) -> None:
    """Turn the outputs into the order of `AGE_GROUPS`, where the labels say that theirs is another."""
    if not isinstance(data.get("id2label"), dict):
        return
    labels = [str(label) for _, label in sorted(data["id2label"].items(), key=lambda item: int(item[0]))]
    groups = groups_from_labels(labels).argmax(axis=1).tolist()
    if sorted(groups) != list(range(len(AGE_GROUPS))):
        raise CheckpointError(f"{folder} does not have one label for each age group: {labels}", "Give another model")
    rows = [groups.index(group) for group in range(len(AGE_GROUPS))]
    classifier = model.head.classifier
    with torch.no_grad():
        for values in (classifier.weight, classifier.bias):
            values.copy_(values[rows].clone())


def _state(model: WhisperAgeClassifier) -> dict[str, torch.Tensor]:
    state: dict[str, torch.Tensor] = model.state_dict()
    return state
