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
_STATES_PER_SECOND = _FRAMES_PER_SECOND // 2
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
        scored: Of the states, those that texts are scored against, as an array; None takes `states`. A text that is
            given does not repeat itself, so it needs no silence behind it, which takes time.
    """

    states: Any
    features: Features
    scored: Features | None = None

    @property
    def seconds(self) -> float:
        """Length of the sound."""
        return int(self.features.shape[-1]) / _FRAMES_PER_SECOND


@dataclass(frozen=True, slots=True)
class Scored:
    """How well a text fits the sound.

    Attributes:
        log_probability: Sum over the tokens (natural logarithm).
        tokens: Of the text.
        aligned: What CTranslate2 found.
    """

    log_probability: float
    tokens: tuple[int, ...]
    aligned: Any

    @property
    def mean_log_probability(self) -> float:
        """Of a token."""
        return self.log_probability / max(1, len(self.tokens))


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

        states = np.array(self._model.encode(_padded(features, seconds + _PADDING)))
        length = states.shape[1]
        silence = self._silence[:, length : length + round(_SILENCE * _FRAMES_PER_SECOND / 2)]
        return Encoded(StorageView.from_array(np.concatenate([states, silence], axis=1)), features, states)

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

    def score(self, encoded: Encoded, texts: Sequence[str]) -> list[Scored]:
        """How likely the sound makes each of some texts.

        Args:
            encoded: The sound.
            texts: Lower case, no punctuation; each is scored as Whisper would write it.
        """
        from ctranslate2 import StorageView

        if not texts:
            return []
        tokens = [self._tokens(text) for text in texts]
        states = np.asarray(encoded.states) if encoded.scored is None else encoded.scored
        found = self._model.model.align(
            StorageView.from_array(np.repeat(states, len(texts), axis=0)),
            self._tokenizer.sot_sequence,
            tokens,
            [round(encoded.seconds * _FRAMES_PER_SECOND)] * len(texts),
        )
        return [
            Scored(sum(math.log(max(float(p), _LEAST)) for p in each.text_token_probs), tuple(said), each)
            for said, each in zip(tokens, found, strict=True)
        ]

    def text(self, tokens: Sequence[int]) -> str:
        """The text of tokens, as Whisper writes it."""
        return str(self._tokenizer.decode(list(tokens)))

    def words(self, scored: Scored) -> list[tuple[str, float, float, float]]:
        """Each word of a text, as it is written: text, start and end [s], probability."""
        begins: dict[int, float] = {}
        for token, frame in scored.aligned.alignments:
            begins.setdefault(token, frame / _STATES_PER_SECOND)
        words, tokens = self._tokenizer.split_to_word_tokens([*scored.tokens, self._tokenizer.eot])
        said, first = [], 0
        for word, of_word in zip(words[:-1], tokens[:-1], strict=True):
            last = first + len(of_word)
            probability = float(np.mean(scored.aligned.text_token_probs[first:last]))
            said.append((word, begins[first], begins[last], probability))
            first = last
        return said

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
