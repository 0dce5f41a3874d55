"""Says things in the person's style, and takes back what is overtaken before it was spoken."""

from attune.core.bus import MANNER, REPLY, RETRACTION, Bus
from attune.core.clock import Clock
from attune.core.messages import Band, Manner, Reply, Retraction, Urgency, VoiceStatus
from attune.dialogue.interpreter import StyleWish
from attune.dialogue.policies import Policies, Policy, Preferences
from attune.dialogue.replies import Phrasebook

_KEPT = 8
_BY_DEGREES: frozenset[StyleWish] = frozenset({"slower", "faster", "louder", "quieter"})


class Speaker:
    """The robot's voice as text.

    Args:
        bus: Where replies go.
        clock: The session's clock.
        policies: How to talk to whom.
        phrasebook: The sentences.
    """

    def __init__(self, bus: Bus, clock: Clock, policies: Policies, phrasebook: Phrasebook) -> None:
        self._bus = bus
        self._clock = clock
        self._policies = policies
        self._phrasebook = phrasebook
        self._preferences = Preferences()
        self._estimated: Band = "unknown"
        self._unspoken: dict[str, Urgency] = {}
        self.last = ""
        self._tell_manner()

    @property
    def preferences(self) -> Preferences:
        """What the person has wished for."""
        return self._preferences

    @preferences.setter
    def preferences(self, preferences: Preferences) -> None:
        self._preferences = preferences
        self._tell_manner()

    @property
    def band(self) -> Band:
        """The person's age band: as stated, else as estimated last."""
        return self.preferences.band if self.preferences.band != "unknown" else self._estimated

    @property
    def policy(self) -> Policy:
        """How to talk to this person now."""
        return self.preferences.applied(self._policies, self._estimated)

    def wish(self, wish: StyleWish, cause: str) -> bool:
        """Follow a wish from now on.

        Args:
            wish: How to speak.
            cause: Id of the utterance.

        Returns:
            False if it cannot be done any more than it is already.
        """
        before = self.policy
        wished = self._preferences.wish(wish)
        after = wished.applied(self._policies, self._estimated)
        if wish in _BY_DEGREES and (before.rate, before.loudness) == (after.rate, after.loudness):
            return False
        self.preferences = wished
        if after.announce == "results":
            self.take_back_announcements(cause)
        return True

    def forget(self) -> None:
        """Speak as to somebody of whom nothing is known."""
        self._estimated = "unknown"
        self.preferences = Preferences()

    def hear_age(self, band: Band) -> None:
        """Somebody of this age band spoke. An unknown band changes nothing, so that the style does not flip."""
        if band != "unknown":
            self._estimated = band
            self._tell_manner()

    def say(
        self,
        group: str,
        situation: str,
        *,
        cause: str = "",
        urgency: Urgency = "normal",
        repeated: str = "",
        **slots: str,
    ) -> Reply:
        """Say a sentence for a situation, in the wording that the policy asks for.

        An announcement takes back earlier ones that were not spoken yet; something urgent takes back everything.

        Args:
            group: Group of situations in the file of replies.
            situation: Which one.
            cause: Id of the message that it answers.
            urgency: See `Reply`.
            repeated: Say this text instead.
            slots: Words for the sentence.
        """
        policy = self.policy
        text = repeated or self._phrasebook.say(group, situation, policy.wording, **slots)
        now = self._clock.now()
        overtaken = tuple(
            id_ for id_, waiting in self._unspoken.items()
            if urgency == "urgent" or (urgency == waiting == "background")
        )  # fmt: skip
        reply = Reply(
            time=now,
            cause=cause,
            text=text,
            style=self.band,
            urgency=urgency,
            supersedes=overtaken,
            rate=policy.rate,
            loudness=policy.loudness,
        )
        for id_ in overtaken:
            del self._unspoken[id_]
        self._unspoken[reply.id] = urgency
        while len(self._unspoken) > _KEPT:
            del self._unspoken[next(iter(self._unspoken))]
        self.last = text
        self._bus.publish(REPLY, reply)
        return reply

    def word(self, group: str, situation: str, **slots: str) -> str:
        """The sentence for a situation, to be said as part of another."""
        return self._phrasebook.say(group, situation, self.policy.wording, **slots)

    def take_back_announcements(self, cause: str) -> None:
        """What was announced is not true any more: it is not spoken, if it has not been begun.

        Args:
            cause: Id of the message that overtook it.
        """
        overtaken = tuple(id_ for id_, waiting in self._unspoken.items() if waiting == "background")
        if overtaken:
            self.take_back(overtaken, cause)

    def take_back(self, replies: tuple[str, ...], cause: str) -> None:
        """Let these replies not be spoken, as far as they have not been."""
        for reply in replies:
            self._unspoken.pop(reply, None)
        self._bus.publish(RETRACTION, Retraction(time=self._clock.now(), cause=cause, replies=replies))

    def knows(self, group: str, situation: str, *, exactly: bool = False) -> bool:
        """Whether there is a sentence for this (in the very wording of the policy)."""
        return self._phrasebook.has(group, situation, self.policy.wording if exactly else None)

    def spoken(self, status: VoiceStatus) -> None:
        """Follow what the voice has said."""
        if status.state != "word":
            self._unspoken.pop(status.reply, None)

    def _tell_manner(self) -> None:
        longest = self.policy.warn_before_movement if self.policy.announce == "everything" else 0.0
        known = self._bus.latest(MANNER)
        if known is None or known.warn_before_movement != longest:
            self._bus.publish(MANNER, Manner(time=self._clock.now(), warn_before_movement=longest))
