"""Checkpoints of the paper's authors and of the hub load by their own names, and survive a round trip."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from transformers import (
    Wav2Vec2Config,
    Wav2Vec2FeatureExtractor,
    Wav2Vec2ForSequenceClassification,
    Wav2Vec2Model,
    WhisperFeatureExtractor,
    WhisperForAudioClassification,
)
from transformers.models.whisper.modeling_whisper import WhisperEncoder

from attune.core.messages import AGE_GROUPS
from attune.speech.age.checkpoints import CheckpointError, load_classifier, new_classifier, save_classifier
from attune.speech.age.features import log_mel
from attune.speech.age.groups import LabelMappingError, groups_from_years
from attune.speech.age.hub import ModelNotFoundError, fetch
from attune.speech.age.models import load_age_model
from attune.speech.age.options import AgeModelOptions, OptionError

from .conftest import tiny_config

OPTIONS = (
    AgeModelOptions(),
    AgeModelOptions(length="padded"),
    AgeModelOptions(pooling="attention", layers="weighted", targets="ordinal", frame_stride=4, temperature=1.7),
)


def written_out(folder: Path, speech: np.ndarray) -> np.ndarray:
    """The authors' model step by step, from the weights of the file alone."""
    from safetensors.torch import load_file

    weights = load_file(folder / "model.safetensors")
    config = tiny_config()
    encoder = WhisperEncoder(config).eval()
    encoder.load_state_dict({key[8:]: value for key, value in weights.items() if key.startswith("encoder.")})

    def norm(name: str, x: torch.Tensor) -> torch.Tensor:
        return torch.layer_norm(x, (32,), weights[f"projector.{name}.weight"], weights[f"projector.{name}.bias"])

    with torch.no_grad():
        mel = WhisperFeatureExtractor()(speech, sampling_rate=16_000, return_tensors="pt").input_features
        frames = encoder(mel).last_hidden_state[0]
        normed = norm("self_attn_layer_norm", frames)
        query, key, value = (
            (normed @ weights[f"projector.attention.{name}_proj.weight"].T).view(-1, 4, 8).transpose(0, 1)
            for name in "qkv"
        )
        mixed = torch.softmax(query @ key.transpose(1, 2) / 8**0.5, dim=-1) @ value
        mixed = mixed.transpose(0, 1).reshape(-1, 32) @ weights["projector.attention.out_proj.weight"].T
        hidden = norm("final_layer_norm", frames + mixed)
        hidden = torch.relu(hidden @ weights["projector.linear.weight"].T + weights["projector.linear.bias"])
        logits = hidden.mean(dim=0) @ weights["classifier.weight"].T + weights["classifier.bias"]
        return torch.softmax(logits, dim=-1).numpy()


def test_the_authors_checkpoint_computes_what_the_paper_describes(paper_folder: Path, speech: np.ndarray) -> None:
    ours = load_age_model(str(paper_folder)).probabilities(speech)
    np.testing.assert_allclose(ours, written_out(paper_folder, speech), atol=1e-4)
    assert ours.max() > 0.2


def test_the_authors_checkpoint_survives_a_round_trip(paper_folder: Path, tmp_path: Path, speech: np.ndarray) -> None:
    first = load_age_model(str(paper_folder))
    save_classifier(load_classifier(str(paper_folder)), tmp_path / "copy")
    second = load_age_model(str(tmp_path / "copy"))
    np.testing.assert_array_equal(first.probabilities(speech), second.probabilities(speech))


def test_a_pickled_checkpoint_of_a_wrapped_model_loads_too(paper_folder: Path, tmp_path: Path) -> None:
    from safetensors.torch import load_file

    weights = {f"module.{key}": value for key, value in load_file(paper_folder / "model.safetensors").items()}
    torch.save(weights, tmp_path / "pytorch_model.bin")
    shutil.copy(paper_folder / "config.json", tmp_path)
    loaded, expected = load_classifier(str(tmp_path)), load_classifier(str(paper_folder))
    assert all(torch.equal(value, expected.state_dict()[key]) for key, value in loaded.state_dict().items())


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: f"{options.pooling}-{options.layers}-{options.length}")
def test_every_variant_survives_a_round_trip(
    whisper_folder: Path, tmp_path: Path, speech: np.ndarray, options: AgeModelOptions
) -> None:
    model = new_classifier(str(whisper_folder), options)
    save_classifier(model, tmp_path / "model")
    loaded = load_classifier(str(tmp_path / "model"))
    assert loaded.options == options
    features = torch.from_numpy(log_mel(speech, padded=options.length == "padded"))[None]
    with torch.no_grad():
        assert torch.equal(model.probabilities(features), loaded.probabilities(features))


