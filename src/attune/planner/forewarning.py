"""Waits with a movement until the person has been told of it: as long as their manner asks for, and no longer."""

import anyio

from attune.core.bus import MANNER, REPLY, VOICE_STATUS, Bus
from attune.core.clock import Clock
from attune.core.messages import Reply, VoiceStatus

TIME_TO_ANNOUNCE = 0.1
"""Within this time of the state that tells of a movement its announcement comes, if there is one [s]."""


class Forewarning:
    """Knows which announcements are still to be said. Where nobody asks for warning, or no voice speaks, nothing waits.

    Args:
        bus: Announcements are the replies of urgency `background`; the voice tells when they are over.
        clock: Time.
    """

    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self._unsaid: set[str] = set()
        self._has_voice = False
        self._changed = anyio.Event()
        bus.on(REPLY, self._announced)
        bus.on(VOICE_STATUS, self._voice)

    async def given(self) -> None:
        """Wait until all that was announced has been said, no longer than `Manner.warn_before_movement`."""
        manner = self._bus.latest(MANNER)
        if manner is None or not manner.warn_before_movement:
            return
        with anyio.move_on_after(manner.warn_before_movement):
            await self._clock.sleep(TIME_TO_ANNOUNCE)
            while self._unsaid and self._has_voice:
                self._changed = anyio.Event()
                await self._changed.wait()
        self._unsaid.clear()  # What was not said in time holds up one movement only.

    def _announced(self, reply: Reply) -> None:
        if reply.urgency == "background":
            self._unsaid.add(reply.id)

    def _voice(self, status: VoiceStatus) -> None:
        self._has_voice = True
        if status.over:
            self._unsaid.discard(status.reply)
            self._changed.set()
