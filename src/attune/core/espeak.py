"""The espeak-ng library, shared: it keeps its state in the process, so one caller at a time.

The voice speaks through it, and the speech recogniser asks it how unknown words are pronounced. The library and its
data come with the package `espeakng-loader`; nothing is installed on the machine.
"""

import ctypes
import difflib
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from attune.core.errors import AttuneError, MissingDependencyError

_SYNCHRONOUS = 2
_VARIANT_DIRECTORY = "!v"
_IN_USE = threading.Lock()


class UnknownVoiceError(AttuneError):
    """There is no such voice."""

    def __init__(self, voice: str, known: list[str]) -> None:
        close = difflib.get_close_matches(voice, known, n=5, cutoff=0.4) or known[:8]
        super().__init__(f"there is no voice {voice!r}", f"Some that exist: {', '.join(close)}")


class _VoiceEntry(ctypes.Structure):
    """`espeak_VOICE` of speak_lib.h."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("languages", ctypes.c_char_p),
        ("identifier", ctypes.c_char_p),
        ("gender", ctypes.c_ubyte),
        ("age", ctypes.c_ubyte),
        ("variant", ctypes.c_ubyte),
        ("reserved", ctypes.c_ubyte),
        ("score", ctypes.c_int),
        ("spare", ctypes.c_void_p),
    )


@contextmanager
def exclusive_library() -> Iterator[Any]:
    """The library, initialised afresh, for this thread alone until the block ends.

    Afresh (2 ms), because the library carries the phase of its pitch flutter from one call to the next: only so is
    its sound a function of what it is given, and a trial can be repeated.
    """
    with _IN_USE:
        library, _ = _initialise()
        try:
            yield library
        finally:
            _unload(library)


def sample_rate() -> int:
    """Samples per second of what the library synthesises."""
    with _IN_USE:
        return _initialise()[1]


def select_voice(library: Any, voice: str) -> None:
    """Choose the voice for the next calls.

    Args:
        library: From `exclusive_library`.
        voice: A language (`en-gb`), name or identifier, and after a `+` a variant (`en-us+f3`), in any case.

    Raises:
        UnknownVoiceError: There is no such language or variant; the message lists some.
    """
    language, plus, variant = voice.strip().partition("+")
    languages, variants = _known_voices()
    if language.lower() not in languages:
        raise UnknownVoiceError(voice, sorted(languages))
    if plus and variant.lower() not in variants:
        raise UnknownVoiceError(voice, [f"{language}+{known}" for known in sorted(variants.values())])
    chosen = languages[language.lower()] + (f"+{variants[variant.lower()]}" if plus else "")
    if library.espeak_SetVoiceByName(chosen.encode()) != 0:
        raise UnknownVoiceError(voice, sorted(languages))


@cache
def _initialise() -> tuple[Any, int]:
    try:
        import espeakng_loader
    except ImportError:
        raise MissingDependencyError("espeakng-loader", "speaking", "Run `pip install espeakng-loader`") from None
    library = ctypes.CDLL(espeakng_loader.get_library_path())
    rate = library.espeak_Initialize(_SYNCHRONOUS, 0, espeakng_loader.get_data_path().encode(), 0)
    if rate <= 0:
        raise MissingDependencyError("the data of espeak-ng", "speaking", "Reinstall `espeakng-loader`")
    library.espeak_ListVoices.restype = ctypes.POINTER(ctypes.POINTER(_VoiceEntry))
    library.espeak_TextToPhonemes.restype = ctypes.c_char_p
    return library, rate


def _unload(library: Any) -> None:
    # Elsewhere than on Linux and macOS the library stays loaded, and repeats differ by a few samples.
    if sys.platform != "win32":
        import _ctypes

        library.espeak_Terminate()
        _ctypes.dlclose(library._handle)
        _initialise.cache_clear()


@cache
def _known_voices() -> tuple[dict[str, str], dict[str, str]]:
    """Lower-case language, name or identifier to identifier, and lower-case variant to variant."""
    import espeakng_loader

    entries = _initialise()[0].espeak_ListVoices(None)
    languages: dict[str, str] = {}
    index = 0
    while entries[index]:
        entry = entries[index].contents
        identifier = entry.identifier.decode()
        # The first byte of `languages` is a priority.
        for alias in (entry.languages[1:].decode(), entry.name.decode(), identifier, identifier.split("/")[-1]):
            languages.setdefault(alias.lower(), identifier)
        index += 1
    directory = Path(espeakng_loader.get_data_path()) / "voices" / _VARIANT_DIRECTORY
    return languages, {path.name.lower(): path.name for path in directory.iterdir()}