def test_a_fresh_classifier_has_the_encoder_of_the_pretrained_model(whisper_folder: Path) -> None:
    from transformers import WhisperModel

    model = new_classifier(str(whisper_folder), AgeModelOptions())
    pretrained = WhisperModel.from_pretrained(whisper_folder)
    for key, value in pretrained.encoder.state_dict().items():
        assert torch.equal(value, model.encoder.state_dict()[key])


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: f"{options.pooling}-{options.layers}-{options.length}")
def test_an_utterance_in_a_batch_gives_what_it_gives_alone(
    whisper_folder: Path, speech: np.ndarray, options: AgeModelOptions
) -> None:
    model = new_classifier(str(whisper_folder), options)
    padded = options.length == "padded"
    each = [log_mel(sound, padded=padded) for sound in (speech, speech[:9000], speech[3000:20_000])]
    longest = max(features.shape[1] for features in each)
    batch = torch.stack(
        [torch.from_numpy(np.pad(features, ((0, 0), (0, longest - features.shape[1])))) for features in each]
    )
    lengths = None if padded else torch.tensor([features.shape[1] for features in each])
    with torch.no_grad():
        together = model(batch, lengths)
        for row, features in zip(together, each, strict=True):
            torch.testing.assert_close(row, model(torch.from_numpy(features)[None])[0], atol=1e-4, rtol=1e-4)


def test_our_encoder_on_thirty_seconds_is_the_one_of_transformers(whisper_folder: Path, speech: np.ndarray) -> None:
    model = new_classifier(str(whisper_folder), AgeModelOptions(layers="weighted"))
    features = torch.from_numpy(log_mel(speech, padded=True))[None]
    with torch.no_grad():
        frames, _ = model.encode(features)
        expected = model.encoder(features, output_hidden_states=True)
    torch.testing.assert_close(frames[:, -1], expected.last_hidden_state)
    torch.testing.assert_close(frames[:, :-1], torch.stack(expected.hidden_states[:-1], dim=1))


def test_a_failed_write_leaves_the_old_model(whisper_folder: Path, tmp_path: Path) -> None:
    model = new_classifier(str(whisper_folder), AgeModelOptions())
    save_classifier(model, tmp_path / "model")
    before = (tmp_path / "model" / "model.safetensors").read_bytes()
    with pytest.raises(OSError, match="missing"):
        save_classifier(model, tmp_path / "model", {"missing/folder.md": "text"})
    assert [path.name for path in tmp_path.iterdir()] == ["model"]
    assert (tmp_path / "model" / "model.safetensors").read_bytes() == before


def test_a_checkpoint_with_missing_weights_is_named(paper_folder: Path, tmp_path: Path) -> None:
    from safetensors.torch import load_file, save_file

    weights = load_file(paper_folder / "model.safetensors")
    del weights["projector.linear.weight"]
    save_file(weights, tmp_path / "model.safetensors")
    shutil.copy(paper_folder / "config.json", tmp_path)
    with pytest.raises(CheckpointError, match=r"projector\.linear\.weight"):
        load_age_model(str(tmp_path))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"id2label": {"0": "young", "1": "old"}}, "2 classes"),
        ({"num_classifier_attention_heads": 5}, "5 heads"),
        ({"num_classification_layers": 2}, "more than one"),
        ({"id2label": {str(index): "sixties" for index in range(9)}}, "one label for each"),
        ({"attune_age": {"pooling": "max"}}, "pooling"),
        ({"attune_age": {"colour": "red"}}, "colour"),
    ],
)
def test_a_checkpoint_of_another_kind_is_refused(
    paper_folder: Path, tmp_path: Path, change: dict[str, object], message: str
) -> None:
    shutil.copytree(paper_folder, tmp_path, dirs_exist_ok=True)
    data = json.loads((tmp_path / "config.json").read_text())
    (tmp_path / "config.json").write_text(json.dumps(data | change))
    with pytest.raises((CheckpointError, OptionError), match=message):
        load_age_model(str(tmp_path))


