"""Offline recognition with PocketSphinx and a language model of the domain: the embedded default."""

import hashlib
import math
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from attune.speech.audio import Samples
from attune.speech.background import everyday_dictionary
from attune.speech.confidence import Reading, signal_to_noise
from attune.speech.domain_fit import DomainFit
from attune.speech.language_model import LanguageModel
from attune.speech.pronunciation import UnpronounceableWordError, dictionary_text, pronounce
from attune.speech.recogniser import RecognisedWord, Recognition

_MODEL_FORMAT = 2
"""Part of the key of cached models; to be raised when the way they are built changes."""
_LOG_BASE = math.log(1.0001)
"""PocketSphinx gives scores as powers of 1.0001."""
_FRAMES_PER_SECOND = 100

_ALTERNATIVES = 4

_USUAL_MEAN = (41.00, -5.29, -0.12, 5.09, 2.48, -4.07, -1.37, -1.78, -5.08, -2.05, -6.45, -1.42, 1.17)
"""Mean of the cepstra to begin with. The acoustic model's authors publish it with the model (`-cmninit`), the package's
copy of the model lacks it."""
_USUAL_FRAMES = 200
"""So many frames of somebody's own voice count as much as the usual mean."""
_DECODERS_MEMORY = 500
"""Frames that the decoder's own running mean counts a set mean for (CMN_WIN of cmn.h)."""
_KNOWN_AFTER = 300
"""After so many frames (3 s) the channel is known well enough not to begin utterances anew."""
_REMEMBERED = 1000
"""After so many frames (10 s) new sound moves the mean slowly."""
_ENOUGH = 133
"""So many frames (1.3 s, with the pre-roll) tell the mean of an utterance about as well as the whole of it."""

Mean = NDArray[np.float64]


