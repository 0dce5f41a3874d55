"""Text becomes sound with word times, in the voice, rate and loudness that were asked for."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from attune.core.espeak import UnknownVoiceError
from attune.voice.synthesis import Synthesiser

TEXT = "I bring you the red cup."


def test_word_marks_name_the_words_in_order_and_rise_in_time() -> None:
    speech = Synthesiser().synthesise(TEXT)
    assert [speech.text[w.start : w.end] for w in speech.words] == ["I", "bring", "you", "the", "red", "cup"]
    times = [w.time for w in speech.words]
    assert times == sorted(times)
    assert times[-1] < speech.duration


def test_a_faster_rate_is_shorter_and_loudness_scales_the_samples() -> None:
    voice = Synthesiser()
    slow, fast = voice.synthesise(TEXT, rate_wpm=120), voice.synthesise(TEXT, rate_wpm=240)
    assert fast.duration < 0.7 * slow.duration
    quiet, loud = voice.synthesise(TEXT, loudness=0.25), voice.synthesise(TEXT, loudness=1.0)
    assert np.allclose(quiet.samples * 4, loud.samples, atol=1e-4)


def test_voices_differ_and_an_unknown_one_is_named_with_some_that_exist() -> None:
    voice = Synthesiser()
    assert len(voice.synthesise(TEXT, voice="en-us+f3").samples) != len(voice.synthesise(TEXT).samples)
    for unknown in ("martian", "en-gb+nobody"):
        with pytest.raises(UnknownVoiceError, match=r"Some that exist: \S+"):
            voice.synthesise(TEXT, voice=unknown)


def test_threads_that_speak_at_once_get_their_own_text() -> None:
    voice = Synthesiser()
    texts = [f"{word} cup" for word in ("red", "green", "blue", "white")] * 8
    alone = {text: voice.synthesise(text).samples for text in texts}
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda text: voice.synthesise(text).samples, texts))
    assert all(np.array_equal(samples, alone[text]) for text, samples in zip(texts, together, strict=True))


@pytest.mark.parametrize("text", ["", "...", "\0", "¡€ 漢字!"])
def test_any_text_can_be_spoken(text: str) -> None:
    assert np.isfinite(Synthesiser().synthesise(text).samples).all()
