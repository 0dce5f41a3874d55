"""Says things in the person's style, and takes back what is overtaken before it was spoken."""

from attune.core.bus import REPLY, Bus
from attune.core.clock import Clock
from attune.core.messages import Band, Reply, Urgency, VoiceStatus
from attune.dialogue.policies import Policies, Policy, Preferences
from attune.dialogue.replies import Phrasebook

_KEPT = 8
_ONE_BREATH = 0.1
"""Announcements that come within this time of each other belong together [s]."""


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
        self.preferences = Preferences()
        self._estimated: Band = "unknown"
        self._unspoken: dict[str, tuple[Urgency, float]] = {}
        self.last = ""

    @property
    def band(self) -> Band:
        """The person's age band: as stated, else as estimated last."""
        return self.preferences.band if self.preferences.band != "unknown" else self._estimated

    @property
    def policy(self) -> Policy:
        """How to talk to this person now."""
        return self.preferences.applied(self._policies, self._estimated)

    def hear_age(self, band: Band) -> None:
        """Somebody of this age band spoke. An unknown band changes nothing, so that the style does not flip."""
        if band != "unknown":
            self._estimated = band

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

        What is said takes back all announcements that were not spoken yet; something urgent takes back everything.

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
        # The next step and its first movement come in one breath: the second does not take back the first.
        together = now - _ONE_BREATH if urgency == "background" else now
        overtaken = tuple(
            id_ for id_, (waiting, said) in self._unspoken.items()
            if (waiting == "background" and said <= together) or urgency == "urgent"
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
        self._unspoken[reply.id] = (urgency, now)
        while len(self._unspoken) > _KEPT:
            del self._unspoken[next(iter(self._unspoken))]
        self.last = text
        self._bus.publish(REPLY, reply)
        return reply

    def knows(self, group: str, situation: str, *, exactly: bool = False) -> bool:
        """Whether there is a sentence for this (in the very wording of the policy)."""
        return self._phrasebook.has(group, situation, self.policy.wording if exactly else None)

    def spoken(self, status: VoiceStatus) -> None:
        """Follow what the voice has said."""
        if status.state != "word":
            self._unspoken.pop(status.reply, None)
