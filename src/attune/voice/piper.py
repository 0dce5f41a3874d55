"""Text to sound with Piper, a neural voice: more natural than espeak-ng, needs a voice file and more power.

Piper is GPL-3 (as espeak-ng is), so it is not installed with Attune: `pip install 'attune-hri[piper]'`.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from attune.core.errors import AttuneError, MissingDependencyError
from attune.voice.synthesis import Speech, WordMark

_USUAL_RATE = 175
"""Words per minute of most Piper voices at their own pace."""
_SLOWEST, _FASTEST = 80, 450
_WORD = re.compile(r"\S+")


class PiperVoiceError(AttuneError):
    """The voice's file is missing or cannot be used."""

    def __init__(self, voice: str, problem: str) -> None:
        folder = voices_folder()
        super().__init__(
            f"the Piper voice {voice!r} {problem}",
            f"Fetch one with `python -m piper.download_voices en_GB-alba-medium --download-dir {folder}`, or give the "
            "path of an .onnx file whose .onnx.json lies beside it",
        )


def voices_folder() -> Path:
    """Where voices are looked for by name."""
    return Path(platformdirs.user_cache_dir("attune")) / "piper"


class PiperSynthesiser:
    """Speaks text with one Piper voice. One call at a time.

    Piper draws its intonation by chance, so the same text sounds a little different each time.

    Args:
        voice: Path of an `.onnx` file, or a name such as `en_GB-alba-medium` in `voices_folder`.

    Raises:
        MissingDependencyError: Piper is not installed.
        PiperVoiceError: The voice is not there, or its file is broken.
    """

    def __init__(self, voice: str) -> None:
        try:
            from piper import PiperVoice
        except ImportError:
            raise MissingDependencyError(
                "Piper", "`voice.engine = piper`", "Run `pip install 'attune-hri[piper]'`"
            ) from None
        model = _find(voice)
        try:
            self._voice: Any = PiperVoice.load(model)
        except Exception as error:  # noqa: BLE001 - the runtime raises classes of its own for broken files
            raise PiperVoiceError(voice, f"cannot be loaded ({type(error).__name__})") from None

    @property
    def sample_rate(self) -> int:
        """Samples per second."""
        return int(self._voice.config.sample_rate)

    def synthesise(
        self, text: str, *, voice: str = "", rate_wpm: int = 170, pitch: int = 50, loudness: float = 0.8
    ) -> Speech:
        """Turn text into sound.

        Args:
            text: What to say.
            voice: Not used: the voice is the file's.
            rate_wpm: Words per minute, 80 to 450; roughly.
            pitch: Not used: Piper's voices have their own.
            loudness: 0 to 1, the peak of the samples.
        """
        from piper import SynthesisConfig

        pace = min(max(rate_wpm, _SLOWEST), _FASTEST) / _USUAL_RATE
        options = SynthesisConfig(length_scale=self._voice.config.length_scale / pace, volume=1.0)
        pieces = [chunk.audio_float_array for chunk in self._voice.synthesize(text.replace("\0", " "), options)]
        raw = np.concatenate(pieces) if pieces else np.zeros(0, np.float32)
        samples = np.asarray(raw * min(max(loudness, 0.0), 1.0), dtype=np.float32)
        samples.setflags(write=False)
        return Speech(text, samples, self.sample_rate, _word_marks(text, len(samples) / self.sample_rate))


def _find(voice: str) -> Path:
    named = voices_folder() / f"{voice}.onnx"
    model = Path(voice).expanduser() if voice.endswith(".onnx") else named
    if not model.is_file():
        raise PiperVoiceError(voice, f"is not there: {model} does not exist")
    if not Path(f"{model}.json").is_file():
        raise PiperVoiceError(voice, f"lacks its settings: {model.name}.json does not exist")
    return model


def _word_marks(text: str, duration: float) -> tuple[WordMark, ...]:
    """Piper does not tell when a word begins: estimated, as if each letter took the same time."""
    words = list(_WORD.finditer(text))
    letters = sum(len(word.group()) for word in words)
    marks, before = [], 0
    for word in words:
        marks.append(WordMark(duration * before / letters, word.start(), word.end()))
        before += len(word.group())
    return tuple(marks)
