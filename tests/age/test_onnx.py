"""The fast form says what the model says, for any length, and needs no torch."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from attune.core.messages import AGE_GROUPS
from attune.speech.age.checkpoints import new_classifier
from attune.speech.age.features import log_mel
from attune.speech.age.models import WhisperAgeModel, load_age_model
from attune.speech.age.onnx_estimator import OnnxAgeModel, OnnxModelError
from attune.speech.age.options import AgeModelOptions
from attune.training.export import export_onnx

from .conftest import Trained


@pytest.mark.parametrize("seconds", [0.05, 0.7, 1.5, 8.0, 40.0])
def test_int8_agrees_with_torch_for_every_length(trained: Trained, speech: np.ndarray, seconds: float) -> None:
    sound = np.resize(speech, int(16_000 * seconds))
    slow, fast = (load_age_model(str(folder)).probabilities(sound) for folder in (trained.model, trained.onnx))
    assert fast.sum() == pytest.approx(1)
    np.testing.assert_allclose(fast, slow, atol=0.06)


def test_without_quantisation_it_is_the_same_with_every_option(
    whisper_folder: Path, tmp_path: Path, speech: np.ndarray
) -> None:
    options = AgeModelOptions(pooling="attention", layers="weighted", frame_stride=3, temperature=1.4, length="padded")
    model = new_classifier(str(whisper_folder), options)
    export_onnx(model, tmp_path / "onnx", int8=False)
    fast, slow = OnnxAgeModel(tmp_path / "onnx"), WhisperAgeModel(model)
    np.testing.assert_allclose(fast.probabilities(speech), slow.probabilities(speech), atol=1e-5)
    for count in (5000, 12_345, len(speech)):
        features = log_mel(speech[:count])
        expected = slow.probabilities_of_features(features)
        np.testing.assert_allclose(fast.probabilities_of_features(features), expected, atol=1e-5)
        assert not np.allclose(fast.probabilities(speech[:count]), expected, atol=1e-3), "it hears 30 s"


def test_features_of_a_recogniser_can_be_handed_over(trained: Trained, speech: np.ndarray) -> None:
    model = load_age_model(str(trained.onnx))
    np.testing.assert_array_equal(
        model.probabilities_of_features(log_mel(speech)),  # type: ignore[attr-defined]
        model.probabilities(speech),
    )


def test_it_runs_where_torch_is_not_installed(trained: Trained) -> None:
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
found = load_estimator({str(trained.onnx)!r}).estimate(np.sin(np.arange(16000) / 9).astype(np.float32), Recognition())
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
def test_a_damaged_export_is_named(trained: Trained, tmp_path: Path, damage: str) -> None:
    for path in trained.onnx.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / damage).write_bytes(b"broken")
    with pytest.raises(OnnxModelError, match=damage):
        load_age_model(str(tmp_path))


def test_a_recogniser_s_features_serve_instead_of_the_model_s_own(trained: Trained, speech: np.ndarray) -> None:
    features = log_mel(speech)
    for folder in (trained.model, trained.onnx):
        model = load_age_model(str(folder))
        # With other sound beside them it is seen that they are what is used.
        found = model.probabilities(np.zeros_like(speech), features)
        np.testing.assert_array_equal(found, model.probabilities(speech))
        assert not np.array_equal(found, model.probabilities(np.zeros_like(speech)))


def test_features_that_do_not_fit_are_left_aside(paper_folder: Path, speech: np.ndarray) -> None:
    heard_at_30_s = load_age_model(str(paper_folder))
    np.testing.assert_array_equal(
        heard_at_30_s.probabilities(speech, log_mel(speech)), heard_at_30_s.probabilities(speech)
    )
