"""Recognition with Whisper, which knows all of English.

Its best hypotheses are ranked by their own probability and by that of a language model of the domain together.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np

from attune.speech.audio import SAMPLE_RATE, Samples
from attune.speech.confidence import WrittenReading, signal_to_noise
from attune.speech.domain_fit import DomainFit
from attune.speech.recogniser import RecognisedWord, Recogniser, Recognition
from attune.speech.whisper_model import WINDOW, Encoded, Hypothesis, Scored, WhisperModel
from attune.speech.whisper_weights import require_whisper

_BEAM = 5
_RIVALS = 2
"""So many other readings of the second recogniser compete."""
_DOMAIN_WEIGHT = 0.8
"""Of the domain's language model against Whisper's own probability. Chosen, as all here, on voices of development: 0.5
has fewer wrong words, this more of the words that matter."""
_HOT_WORDS = 60
_SHORTEST_HOT_WORD = 3
_NEW_SOUND = 0.5
"""A partial result is made again after so much new sound [s] ..."""
_EARLY = 2.2
"""... and, on a processor, only until then [s]: short orders are heard at once, what is longer at its pauses."""
_NOBODY = 0.6
_UNSURE = -0.5
"""Nothing was said if the probability of no speech is so high and the mean logarithm of a token's probability so low,
unless both recognisers have found the same."""
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
    """Whisper's readings of up to 30 s of sound, best first, and what they were read from.

    Attributes:
        texts: Different ones; none if nothing can be read.
        encoded: The sound, encoded.
        nobody: Whisper thinks that nobody spoke.
    """

    texts: tuple[str, ...]
    encoded: Encoded
    nobody: bool


class WhisperRecogniser:
    """Whisper. An utterance is recognised when the person pauses, so that the text is there when it ends.

    Args:
        weights: Folder of converted weights; see `whisper_weights`.
        sentences: What people may say: lower case, no punctuation.
        second: A recogniser that knows only the domain and listens along: its partial results come while people speak,
            and its readings compete with Whisper's.
        threads: Of the processor; 0 leaves it to the library.

    Raises:
        MissingDependencyError: faster-whisper is not installed.
    """

    def __init__(
        self, weights: Path, sentences: Sequence[str], second: Recogniser | None = None, threads: int = 0
    ) -> None:
        require_whisper()
        self._weights = weights
        self._second = second
        self._model = WhisperModel(weights, threads)
        self._on_gpu = self._model.device == "cuda"
        self._domain = DomainFit(sentences)
        self.hot_words = hot_words(sentences)
        """Words that a graphics card, which hears the whole window, prefers. In a short one they are repeated."""
        self._sound: list[Samples] = []
        self._seconds = self._partial_until = 0.0
        self._partial = ""
        self._recognised: Recognition | None = None
        # The first decoding, which is slower, is behind us.
        self._decode(np.zeros(SAMPLE_RATE, np.float32), beam=1)

    @property
    def name(self) -> str:
        """Whisper with its weights and device."""
        kind = "float16 on the graphics card" if self._on_gpu else "int8 on the processor"
        beside = f", beside {self._second.name}" if self._second else ""
        return f"Whisper ({_name_of(self._weights)}), {kind}{beside}"

    def start(self) -> None:
        """Begin an utterance."""
        self._sound = []
        self._seconds = self._partial_until = 0.0
        self._partial = ""
        self._recognised = None
        if self._second:
            self._second.start()

    def accept(self, samples: Samples) -> None:
        """Take the next samples, 16 kHz mono."""
        self._sound.append(samples)
        self._seconds += len(samples) / SAMPLE_RATE
        self._recognised = None
        if self._second:
            self._second.accept(samples)

    def partial(self) -> str:
        """What has been understood so far. Whisper alone lags behind, and waits for a pause of who talks for long."""
        if self._recognised is not None:
            return self._recognised.text
        if self._second:
            return self._second.partial()
        if self._seconds - self._partial_until >= _NEW_SOUND and (self._on_gpu or self._seconds <= _EARLY):
            self._partial_until = self._seconds
            sound = self._heard()[-int(WINDOW * SAMPLE_RATE) :]
            [best], _, nobody = self._decode(sound, beam=1)
            self._partial = plain(self._model.text(best.tokens)) if nobody < _NOBODY else ""
        return self._partial

    def at_pause(self) -> str:
        """The text if the utterance ends here: some 0.2 s of work, after which `finish` has nothing more to do."""
        self._partial_until = self._seconds
        self._partial = self.finish().text
        return self._partial

    def finish(self) -> Recognition:
        """End the utterance."""
        if self._recognised is None:
            self._recognised = self._recognise()
        return self._recognised

    def _recognise(self) -> Recognition:
        """Whisper's readings and the other recogniser's compete."""
        sound, size = self._heard(), int(WINDOW * SAMPLE_RATE)
        read = [self._read_part(sound[start : start + size]) for start in range(0, len(sound), size)]
        other = self._second.finish() if self._second else None
        if len(read) == 1:
            return self._decide(read[0], sound, other)
        said = [
            (self._decide(part, sound[index * size : (index + 1) * size], None), index * WINDOW)
            for index, part in enumerate(read)
            if part.texts and not part.nobody
        ]
        if not said:
            return Recognition()
        return Recognition(
            text=" ".join(part.text for part, _ in said),
            confidence=min(part.confidence for part, _ in said),
            in_domain=all(part.in_domain for part, _ in said),
            words=tuple(
                replace(word, start=word.start + offset, end=word.end + offset)
                for part, offset in said
                for word in part.words
            ),
        )

    def _heard(self) -> Samples:
        return np.concatenate(self._sound) if self._sound else np.zeros(0, np.float32)

    def _read_part(self, sound: Samples) -> _Read:
        hypotheses, encoded, nobody = self._decode(sound, beam=_BEAM)
        if repeats(plain(self._model.text(hypotheses[0].tokens))):
            hypotheses, encoded, nobody = self._decode(sound, beam=_BEAM, whole_window=True)
        readings: dict[str, float] = {}
        for hypothesis in hypotheses:
            readings.setdefault(plain(self._model.text(hypothesis.tokens)), hypothesis.log_probability)
        readings.pop("", None)
        ranked = sorted(readings, key=lambda text: self._with_domain(readings[text], text), reverse=True)
        return _Read(tuple(ranked), encoded, nobody >= _NOBODY and hypotheses[0].mean_log_probability < _UNSURE)

    def _decide(self, read: _Read, sound: Samples, other: Recognition | None) -> Recognition:
        """The best of both recognisers' readings: the product of how likely the sound and the domain make it."""
        others = (other.text, *other.alternatives[:_RIVALS]) if other and other.text else ()
        firsts = {*read.texts[:1], *others[:1]}
        agreed = len(firsts) == 1 and bool(others and read.texts)
        if read.nobody and not agreed:
            return Recognition()
        rivals = firsts if agreed else dict.fromkeys((*read.texts[:2], *others))
        scores = dict(zip(rivals, self._model.score(read.encoded, list(rivals)), strict=True))
        together = {text: self._with_domain(scores[text].log_probability, text) for text in rivals}
        ranked = sorted(together, key=together.__getitem__, reverse=True)
        if not ranked:
            return Recognition()
        best = ranked[0]
        telling = self._domain.telling_words(best)
        alike = all(list(self._domain.telling_words(text)) == list(telling) for text in firsts)
        reading = WrittenReading(
            fit=self._domain.fit(best),
            telling_words=sum(telling.values()),
            tokens=scores[best].mean_log_probability,
            agreed=0.5 if other is None else float(alike and bool(others)),
            lead=min((together[best] - together[text] for text in ranked if self._tells_more(text, best)), default=inf),
            unknown=self._domain.unknown_words(best),
            snr=signal_to_noise(sound),
        )
        more = (*ranked[1:], *read.texts, *others)
        return Recognition(
            text=best,
            alternatives=tuple(dict.fromkeys(text for text in more if text != best)),
            confidence=reading.confidence,
            in_domain=reading.in_domain,
            words=other.words if other and other.text == best else self._words(scores[best], read.encoded.seconds),
            log_mel=read.encoded.features,
        )

    def _tells_more(self, text: str, best: str) -> bool:
        """Whether a reading has telling words that the best one has not."""
        return not self._domain.telling_words(text).keys() <= self._domain.telling_words(best).keys()

    def _with_domain(self, log_probability: float, text: str) -> float:
        return log_probability + _DOMAIN_WEIGHT * self._domain.log_probability(text)

    def _decode(
        self, sound: Samples, *, beam: int, whole_window: bool = False
    ) -> tuple[list[Hypothesis], Encoded, float]:
        encoded = self._model.encode(self._model.features(sound), whole_window=whole_window)
        hypotheses, nobody = self._model.decode(encoded, beam=beam, hot_words=self.hot_words if self._on_gpu else ())
        return hypotheses, encoded, nobody

    def _words(self, scored: Scored, seconds: float) -> tuple[RecognisedWord, ...]:
        words = []
        for written, start, end, probability in self._model.words(scored):
            if word := plain(written):
                first, last = (min(time, seconds) for time in (start, end))
                words.append(RecognisedWord(word, first, max(first, last), probability))
        return tuple(words)


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