class SphinxRecogniser:
    """PocketSphinx, streaming. The model is built from the sentences once and then cached.

    Next to the domain's model a small model of everyday English runs on the same sound: how much worse the domain
    explains the sound tells whether it is of the domain at all, together with how usual the text is.

    It adapts to the person and the microphone: the mean of the cepstra is kept from utterance to utterance. As long as
    it is not known well, an utterance is decoded anew as soon as enough of it was heard to tell the mean.

    Args:
        sentences: What people may say: lower case, no punctuation. Their words are all it can hear.
        cache: Folder for built models; None is the user's cache.
        judges: Whether it decides alone, also whether talk is of the domain. Beside another recogniser neither the
            model of everyday English nor a second pass over the utterance is needed.

    Raises:
        UnpronounceableWordError: A word cannot be learned, so it would be dropped in silence.
    """

    def __init__(self, sentences: Sequence[str], cache: Path | None = None, *, judges: bool = True) -> None:
        import pocketsphinx

        folder = _build(sentences, cache or Path(platformdirs.user_cache_dir("attune")) / "speech")
        models = Path(pocketsphinx.get_model_path()) / "en-us"
        common = {"hmm": str(models / "en-us"), "loglevel": "FATAL"}
        # The second pass gains little where another recogniser's readings compete, and is all the work at the end.
        self._domain = pocketsphinx.Decoder(
            lm=str(folder / "domain.arpa"), dict=str(folder / "domain.dict"), fwdflat=judges, **common
        )
        # Only its score is used: few hypotheses, one pass.
        self._everyday = pocketsphinx.Decoder(
            lm=str(models / "en-us.lm.bin"), dict=str(folder / "everyday.dict"), fwdflat=False, bestpath=False,
            maxhmmpf=3000, beam=1e-30, pbeam=1e-30, wbeam=1e-20, **common,
        ) if judges else None  # fmt: skip
        self._fit = DomainFit(sentences)
        self._decoders = (self._domain, self._everyday) if self._everyday else (self._domain,)
        self._heard: list[bytes] = []
        self._mean = self._begun_with = np.array(_USUAL_MEAN)
        self._knows_channel = False
        self._known_frames = 0
        self._is_over = True
        self._before = (self._mean, self._known_frames)
        self._words = (folder / "domain.dict").read_text("utf-8").count("\n")
        if unknown := [word for word in self._fit.words if not self._domain.lookup_word(word)]:
            raise UnpronounceableWordError(unknown)

    @property
    def name(self) -> str:
        """PocketSphinx with the size of its dictionary."""
        return f"PocketSphinx, {self._words} pronunciations"

    def start(self) -> None:
        """Begin an utterance; one that was not finished is dropped."""
        if not self._is_over:
            for decoder in self._decoders:
                decoder.end_utt()
        self._heard.clear()
        self._is_over = False
        self._before = (self._mean, self._known_frames)
        self._begin(self._mean)
        self._knows_channel = self._known_frames >= _KNOWN_AFTER

    def accept(self, samples: Samples) -> None:
        """Take the next samples, 16 kHz mono."""
        if self._is_over:
            self._go_on()
        data = pcm16(samples)
        self._heard.append(data)
        self._process(data)
        if not self._knows_channel and self._domain.n_frames() >= _ENOUGH:
            self._begin_anew()

    def partial(self) -> str:
        """What has been understood so far."""
        hypothesis = self._domain.hyp()
        return hypothesis.hypstr if hypothesis else ""

    def at_pause(self) -> str:
        """What has been understood so far."""
        return self.partial()

    def finish(self) -> Recognition:
        """End the utterance: 60 ms of work if it decides alone."""
        if not self._knows_channel:
            self._begin_anew()
        recognition = self._end()
        self._is_over = True
        if recognition.text:
            frames, mean = self._channel()
            self._mean = self._with_mean(frames, mean)
            self._known_frames = min(_REMEMBERED, self._known_frames + frames)
        return recognition

    def _begin_anew(self) -> None:
        """Decode what was heard of this utterance again, with a mean that it counts in."""
        for decoder in self._decoders:
            decoder.end_utt()
        self._decode_again(self._with_mean(*self._channel()))

    def _go_on(self) -> None:
        """The utterance had not ended: the decoders, which have ended it, decode what was heard of it again."""
        self._is_over = False
        mean, (self._mean, self._known_frames) = self._mean, self._before
        self._decode_again(mean)

    def _decode_again(self, mean: Mean) -> None:
        self._begin(mean)
        for data in self._heard:
            self._process(data)
        self._knows_channel = True

    def _with_mean(self, frames: int, mean: Mean) -> Mean:
        known = self._known_frames + _USUAL_FRAMES
        return (self._mean * known + mean * frames) / (known + frames)

    def _process(self, data: bytes) -> None:
        for decoder in self._decoders:
            decoder.process_raw(data)

    def _begin(self, mean: Mean) -> None:
        for decoder in self._decoders:
            decoder.set_cmn(",".join(f"{value:.4f}" for value in mean))
            decoder.start_utt()
        self._begun_with = mean

    def _end(self) -> Recognition:
        for decoder in self._decoders:
            decoder.end_utt()
        hypothesis = self._domain.hyp()
        words = tuple(self._said_words()) if hypothesis else ()
        if not words:
            return Recognition()
        reading = self._reading(hypothesis, words)
        return Recognition(
            text=hypothesis.hypstr,
            alternatives=self._alternatives(hypothesis.hypstr),
            confidence=reading.confidence,
            in_domain=reading.in_domain,
            words=words,
        )

    def _reading(self, hypothesis: Any, words: Sequence[RecognisedWord]) -> Reading:
        frames = sum(word.end - word.start for word in words) * _FRAMES_PER_SECOND
        everyday = self._everyday.hyp() if self._everyday else None
        # Everyday English may find no words at all in a single short sound.
        lead = _log(hypothesis.best_score) - _log(everyday.best_score) if everyday and everyday.hypstr else 0.0
        return Reading(
            over_everyday=lead / frames,
            fit=self._fit.fit(hypothesis.hypstr),
            weakest_word=min(word.confidence for word in words),
            snr=signal_to_noise(np.frombuffer(b"".join(self._heard), "<i2").astype(np.float32) / np.float32(32768)),
        )

    def _channel(self) -> tuple[int, Mean]:
        """Number of frames of the utterance, and the mean of its cepstra (what voice and microphone have in common).

        The decoder tells only its running mean, into which it took what it began with for 500 frames.
        """
        frames = max(1, self._domain.n_frames())
        running = _parsed(self._domain.get_cmn(True))
        return frames, (running * (_DECODERS_MEMORY + frames) - self._begun_with * _DECODERS_MEMORY) / frames

    def _said_words(self) -> list[RecognisedWord]:
        return [
            RecognisedWord(
                text=segment.word.split("(")[0],
                start=segment.start_frame / _FRAMES_PER_SECOND,
                end=(segment.end_frame + 1) / _FRAMES_PER_SECOND,
                confidence=min(1.0, float(segment.prob)),
            )
            for segment in self._domain.seg()
            if segment.word[0] not in "<[+"
        ]

    def _alternatives(self, best: str) -> tuple[str, ...]:
        found: dict[str, None] = {}
        # The list has many that differ in pauses only.
        for _, hypothesis in zip(range(50), self._domain.nbest() or (), strict=False):
            if hypothesis and hypothesis.hypstr and hypothesis.hypstr != best:
                found.setdefault(hypothesis.hypstr)
            if len(found) == _ALTERNATIVES:
                break
        return tuple(found)


def pcm16(samples: Samples) -> bytes:
    """Samples as the 16 bit little-endian integers that the decoders take."""
    return (np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes()


def _parsed(mean: str) -> Mean:
    return np.array([float(value) for value in mean.split(",")])


def _log(score: Any) -> float:
    """A score as logarithm to the base 1.0001; a score of zero has underflowed."""
    return math.log(max(float(score), 1e-300)) / _LOG_BASE


def _build(sentences: Sequence[str], cache: Path) -> Path:
    """The folder with `domain.arpa` and `domain.dict`, built if it is not cached."""
    key = hashlib.sha256("\n".join([str(_MODEL_FORMAT), *sentences]).encode()).hexdigest()[:16]
    folder = cache / key
    if folder.is_dir():
        return folder
    model = LanguageModel(sentences)
    dictionary = dictionary_text(pronounce(model.words))
    cache.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(dir=cache, prefix="unfinished-"))
    (unfinished / "domain.arpa").write_text(model.arpa(), encoding="utf-8")
    (unfinished / "domain.dict").write_text(dictionary, encoding="utf-8")
    (unfinished / "everyday.dict").write_text(everyday_dictionary(), encoding="utf-8")
    try:
        os.replace(unfinished, folder)
    except OSError:
        # Another process was faster and built the same.
        shutil.rmtree(unfinished)
    return folder
