"""Text to sound, in the process, through espeak-ng."""

import ctypes
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from attune.core.errors import AttuneError
from attune.core.espeak import exclusive_library, sample_rate, select_voice

_RATE, _PITCH = 1, 3
_UTF8, _END_PAUSE = 1, 0x1000
_LIST_TERMINATED, _WORD = 0, 1
_SLOWEST, _FASTEST = 80, 450
"""Words per minute that espeak-ng can speak."""


class SynthesisError(AttuneError):
    """The text could not be turned into sound."""

    def __init__(self, detail: str) -> None:
        super().__init__(f"the voice cannot speak this: {detail}", "Give a text with words in it, and a valid rate")


@dataclass(frozen=True, slots=True)
class WordMark:
    """When a word of the text begins to sound.

    Attributes:
        time: From the beginning of the samples [s].
        start: Index of the word's first character.
        end: Index after its last character.
    """

    time: float
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Speech:
    """Synthesised speech.

    Attributes:
        samples: Shape (n,), float32, -1 to 1, mono, read-only.
        sample_rate: Samples per second.
        words: One mark per spoken word, in order.
    """

    text: str
    samples: NDArray[np.float32]
    sample_rate: int
    words: tuple[WordMark, ...]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return len(self.samples) / self.sample_rate

    def spoken_until(self, time: float) -> str:
        """The part of the text whose words have begun to sound `time` seconds after the beginning."""
        return self.text[: max((word.end for word in self.words if word.time <= time), default=0)]


class Synthesis(Protocol):
    """What turns text into sound."""

    @property
    def sample_rate(self) -> int:
        """Samples per second."""
        ...

    def synthesise(
        self, text: str, *, voice: str = ..., rate_wpm: int = ..., pitch: int = ..., loudness: float = ...
    ) -> Speech:
        """See `Synthesiser.synthesise`."""
        ...


class _EventId(ctypes.Union):
    _fields_ = (("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8))


class _Event(ctypes.Structure):
    """`espeak_EVENT` of speak_lib.h."""

    _fields_ = (
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", _EventId),
    )


_SynthCallback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(_Event))


class Synthesiser:
    """Speaks text. May be used from any thread; calls wait for each other (1 s of sound takes about 1 ms).

    The same arguments give the same samples.
    """

    @property
    def sample_rate(self) -> int:
        """Samples per second."""
        return sample_rate()

    def synthesise(
        self, text: str, *, voice: str = "en-gb", rate_wpm: int = 170, pitch: int = 50, loudness: float = 0.8
    ) -> Speech:
        """Turn text into sound.

        Args:
            text: What to say. A text without words gives at most a short silence.
            voice: Language, and after a `+` a variant: `en-gb`, `en-us+f3`.
            rate_wpm: Words per minute, 80 to 450; values outside are moved to the nearest.
            pitch: 0 to 100, 50 is the voice's own.
            loudness: 0 to 1, a factor of the samples.

        Raises:
            UnknownVoiceError: There is no such voice; the message lists some.
            SynthesisError: espeak-ng refused.
        """
        pieces: list[NDArray[np.int16]] = []
        words: list[WordMark] = []

        def collect(samples: Any, count: int, events: Any) -> int:
            if count > 0:
                pieces.append(np.ctypeslib.as_array(samples, shape=(count,)).copy())
            index = 0
            while events[index].type != _LIST_TERMINATED:
                event = events[index]
                if event.type == _WORD:
                    # Positions count from 1.
                    start = event.text_position - 1
                    words.append(WordMark(event.audio_position / 1000, start, start + event.length))
                index += 1
            return 0

        callback = _SynthCallback(collect)
        # A NUL would end the text for the library.
        encoded = text.replace("\0", " ").encode()
        with exclusive_library() as library:
            select_voice(library, voice)
            library.espeak_SetSynthCallback(callback)
            library.espeak_SetParameter(_RATE, min(max(rate_wpm, _SLOWEST), _FASTEST), 0)
            library.espeak_SetParameter(_PITCH, min(max(pitch, 0), 100), 0)
            status = library.espeak_Synth(encoded, len(encoded) + 1, 0, 1, 0, _UTF8 | _END_PAUSE, None, None)
        if status != 0:
            raise SynthesisError(f"espeak-ng answered {status}")
        raw = np.concatenate(pieces) if pieces else np.zeros(0, np.int16)
        samples = (raw.astype(np.float32) / 32768 * min(max(loudness, 0.0), 1.0)).astype(np.float32)
        samples.setflags(write=False)
        return Speech(text=text, samples=samples, sample_rate=sample_rate(), words=tuple(words))