def test_labels_in_another_order_are_put_in_ours(paper_folder: Path, tmp_path: Path, speech: np.ndarray) -> None:
    shutil.copytree(paper_folder, tmp_path, dirs_exist_ok=True)
    data = json.loads((tmp_path / "config.json").read_text())
    data["id2label"] = {str(index): group for index, group in enumerate(sorted(AGE_GROUPS))}
    (tmp_path / "config.json").write_text(json.dumps(data))
    by_number = load_age_model(str(paper_folder)).probabilities(speech)
    named = load_age_model(str(tmp_path)).probabilities(speech)
    assert dict(zip(AGE_GROUPS, named, strict=True)) == pytest.approx(
        dict(zip(sorted(AGE_GROUPS), by_number, strict=True)), rel=1e-4
    )


@pytest.mark.parametrize("damage", ["model.safetensors", "config.json"])
def test_a_damaged_file_is_named(paper_folder: Path, tmp_path: Path, damage: str) -> None:
    shutil.copytree(paper_folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / damage).write_bytes(b"{broken")
    with pytest.raises(CheckpointError, match="damaged|cannot be read"):
        load_age_model(str(tmp_path))


def test_without_a_network_a_name_of_the_hub_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    with pytest.raises(ModelNotFoundError, match="give its path"):
        fetch("TPekarekRosin/uhh_ub_cv_ar_big_ds")
    with pytest.raises(ModelNotFoundError, match="no such folder"):
        fetch("./nowhere")


def test_a_model_in_the_hub_s_cache_is_found_by_name(
    paper_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, speech: np.ndarray
) -> None:
    from huggingface_hub import constants

    repository = tmp_path / "models--TPekarekRosin--uhh_ub_cv_ar_big_ds"
    shutil.copytree(paper_folder, repository / "snapshots" / "abc")
    (repository / "refs").mkdir()
    (repository / "refs" / "main").write_text("abc")
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    found = load_age_model("TPekarekRosin/uhh_ub_cv_ar_big_ds").probabilities(speech)
    np.testing.assert_array_equal(found, load_age_model(str(paper_folder)).probabilities(speech))


def wav2vec2_config(**changes: object) -> Wav2Vec2Config:
    sizes = dict(
        hidden_size=32,
        num_hidden_layers=2,
        num_attention_heads=2,
        intermediate_size=64,
        conv_dim=(16, 16),
        conv_stride=(10, 8),
        conv_kernel=(10, 8),
        num_feat_extract_layers=2,
        num_conv_pos_embeddings=16,
        num_conv_pos_embedding_groups=4,
        classifier_proj_size=16,
    )
    return Wav2Vec2Config(**(sizes | changes))


def normalised(speech: np.ndarray) -> torch.Tensor:
    return torch.from_numpy((speech - speech.mean()) / np.sqrt(speech.var() + 1e-7))[None]


def test_whisper_with_age_labels_is_mapped_to_the_groups(tmp_path: Path, speech: np.ndarray) -> None:
    labels = ["10-19", "20s", "thirties", "40-59", "60+"]
    config = tiny_config(
        id2label=dict(enumerate(labels)), label2id={label: index for index, label in enumerate(labels)}
    )
    torch.manual_seed(5)
    model = WhisperForAudioClassification(config).eval()
    model.save_pretrained(tmp_path)
    with torch.no_grad():
        mel = WhisperFeatureExtractor()(speech, sampling_rate=16_000, return_tensors="pt").input_features
        own = torch.softmax(model(mel).logits[0], dim=-1).numpy()
    ours = load_age_model(str(tmp_path)).probabilities(speech)
    np.testing.assert_allclose(ours[:3], own[:3], atol=1e-5)
    np.testing.assert_allclose([ours[3:5].sum(), ours[5:].sum()], own[3:], atol=1e-5)


