"""The fast form says what the model says, for any length, and needs no torch."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from attune.core.messages import AGE_GROUPS
from attune.speech.age.checkpoints import load_classifier, new_classifier
from attune.speech.age.features import log_mel
from attune.speech.age.models import WhisperAgeModel, load_age_model
from attune.speech.age.onnx_estimator import OnnxModelError
from attune.speech.age.options import AgeModelOptions
from attune.training.export import export_onnx
from attune.training.pipeline import Outcome


@pytest.fixture(scope="module")
def exported(trained: Outcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fast") / "onnx"
    export_onnx(load_classifier(str(trained.model)), folder)
    return folder


@pytest.mark.parametrize("seconds", [0.05, 0.7, 1.5, 8.0, 40.0])
def test_int8_agrees_with_torch_for_every_length(
    exported: Path, trained: Outcome, speech: np.ndarray, seconds: float
) -> None:
    sound = np.resize(speech, int(16_000 * seconds))
    slow, fast = (load_age_model(str(folder)).probabilities(sound) for folder in (trained.model, exported))
    assert fast.sum() == pytest.approx(1)
    np.testing.assert_allclose(fast, slow, atol=0.06)


def test_without_quantisation_it_is_the_same_with_every_option(
    whisper_folder: Path, tmp_path: Path, speech: np.ndarray
) -> None:
    options = AgeModelOptions(pooling="attention", layers="weighted", frame_stride=3, temperature=1.4)
    model = new_classifier(str(whisper_folder), options)
    export_onnx(model, tmp_path / "onnx", int8=False)
    fast = load_age_model(str(tmp_path / "onnx"))
    for count in (5000, 12_345, len(speech)):
        expected = WhisperAgeModel(model).probabilities(speech[:count])
        np.testing.assert_allclose(fast.probabilities(speech[:count]), expected, atol=1e-5)


def test_the_authors_checkpoint_is_exported_with_its_padding(
    paper_folder: Path, tmp_path: Path, speech: np.ndarray
) -> None:
    export_onnx(load_classifier(str(paper_folder)), tmp_path / "onnx", int8=False)
    assert json.loads((tmp_path / "onnx" / "attune_age.json").read_text())["padded"] is True
    expected = load_age_model(str(paper_folder)).probabilities(speech)
    np.testing.assert_allclose(load_age_model(str(tmp_path / "onnx")).probabilities(speech), expected, atol=1e-4)


def test_features_of_a_recogniser_can_be_handed_over(exported: Path, speech: np.ndarray) -> None:
    model = load_age_model(str(exported))
    np.testing.assert_array_equal(
        model.probabilities_of_features(log_mel(speech)),  # type: ignore[attr-defined]
        model.probabilities(speech),
    )


def test_it_runs_where_torch_is_not_installed(exported: Path) -> None:
    script = f"""
import sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("torch", "transformers", "onnx", "huggingface_hub", "safetensors"):
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Blocker())
import numpy as np
from attune.speech.age.model_estimator import load_estimator
from attune.speech.recogniser import Recognition
found = load_estimator({str(exported)!r}).estimate(np.sin(np.arange(16000) / 9).astype(np.float32), Recognition())
assert found.source == "model" and len(found.probabilities) == {len(AGE_GROUPS)}, found
import attune.cli.train_age, attune.cli.eval_age, attune.evaluation.age
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


def test_without_torch_a_model_that_needs_it_says_how_to_get_it(paper_folder: Path) -> None:
    script = f"""
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name == "torch" else find(name, package)
from attune.core.errors import MissingDependencyError
from attune.speech.age.models import load_age_model
try:
    load_age_model({str(paper_folder)!r})
except MissingDependencyError as error:
    assert "pip install 'attune-hri[age]'" in str(error), error
else:
    raise SystemExit("no error")
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


@pytest.mark.parametrize("damage", ["model.onnx", "attune_age.json"])
def test_a_damaged_export_is_named(exported: Path, tmp_path: Path, damage: str) -> None:
    for path in exported.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / damage).write_bytes(b"broken")
    with pytest.raises(OnnxModelError, match=damage):
        load_age_model(str(tmp_path))


def test_a_recogniser_s_features_serve_instead_of_the_model_s_own(trained: Outcome, exported: Path, speech) -> None:  # type: ignore[no-untyped-def]
    features = log_mel(speech)
    for folder in (trained.model, exported):
        model = load_age_model(str(folder))
        # With other sound beside them it is seen that they are what is used.
        found = model.probabilities(np.zeros_like(speech), features)
        np.testing.assert_array_equal(found, model.probabilities(speech))
        assert not np.array_equal(found, model.probabilities(np.zeros_like(speech)))


def test_features_that_do_not_fit_are_left_aside(paper_folder: Path, speech) -> None:  # type: ignore[no-untyped-def]
    heard_at_30_s = load_age_model(str(paper_folder))
    np.testing.assert_array_equal(
        heard_at_30_s.probabilities(speech, log_mel(speech)), heard_at_30_s.probabilities(speech)
    )
