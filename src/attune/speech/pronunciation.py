"""How words sound, in the phones of the acoustic model: its own dictionary first, espeak-ng's rules for the rest."""

import ctypes
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from attune.core.errors import AttuneError
from attune.core.espeak import exclusive_library, select_voice

_IPA, _UTF8 = 2, 1
_PHONES: Mapping[str, str] = {
    "aɪ": "AY", "aʊ": "AW", "eɪ": "EY", "oʊ": "OW", "əʊ": "OW", "ɔɪ": "OY", "tʃ": "CH", "dʒ": "JH", "ɜː": "ER",
    "ɑː": "AA", "ɔː": "AO", "oː": "AO", "iː": "IY", "uː": "UW", "ɑ": "AA", "ɒ": "AA", "a": "AE", "æ": "AE", "ʌ": "AH",
    "ə": "AH", "ɐ": "AH", "ɔ": "AO", "o": "OW", "e": "EY", "ɛ": "EH", "ɜ": "ER", "ɚ": "ER", "ɝ": "ER", "ɪ": "IH",
    "ᵻ": "IH", "i": "IY", "ʊ": "UH", "u": "UW", "b": "B", "d": "D", "ð": "DH", "f": "F", "ɡ": "G", "g": "G", "h": "HH",
    "x": "K", "k": "K", "l": "L", "ɫ": "L", "m": "M", "n": "N", "ŋ": "NG", "p": "P", "ɹ": "R", "r": "R", "s": "S",
    "ʃ": "SH", "t": "T", "ɾ": "T", "ʔ": "T", "θ": "TH", "v": "V", "w": "W", "j": "Y", "z": "Z", "ʒ": "ZH",
    "ç": "SH", "y": "UW", "ø": "ER", "œ": "ER",
}  # fmt: skip
_LONGEST = max(len(ipa) for ipa in _PHONES)


class UnpronounceableWordError(AttuneError):
    """A word has no pronunciation, so it could never be recognised."""

    def __init__(self, words: Iterable[str]) -> None:
        names = ", ".join(repr(word) for word in words)
        super().__init__(f"the recogniser cannot learn {names}", "Spell the word in letters, as it is spoken")


def pronounce(words: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Pronunciations of each word, such as `{"cup": ("K AH P",)}`.

    Raises:
        UnpronounceableWordError: Neither the dictionary nor the rules know a word (`42`, `#`): nothing is dropped.
    """
    known = _dictionary()
    found = {word: known.get(word) or _by_rule(word) for word in words}
    if silent := [word for word, pronunciations in found.items() if not pronunciations]:
        raise UnpronounceableWordError(silent)
    return found


def dictionary_text(pronunciations: Mapping[str, tuple[str, ...]]) -> str:
    """The file that the recogniser reads: one line per pronunciation, `cup`, `cup(2)`."""
    lines = [
        f"{word}{f'({index})' if index > 1 else ''} {phones}"
        for word, variants in sorted(pronunciations.items())
        for index, phones in enumerate(variants, 1)
    ]
    return "\n".join([*lines, ""])


def _by_rule(word: str) -> tuple[str, ...]:
    if not any(letter.isalpha() for letter in word) or any(letter.isspace() for letter in word):
        return ()
    phones = " ".join(_phones(_ipa(word)))
    return (phones,) if phones else ()


def _ipa(word: str) -> str:
    # The call moves the pointer to behind what it has read.
    text = ctypes.c_char_p(word.encode())
    rest = ctypes.cast(text, ctypes.c_void_p)
    with exclusive_library() as library:
        select_voice(library, "en-us")
        return str(library.espeak_TextToPhonemes(ctypes.byref(rest), _UTF8, _IPA).decode())


def _phones(ipa: str) -> Iterator[str]:
    index = 0
    while index < len(ipa):
        for length in range(_LONGEST, 0, -1):
            if phone := _PHONES.get(ipa[index : index + length]):
                yield phone
                index += length
                break
        else:
            # Stress and length marks.
            index += 1


@cache
def _dictionary() -> dict[str, tuple[str, ...]]:
    import pocketsphinx

    found: defaultdict[str, list[str]] = defaultdict(list)
    path = Path(pocketsphinx.get_model_path()) / "en-us" / "cmudict-en-us.dict"
    for line in path.read_text(encoding="utf-8").splitlines():
        word, _, phones = line.partition(" ")
        found[word.split("(")[0]].append(phones.strip())
    return {word: tuple(variants) for word, variants in found.items()}
