"""Remembering a person's wishes from one talk to the next, if they say so, and forgetting them when they say so."""

import re
from typing import Literal

from attune.core.messages import Band
from attune.dialogue.profiles import SELF, ProfileStore
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import listed

Situation = Literal["", "remember", "forget", "nothing_to_forget", "known", "nothing_known", "no_memory"]
"""What there is to say, as the file of replies calls it; "" if it was not about remembering."""

_ME = (
    r"(?:me|who i am|(?:all |everything )?(?:that )?(?:what )?(?:you know )?about me|"
    r"my (?:profile|data|preferences|wishes|voice)|(?:what|how) i (?:like|want|prefer)(?: (?:it|things|"
    r"you to talk))?)"
)
_POLITE = (
    r"(?:(?:robot|please|okay|and|now|can you|could you|would you|will you|i want you to|i would like you to),? ?)*"
)
_END = r"(?: please| now| for (?:the )?next time| from now on| again)*"
_REMEMBER = re.compile(rf"{_POLITE}(?:remember|keep|save|store) {_ME}{_END}")
_FORGET = re.compile(
    rf"{_POLITE}(?:forget|erase|delete|remove|do not remember|don't remember|stop remembering) {_ME}{_END}"
)


_KNOWN = re.compile(
    rf"{_POLITE}(?:what do you (?:know|remember|have|keep)|what have you (?:kept|stored|saved|remembered)|"
    rf"tell me what you (?:know|remember)|what is (?:kept|stored|saved)|do you (?:know|remember) (?:any|some)thing)"
    rf"(?: stored| saved)? (?:about|of) me{_END}"
)


def memory_wish(text: str) -> Literal["", "remember", "forget", "known"]:
    """Whether somebody asks to be remembered or forgotten, or what is remembered."""
    plain = " ".join(re.sub(r"[^\w' ]", " ", text.lower()).split())
    if _FORGET.fullmatch(plain):
        return "forget"
    if _KNOWN.fullmatch(plain):
        return "known"
    return "remember" if _REMEMBER.fullmatch(plain) else ""


class Memory:
    """What the dialogue keeps of a person.

    Args:
        store: Where it is kept; None keeps nothing.
        speaker: Its preferences are what is kept; they are set from the profile at the beginning.
        person: Whose profile.

    Raises:
        AttuneError: The profiles cannot be read.
    """

    def __init__(self, store: ProfileStore | None, speaker: Speaker, person: str = SELF) -> None:
        self._store = store
        self._speaker = speaker
        self._person = person
        self._band: Band = "unknown"
        profile = store.get(person) if store else None
        self._consented = profile is not None
        if profile is not None:
            speaker.preferences = profile.preferences
            speaker.hear_age(profile.band)
            self._band = profile.band

    def answer(self, text: str) -> Situation:
        """Do what is asked about remembering, if something is."""
        wish = memory_wish(text)
        if not wish:
            return ""
        if self._store is None:
            return "no_memory"
        if wish == "known":
            return "known" if self._consented else "nothing_known"
        if wish == "forget":
            self._consented = False
            self._band = "unknown"
            self._speaker.forget()
            return "forget" if self._store.erase(self._person) else "nothing_to_forget"
        self._store.consent(self._person)
        self._consented = True
        self._store.keep(self._person, self._speaker.preferences, self._band)
        return "remember"

    @property
    def kept(self) -> str:
        """What is remembered about the person, as the object of "I remember"."""
        wishes = self._speaker.preferences
        degrees = (("slower", "faster", wishes.rate_steps), ("louder", "quieter", -wishes.loudness_steps))
        spoken = [less if steps < 0 else more for less, more, steps in degrees if steps]
        told = {"results": "to be told little", "everything": "to be told everything", "steps": "to be told each step"}
        band = wishes.band if wishes.band != "unknown" else self._band
        parts = [
            *([f"you want me to speak {listed(spoken)}"] if spoken else []),
            *([f"you like {told[wishes.announce]}"] if wishes.announce else []),
            *([f"you are one of the {band} people"] if band != "unknown" else []),
        ]
        return listed([f"that {part}" for part in parts]) if parts else "that I may remember you, and nothing else yet"

    def hear_age(self, band: Band) -> None:
        """Keep what the voice told about the person's age, when it told something new."""
        if band in ("unknown", self._band):
            return
        self._band = band
        if self._store is not None and self._consented:
            self._store.keep(self._person, band=band)

    def keep_wishes(self) -> None:
        """Keep the speaker's preferences as they are now, if the person agreed."""
        if self._store is not None and self._consented:
            self._store.keep(self._person, self._speaker.preferences)
