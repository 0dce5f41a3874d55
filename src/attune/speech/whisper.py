"""Recognition with Whisper, which knows all of English.

Its best hypotheses are ranked by their own probability and by that of a language model of the domain together.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from attune.speech.audio import SAMPLE_RATE, Samples
from attune.speech.confidence import WrittenReading, signal_to_noise
from attune.speech.domain_fit import DomainFit
from attune.speech.recogniser import RecognisedWord, Recognition
from attune.speech.whisper_model import WINDOW, Encoded, Hypothesis, WhisperModel
from attune.speech.whisper_weights import require_whisper

_BEAM = 5
_DOMAIN_WEIGHT = 0.25
"""Of the domain's language model against Whisper's own; more helps poor voices and harms good ones."""
_HOT_WORDS = 60
_SHORTEST_HOT_WORD = 3
_NEW_SOUND = 0.5
"""A partial result is made again after so much new sound [s] ..."""
_EARLY = 2.2
"""... and, on a processor, only until then [s]: short orders are heard at once, what is longer at its pauses."""
_NOBODY = 0.6
"""Probability of no speech from which on nothing was said."""
_REPEATS, _REPEATS_WORD = 4, 6
"""So many times in a row a decoder repeats itself: several words, one word ("stop stop stop" is none)."""
_LONGEST_REPEATED = 8
_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
            "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen")  # fmt: skip
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_NO_WORD = re.compile(r"[^\w' ]+")
_BRACKETED = re.compile(r"\[[^\]]*\]|\([^)]*\)")


@dataclass(frozen=True, slots=True)
class _Read:
    """A reading of up to 30 s of sound, and what it was read from."""

    recognition: Recognition
    best: Hypothesis
    encoded: Encoded


class WhisperRecogniser:
    """Whisper. It reads an utterance when the person pauses, so that the text is there when the utterance ends.

    Args:
        weights: Folder of converted weights; see `whisper_weights`.
        sentences: What people may say: lower case, no punctuation.
        threads: Of the processor; 0 leaves it to the library.

    Raises:
        MissingDependencyError: faster-whisper is not installed.
    """

    def __init__(self, weights: Path, sentences: Sequence[str], threads: int = 0) -> None:
        require_whisper()
        self._weights = weights
        self._model = WhisperModel(weights, threads)
        self._on_gpu = self._model.device == "cuda"
        self._domain = DomainFit(sentences)
        self.hot_words = hot_words(sentences)
        """Words that a graphics card, which hears the whole window, prefers. In a short one they are repeated."""
        self._sound: list[Samples] = []
        self._seconds = self._partial_until = 0.0
        self._partial = ""
        self._read: list[_Read] | None = None
        # The first decoding, which is slower, is behind us.
        self._decode(np.zeros(SAMPLE_RATE, np.float32), beam=1)

    @property
    def name(self) -> str:
        """Whisper with its weights and device."""
        kind = "float16 on the graphics card" if self._on_gpu else "int8 on the processor"
        return f"Whisper ({_name_of(self._weights)}), {kind}"

    def start(self) -> None:
        """Begin an utterance."""
        self._sound = []
        self._seconds = self._partial_until = 0.0
        self._partial = ""
        self._read = None

    def accept(self, samples: Samples) -> None:
        """Take the next samples, 16 kHz mono. Costs nothing; the work is in the other methods."""
        self._sound.append(samples)
        self._seconds += len(samples) / SAMPLE_RATE
        self._read = None

    def partial(self) -> str:
        """What has been understood so far. It lags behind, and is not made again while somebody talks for long."""
        due = self._seconds - self._partial_until >= _NEW_SOUND and (self._on_gpu or self._seconds <= _EARLY)
        if due and self._read is None:
            self._partial_until = self._seconds
            sound = self._heard()[-int(WINDOW * SAMPLE_RATE) :]
            [best], _, nobody = self._decode(sound, beam=1)
            self._partial = plain(self._model.text(best.tokens)) if nobody < _NOBODY else ""
        return self._partial

    def at_pause(self) -> str:
        """The text if the utterance ends here, some 0.1 s of work, which `finish` need not do again."""
        self._partial_until = self._seconds
        self._partial = " ".join(part.recognition.text for part in self._reading() if part.recognition.text)
        return self._partial

    def finish(self) -> Recognition:
        """End the utterance."""
        read = self._reading()
        self.start()
        said = [(part, index * WINDOW) for index, part in enumerate(read) if part.recognition.text]
        if not said:
            return Recognition()
        words = tuple(word for part, offset in said for word in self._words(part, offset))
        if len(said) == 1:
            only = said[0][0].recognition
            return replace(only, words=words, log_mel=only.log_mel if len(read) == 1 else None)
        return Recognition(
            text=" ".join(part.recognition.text for part, _ in said),
            confidence=min(part.recognition.confidence for part, _ in said),
            in_domain=all(part.recognition.in_domain for part, _ in said),
            words=words,
        )

    def _heard(self) -> Samples:
        return np.concatenate(self._sound) if self._sound else np.zeros(0, np.float32)

    def _reading(self) -> list[_Read]:
        """Of each 30 s."""
        if self._read is None:
            sound, size = self._heard(), int(WINDOW * SAMPLE_RATE)
            self._read = [self._read_part(sound[start : start + size]) for start in range(0, len(sound), size)]
        return self._read

    def _read_part(self, sound: Samples) -> _Read:
        hypotheses, encoded, nobody = self._decode(sound, beam=_BEAM)
        if repeats(plain(self._model.text(hypotheses[0].tokens))):
            hypotheses, encoded, nobody = self._decode(sound, beam=_BEAM, whole_window=True)
        readings: dict[str, Hypothesis] = {}
        for hypothesis in hypotheses:
            readings.setdefault(plain(self._model.text(hypothesis.tokens)), hypothesis)
        ranked = sorted(filter(None, readings), key=lambda text: self._score(text, readings[text]), reverse=True)
        if nobody >= _NOBODY or not ranked:
            return _Read(Recognition(), hypotheses[0], encoded)
        text, *others = ranked
        best = readings[text]
        reading = WrittenReading(
            fit=self._domain.fit(text),
            telling_words=self._domain.telling_words(text),
            tokens=best.mean_log_probability,
            snr=signal_to_noise(sound),
        )
        recognition = Recognition(
            text=text,
            alternatives=tuple(others),
            confidence=reading.confidence,
            in_domain=reading.in_domain,
            log_mel=encoded.features,
        )
        return _Read(recognition, best, encoded)

    def _score(self, text: str, hypothesis: Hypothesis) -> float:
        return hypothesis.log_probability + _DOMAIN_WEIGHT * self._domain.log_probability(text)

    def _decode(
        self, sound: Samples, *, beam: int, whole_window: bool = False
    ) -> tuple[list[Hypothesis], Encoded, float]:
        encoded = self._model.encode(self._model.features(sound), whole_window=whole_window)
        hypotheses, nobody = self._model.decode(encoded, beam=beam, hot_words=self.hot_words if self._on_gpu else ())
        return hypotheses, encoded, nobody

    def _words(self, part: _Read, offset: float) -> list[RecognisedWord]:
        words = []
        for written, start, end, probability in self._model.words(part.best.tokens, part.encoded):
            if text := plain(written):
                first, last = (min(time, part.encoded.seconds) + offset for time in (start, end))
                words.append(RecognisedWord(text, first, max(first, last), probability))
        return words


def hot_words(sentences: Sequence[str]) -> tuple[str, ...]:
    """The longer words that occur most often in the domain: things, colours, places and verbs."""
    counts = Counter(word for sentence in sentences for word in sentence.split() if len(word) > _SHORTEST_HOT_WORD)
    return tuple(word for word, _ in counts.most_common(_HOT_WORDS))


def repeats(text: str) -> bool:
    """Whether a text ends in the same words again and again."""
    words = text.split()
    return any(
        len(words) >= length * times and words[-length * times :] == words[-length:] * times
        for length in range(1, _LONGEST_REPEATED + 1)
        for times in [_REPEATS_WORD if length == 1 else _REPEATS]
    )


def plain(text: str) -> str:
    """A transcript as the other recognisers give it: lower case, no punctuation, numbers under a hundred as words."""
    text = _BRACKETED.sub(" ", text.lower().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")).replace("-", " ")
    words = (word.strip("'") for word in _NO_WORD.sub(" ", text).split())
    return " ".join(filter(None, (_spoken(word) for word in words)))


def _spoken(word: str) -> str:
    """A number as people say it; anything else as it is."""
    if not word.isdecimal() or int(word) >= 100:
        return word
    number = int(word)
    if number < len(_NUMBERS):
        return _NUMBERS[number]
    tens, ones = _TENS[number // 10 - 2], number % 10
    return f"{tens} {_NUMBERS[ones]}" if ones else tens


def _name_of(weights: Path) -> str:
    from attune.speech.whisper_weights import PACKAGED, packaged_weights

    # The hub keeps snapshots as models--OWNER--NAME/snapshots/REVISION.
    parent = weights.parent.parent.name
    if parent.startswith("models--"):
        return parent.rpartition("--")[2]
    return PACKAGED if weights == packaged_weights() else weights.name
