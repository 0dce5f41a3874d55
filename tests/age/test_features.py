"""The features are those of Whisper."""

import numpy as np
import pytest
from transformers import WhisperFeatureExtractor

from attune.speech.age.features import log_mel


@pytest.mark.parametrize("bands", [80, 128])
def test_padded_features_equal_those_of_transformers(speech: np.ndarray, bands: int) -> None:
    expected = WhisperFeatureExtractor(feature_size=bands)(speech, sampling_rate=16_000, return_tensors="np")
    ours = log_mel(speech, bands=bands, padded=True)
    assert ours.shape == (bands, 3000)
    np.testing.assert_allclose(ours, expected.input_features[0], atol=2e-4)


def test_features_of_the_true_length_are_the_beginning_of_the_padded_ones(speech: np.ndarray) -> None:
    ours = log_mel(speech)
    assert ours.shape[1] == 2 * -(-len(speech) // 320)
    np.testing.assert_allclose(ours[:, :-2], log_mel(speech, padded=True)[:, : ours.shape[1] - 2], atol=1e-5)


@pytest.mark.parametrize("count", [0, 1, 400, 16_000 * 40])
def test_any_length_gives_an_even_number_of_finite_frames(count: int) -> None:
    features = log_mel(np.zeros(count, np.float32))
    assert features.shape[1] % 2 == 0
    assert 10 <= features.shape[1] <= 3000
    assert np.isfinite(features).all()
