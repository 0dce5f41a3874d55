"""Whisper's weights at work: sound to token sequences, and how likely the sound makes a text.

Whisper was made for windows of 30 s, which take a weak processor half a second to encode, however short the utterance
is. Here only the utterance is encoded. A decoder that then sees no silence up to the end of the window repeats itself
("bring me a cup bring me a cup ..."), so some of what the encoder makes of silence, computed once, is put behind it.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from attune.speech.age.features import log_mel
from attune.speech.audio import SAMPLE_RATE, Samples

WINDOW = 30.0
"""Whisper sees so much sound at once [s]."""
_FRAMES_PER_SECOND = 100
"""Of the features; the encoder makes one of two."""
_PADDING = 1.0
"""Silence that is encoded with the utterance [s]."""
_SILENCE = 5.0
"""Silence from the store that is put behind it [s]. Chosen on voices of development: without it half of the transcripts
repeat themselves, with 4 s of it hardly any, and 28 s change nothing but the time it takes."""
_SHORT = 12.0
"""Longer utterances get the whole window [s]."""
_TOKENS_PER_SECOND, _MORE_TOKENS = 7, 12
"""Nobody says more; it bounds the time that a repetition takes."""

_FIRST_PERSON = re.compile(r"\bi\b")
_LEAST = 1e-9
"""Of a token's probability."""

Features = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A reading of the sound.

    Attributes:
        tokens: Of the text.
        log_probability: Sum over the tokens and the end (natural logarithm).
    """

    tokens: tuple[int, ...]
    log_probability: float

    @property
    def mean_log_probability(self) -> float:
        """Of a token."""
        return min(0.0, self.log_probability / (len(self.tokens) + 1))


@dataclass(frozen=True, slots=True)
class Encoded:
    """Sound as the decoder takes it.

    Attributes:
        states: Of the encoder.
        features: Log-mel features of the sound.
    """

    states: Any
    features: Features

    @property
    def seconds(self) -> float:
        """Length of the sound."""
        return int(self.features.shape[-1]) / _FRAMES_PER_SECOND


class WhisperModel:
    """English transcription with weights converted for CTranslate2: int8 on the processor, float16 on a graphics card.

    Args:
        weights: Their folder.
        threads: Of the processor; 0 leaves it to the library.
    """

    def __init__(self, weights: Path, threads: int = 0) -> None:
        import ctranslate2
        import faster_whisper
        from faster_whisper.tokenizer import Tokenizer

        self.device = "cuda" if ctranslate2.get_cuda_device_count() else "cpu"
        self._model = faster_whisper.WhisperModel(
            str(weights),
            device=self.device,
            compute_type="float16" if self.device == "cuda" else "int8",
            cpu_threads=threads,
        )
        self._tokenizer = Tokenizer(
            self._model.hf_tokenizer, self._model.model.is_multilingual, task="transcribe", language="en"
        )
        # A graphics card has the whole window in no time.
        self._silence = self._encoded_silence() if self.device == "cpu" else None

    def features(self, sound: Samples) -> Features:
        """Log-mel features, as `attune.speech.age.features.log_mel` computes them for an age model."""
        return log_mel(sound, bands=self._model.model.n_mels)

    def encode(self, features: Features, *, whole_window: bool = False) -> Encoded:
        """Encode up to 30 s; the whole window takes longer and gains nothing, unless the decoder repeats itself."""
        seconds = features.shape[-1] / _FRAMES_PER_SECOND
        if whole_window or self._silence is None or seconds > _SHORT:
            return Encoded(self._model.encode(_padded(features, WINDOW)), features)
        from ctranslate2 import StorageView

        states = np.asarray(self._model.encode(_padded(features, seconds + _PADDING)))
        length = states.shape[1]
        silence = self._silence[:, length : length + round(_SILENCE * _FRAMES_PER_SECOND / 2)]
        return Encoded(StorageView.from_array(np.concatenate([states, silence], axis=1)), features)

    def decode(
        self, encoded: Encoded, *, beam: int = 1, hot_words: Sequence[str] = ()
    ) -> tuple[list[Hypothesis], float]:
        """Readings, best first, and the probability that nobody spoke.

        Args:
            encoded: The sound.
            beam: How many hypotheses are followed and returned.
            hot_words: Words to be preferred; for the whole window only.
        """
        prompt = self._model.get_prompt(
            self._tokenizer, [], without_timestamps=True, hotwords=" ".join(hot_words) or None
        )
        most = _MORE_TOKENS + round(_TOKENS_PER_SECOND * encoded.seconds)
        [result] = self._model.model.generate(
            encoded.states,
            [prompt],
            beam_size=beam,
            num_hypotheses=beam,
            max_length=len(prompt) + most,
            return_scores=True,
            return_no_speech_prob=True,
        )
        # The score is divided by the length without the end token.
        found = [
            Hypothesis(tuple(tokens), score * max(1, len(tokens)))
            for tokens, score in zip(result.sequences_ids, result.scores, strict=True)
        ]
        return found, float(result.no_speech_prob)

    def score(self, encoded: Encoded, text: str) -> tuple[float, int]:
        """How likely the sound makes a text: logarithm of the probability of its tokens, and their number.

        Args:
            encoded: The sound.
            text: Lower case, no punctuation; it is scored as Whisper would write it.
        """
        tokens = self._tokens(text)
        [aligned] = self._model.model.align(
            encoded.states, self._tokenizer.sot_sequence, [tokens], round(encoded.seconds * _FRAMES_PER_SECOND)
        )
        return sum(math.log(max(float(p), _LEAST)) for p in aligned.text_token_probs), len(tokens)

    def text(self, tokens: Sequence[int]) -> str:
        """The text of tokens, as Whisper writes it."""
        return str(self._tokenizer.decode(list(tokens)))

    def words(self, text: str, encoded: Encoded) -> list[tuple[str, float, float, float]]:
        """Each word of a text, as it is written: text, start and end [s], probability."""
        text_tokens = self._tokens(text)
        frames = round(encoded.seconds * _FRAMES_PER_SECOND)
        [aligned] = self._model.find_alignment(self._tokenizer, [text_tokens], encoded.states, frames) or [[]]
        return [
            (word["word"], float(word["start"]), float(word["end"]), float(word["probability"])) for word in aligned
        ]

    def _tokens(self, text: str) -> list[int]:
        """Of a text, as Whisper would write it."""
        written = _FIRST_PERSON.sub("I", text)
        return list(self._tokenizer.encode(f" {written[:1].upper()}{written[1:]}."))

    def _encoded_silence(self) -> NDArray[np.float32]:
        """What the encoder makes of the silence behind something like speech."""
        times = np.arange(SAMPLE_RATE) / SAMPLE_RATE
        pulses = (np.arange(SAMPLE_RATE) % (SAMPLE_RATE // 120) == 0).astype(np.float32)
        syllables = np.maximum(0.0, np.sin(2 * np.pi * 4 * times)).astype(np.float32)
        window = _SHORT + _PADDING + _SILENCE
        return np.asarray(self._model.encode(_padded(self.features(0.5 * pulses * syllables), window)))


def _padded(features: Features, seconds: float) -> Features:
    """As long as that, with an even number of frames: cut, or filled with silence."""
    frames = min(round(WINDOW * _FRAMES_PER_SECOND), (round(seconds * _FRAMES_PER_SECOND) + 1) // 2 * 2)
    features = features[:, :frames]
    filled = np.pad(
        features, ((0, 0), (0, frames - features.shape[-1])), constant_values=float(features.min(initial=0.0))
    )
    return np.ascontiguousarray(filled)