def test_wav2vec2_with_labels_of_sex_and_age_is_mapped_to_the_groups(tmp_path: Path, speech: np.ndarray) -> None:
    labels = ["female_teens", "male_teens", "female_sixties", "male_sixties"]
    config = wav2vec2_config(id2label=dict(enumerate(labels)), label2id={name: i for i, name in enumerate(labels)})
    torch.manual_seed(6)
    model = Wav2Vec2ForSequenceClassification(config).eval()
    model.save_pretrained(tmp_path)
    Wav2Vec2FeatureExtractor(do_normalize=True).save_pretrained(tmp_path)
    with torch.no_grad():
        own = torch.softmax(model(normalised(speech)).logits[0], dim=-1).numpy()
    ours = load_age_model(str(tmp_path)).probabilities(speech)
    np.testing.assert_allclose([ours[0], ours[5]], [own[:2].sum(), own[2:].sum()], atol=1e-4)


def test_a_single_output_is_an_age_in_years(tmp_path: Path, speech: np.ndarray) -> None:
    model = Wav2Vec2ForSequenceClassification(wav2vec2_config(num_labels=1)).eval()
    with torch.no_grad():
        model.classifier.weight.zero_()
        model.classifier.bias.fill_(72.0)
    model.save_pretrained(tmp_path)
    np.testing.assert_allclose(load_age_model(str(tmp_path)).probabilities(speech), groups_from_years(72.0), atol=1e-6)
    in_months = load_age_model(str(tmp_path), years_per_unit=1 / 12).probabilities(speech)
    assert in_months.argmax() == AGE_GROUPS.index("teens")


def test_age_and_gender_heads_give_the_age_in_centuries(tmp_path: Path, speech: np.ndarray) -> None:
    torch.manual_seed(7)
    config = wav2vec2_config()
    encoder = Wav2Vec2Model(config).eval()
    weights = {f"wav2vec2.{key}": value.clone() for key, value in encoder.state_dict().items()}
    for head, outputs in (("age", 1), ("gender", 3)):
        weights[f"{head}.dense.weight"], weights[f"{head}.dense.bias"] = torch.randn(32, 32), torch.randn(32)
        weights[f"{head}.out_proj.weight"], weights[f"{head}.out_proj.bias"] = torch.randn(outputs, 32), torch.ones(1)
    weights["age.out_proj.weight"] *= 0.02
    weights["age.out_proj.bias"] = torch.tensor([0.55])
    weights["gender.out_proj.bias"] = torch.zeros(3)
    with torch.no_grad():
        pooled = encoder(normalised(speech)).last_hidden_state.mean(dim=1)
        dense = torch.tanh(pooled @ weights["age.dense.weight"].T + weights["age.dense.bias"])
        age = float((dense @ weights["age.out_proj.weight"].T + weights["age.out_proj.bias"])[0, 0])
    # Published checkpoints carry the weight norm under its former names.
    old = {
        key.replace("parametrizations.weight.original0", "weight_g").replace(
            "parametrizations.weight.original1", "weight_v"
        ): value
        for key, value in weights.items()
    }
    torch.save(old, tmp_path / "pytorch_model.bin")
    (tmp_path / "config.json").write_text(json.dumps(config.to_dict() | {"architectures": ["AgeGenderModel"]}))
    ours = load_age_model(str(tmp_path)).probabilities(speech)
    np.testing.assert_allclose(ours, groups_from_years(100 * age), atol=1e-4)


def test_a_classifier_of_something_else_is_refused(tmp_path: Path) -> None:
    config = wav2vec2_config(id2label={0: "angry", 1: "happy"}, label2id={"angry": 0, "happy": 1})
    Wav2Vec2ForSequenceClassification(config).save_pretrained(tmp_path)
    with pytest.raises(LabelMappingError, match="angry"):
        load_age_model(str(tmp_path))
