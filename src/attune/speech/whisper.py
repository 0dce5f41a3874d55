"""Recognition with Whisper through faster-whisper (CTranslate2): knows all of English, needs weights and more power."""

import math
import re
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from attune.speech.age.features import log_mel
from attune.speech.audio import SAMPLE_RATE, Samples
from attune.speech.domain_fit import DomainFit
from attune.speech.recogniser import RecognisedWord, Recognition
from attune.speech.whisper_weights import require_whisper

_WINDOW = 30.0
"""Whisper sees so much sound at once [s]."""
_BEAM = 5
_HOT_WORDS = 60
_SHORTEST_HOT_WORD = 3
_MOST_TOKENS = 120
"""Nobody says more in 30 s."""
_LEAST_NEW_SOUND = 0.6
"""A partial result is made again after at least so much new sound [s] ..."""
_PARTIAL_SHARE = 3.0
"""... and after so many times what a partial result takes to compute."""
_SILENT = 0.6
"""Probability of no speech from which on nothing was said."""
_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_NO_WORD = re.compile(r"[^\w' ]+")
_BRACKETED = re.compile(r"\[[^\]]*\]|\([^)]*\)")


class WhisperRecogniser:
    """Whisper. It decodes whole utterances; for partial results it decodes what there is so far.

    Words of the domain are given to it as hot words, which it then prefers; sentences that are unlike the domain's are
    marked, by their text.

    Args:
        weights: Folder of converted weights; see `whisper_weights`.
        sentences: What people may say: lower case, no punctuation.
        threads: Of the processor; 0 leaves it to the library.

    Raises:
        MissingDependencyError: faster-whisper is not installed.
    """

    def __init__(self, weights: Path, sentences: Sequence[str], threads: int = 0) -> None:
        require_whisper()
        import ctranslate2
        from faster_whisper import WhisperModel
        from faster_whisper.tokenizer import Tokenizer

        self._device = "cuda" if ctranslate2.get_cuda_device_count() else "cpu"
        self._weights = weights
        self._model = WhisperModel(
            str(weights),
            device=self._device,
            compute_type="float16" if self._device == "cuda" else "int8",
            cpu_threads=threads,
        )
        self._tokenizer = Tokenizer(
            self._model.hf_tokenizer, self._model.model.is_multilingual, task="transcribe", language="en"
        )
        self._domain = DomainFit(sentences)
        self.hot_words = hot_words(sentences)
        """Words that it prefers."""
        self._prompt = self._model.get_prompt(
            self._tokenizer, [], without_timestamps=True, hotwords=" ".join(self.hot_words) or None
        )
        self._sound: list[Samples] = []
        self._seconds = 0.0
        self._partial = ""
        self._decoded_until = 0.0
        # How fast this machine is, and the first decoding, which is slower, is behind us.
        began = time.perf_counter()
        self._decode(self._features(np.zeros(SAMPLE_RATE, np.float32)), beam=1)
        self._pace = max(_LEAST_NEW_SOUND, _PARTIAL_SHARE * (time.perf_counter() - began))

    @property
    def name(self) -> str:
        """Whisper with its weights and device."""
        kind = "float16 on the graphics card" if self._device == "cuda" else "int8 on the processor"
        return f"Whisper ({_name_of(self._weights)}), {kind}"

    def start(self) -> None:
        """Begin an utterance."""
        self._sound = []
        self._seconds = self._decoded_until = 0.0
        self._partial = ""

    def accept(self, samples: Samples) -> None:
        """Take the next samples, 16 kHz mono. Costs nothing; the work is in `partial` and `finish`."""
        self._sound.append(samples)
        self._seconds += len(samples) / SAMPLE_RATE

    def partial(self) -> str:
        """What has been understood so far. Decodes again only after enough new sound, so it lags behind."""
        if self._seconds - self._decoded_until >= self._pace:
            self._decoded_until = self._seconds
            hypotheses, _, no_speech = self._decode(
                self._features(self._heard()[-int(_WINDOW * SAMPLE_RATE) :]), beam=1
            )
            self._partial = plain(self._tokenizer.decode(hypotheses[0][0])) if no_speech < _SILENT else ""
        return self._partial

    def finish(self) -> Recognition:
        """End the utterance: one decoding for each 30 s."""
        sound = self._heard()
        size = int(_WINDOW * SAMPLE_RATE)
        parts = [
            self._recognise(sound[start : start + size], start / SAMPLE_RATE)
            for start in range(0, max(len(sound), 1), size)
        ]
        self.start()
        said = [part for part in parts if part.text]
        if not said:
            return Recognition()
        text = " ".join(part.text for part in said)
        return Recognition(
            text=text,
            alternatives=said[0].alternatives if len(said) == 1 else (),
            confidence=min(part.confidence for part in said),
            in_domain=self._domain.contains(text),
            words=tuple(word for part in said for word in part.words),
            log_mel=parts[0].log_mel if len(parts) == 1 else None,
        )

    def _heard(self) -> Samples:
        return np.concatenate(self._sound) if self._sound else np.zeros(0, np.float32)

    def _recognise(self, sound: Samples, offset: float) -> Recognition:
        if len(sound) == 0:
            return Recognition()
        features = self._features(sound)
        hypotheses, encoded, no_speech = self._decode(features, beam=_BEAM)
        tokens, probability = hypotheses[0]
        text = plain(self._tokenizer.decode(tokens))
        if no_speech >= _SILENT or not text:
            return Recognition()
        readings = dict.fromkeys(plain(self._tokenizer.decode(other)) for other, _ in hypotheses[1:])
        return Recognition(
            text=text,
            alternatives=tuple(reading for reading in readings if reading not in {"", text}),
            confidence=probability * (1 - no_speech),
            words=self._words(tokens, encoded, len(sound), offset),
            log_mel=features,
        )

    def _features(self, sound: Samples) -> NDArray[np.float32]:
        # Ours instead of faster-whisper's: the same values, and an age model can take them as they are.
        return log_mel(sound, bands=self._model.model.n_mels)

    def _decode(self, features: NDArray[np.float32], beam: int) -> tuple[list[tuple[list[int], float]], Any, float]:
        """Token sequences with the mean probability of a token, best first; the encoded sound; chance of no speech."""
        from faster_whisper.audio import pad_or_trim

        encoded = self._model.encode(pad_or_trim(features))
        [result] = self._model.model.generate(
            encoded,
            [self._prompt],
            beam_size=beam,
            num_hypotheses=beam,
            max_length=len(self._prompt) + _MOST_TOKENS,
            return_scores=True,
            return_no_speech_prob=True,
        )
        # The score is divided by the length without the end token.
        found = [
            (list(tokens), math.exp(min(0.0, score * len(tokens) / (len(tokens) + 1))))
            for tokens, score in zip(result.sequences_ids, result.scores, strict=True)
        ]
        return found, encoded, float(result.no_speech_prob)

    def _words(self, tokens: list[int], encoded: Any, samples: int, offset: float) -> tuple[RecognisedWord, ...]:
        text_tokens = [token for token in tokens if token < self._tokenizer.eot]
        [aligned] = self._model.find_alignment(
            self._tokenizer, [text_tokens], encoded, samples // self._model.feature_extractor.hop_length
        ) or [[]]
        length = samples / SAMPLE_RATE
        words = []
        for word in aligned:
            if text := plain(word["word"]):
                start, end = (min(float(word[key]), length) + offset for key in ("start", "end"))
                words.append(RecognisedWord(text, start, max(start, end), float(word["probability"])))
        return tuple(words)


def hot_words(sentences: Sequence[str]) -> tuple[str, ...]:
    """The longer words that occur most often in the domain: things, colours, places and verbs."""
    counts = Counter(word for sentence in sentences for word in sentence.split() if len(word) > _SHORTEST_HOT_WORD)
    return tuple(word for word, _ in counts.most_common(_HOT_WORDS))


def plain(text: str) -> str:
    """A transcript as the other recognisers give it: lower case, no punctuation, small numbers as words."""
    text = _BRACKETED.sub(" ", text.lower().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")).replace("-", " ")
    words = (word.strip("'") for word in _NO_WORD.sub(" ", text).split())
    spoken = (_NUMBERS[int(word)] if word.isdecimal() and int(word) < len(_NUMBERS) else word for word in words)
    return " ".join(filter(None, spoken))


def _name_of(weights: Path) -> str:
    # The hub keeps snapshots as models--OWNER--NAME/snapshots/REVISION.
    parent = weights.parent.parent.name
    return parent.rpartition("--")[2] if parent.startswith("models--") else weights.name
