"""The robot's voice: speaks replies sentence by sentence, tells how far it got, and gives way to people."""

import math
import re
from pathlib import Path
from typing import Literal

import anyio

from attune.core.bus import EVENT, REPLY, RETRACTION, SPEECH_ACTIVITY, SPEECH_STOP, UTTERANCE, VOICE_STATUS, Bus
from attune.core.clock import Clock
from attune.core.config import VoiceConfig
from attune.core.errors import AttuneError
from attune.core.events import Event
from attune.core.messages import Reply, Retraction, SpeechActivity, StopSignal, Utterance, VoiceStatus
from attune.voice.playback import FileOutput, NoOutput, Output, PlaybackHook, Player, SpeakerOutput
from attune.voice.synthesis import Speech, Synthesis, Synthesiser

_SENTENCE_END = re.compile(r"(?<=[.!?])\s+")
_State = Literal["started", "word", "finished", "interrupted", "dropped"]
_THINKING_PAUSE = 1.0
"""Somebody who pauses without an utterance having been heard may go on within this time [s]."""


class Voice:
    """Speaks every reply on the bus.

    A person who speaks pauses the voice at once. If they go on for `config.barge_in` seconds, the rest is dropped;
    after a shorter sound ("uh-huh") the voice goes on from where it paused. A spotted stop silences it at once and
    drops what was still to be said. While somebody speaks, or pauses in the middle of a sentence, only urgent replies
    begin.

    Args:
        on_playback: Gets everything that sounds, as `(samples, rate, time)`, for echo cancellation.
        output: Where it sounds; None opens what the configuration names.

    Raises:
        UnknownVoiceError: The configured voice does not exist.
        PiperVoiceError: The configured voice of Piper cannot be used.
        MissingDependencyError: Piper is configured and not installed.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        config: VoiceConfig,
        *,
        on_playback: PlaybackHook | None = None,
        output: Output | None = None,
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._config = config
        self._on_playback = on_playback
        self._output = output
        self._synthesiser = _synthesiser(config)
        self._waiting: list[Reply] = []
        self._superseded = False
        self._speaking: Reply | None = None
        self._scope = anyio.CancelScope()
        self._changed = anyio.Event()
        self._person_since: float | None = None
        self._floor_free_at = 0.0

    async def run(self) -> None:
        """Speak until cancelled.

        Raises:
            OutputError: The configured file cannot be written.
        """
        output = self._output or self._open_output()
        self._player = Player(self._clock, output, self._on_playback)
        forget = [
            self._bus.on(REPLY, self._take),
            self._bus.on(RETRACTION, self._retract),
            self._bus.on(SPEECH_ACTIVITY, self._person_speaks),
            self._bus.on(SPEECH_STOP, self._stop),
            self._bus.on(UTTERANCE, self._person_has_finished),
        ]
        try:
            while True:
                await self._speak(await self._next())
        finally:
            for handler in forget:
                handler()
            output.close()

    def _open_output(self) -> Output:
        if self._config.output == "file":
            return FileOutput(Path(self._config.file), self._synthesiser.sample_rate)
        if self._config.output == "speaker":
            try:
                return SpeakerOutput(self._config.device, self._synthesiser.sample_rate)
            except AttuneError as error:
                text = f"The robot's words are not audible: {error}"
                self._bus.publish(EVENT, Event(time=self._clock.now(), kind="warning", text=text))
        return NoOutput()

    def _take(self, reply: Reply) -> None:
        announced = [r.id for r in self._waiting if r.urgency == "background"]
        # An answer comes before an announcement that waits, and does not make it untrue.
        self._drop({*reply.supersedes, *(announced if reply.urgency != "normal" else [])})
        if reply.urgency == "urgent":
            urgent = sum(r.urgency == "urgent" for r in self._waiting)
            self._waiting.insert(urgent, reply)
            if self._speaking and self._speaking.urgency != "urgent":
                self._scope.cancel()
        elif reply.urgency == "normal":
            self._waiting.insert(sum(r.urgency != "background" for r in self._waiting), reply)
        else:
            self._waiting.append(reply)
        self._changed.set()

    def _retract(self, retraction: Retraction) -> None:
        self._drop(set(retraction.replies))

    def _drop(self, ids: set[str]) -> None:
        for old in [r for r in self._waiting if r.id in ids]:
            self._waiting.remove(old)
            self._tell(old, "dropped", "")
        if self._speaking and self._speaking.id in ids:
            self._superseded = True

    def _person_speaks(self, activity: SpeechActivity) -> None:
        if not activity.speaking:
            self._person_since = None
            self._floor_free_at = self._clock.now() + _THINKING_PAUSE
        elif self._person_since is None:
            self._person_since = self._clock.now()
        self._player.paused = activity.speaking
        self._changed.set()

    def _person_has_finished(self, _utterance: Utterance) -> None:
        self._floor_free_at = self._clock.now()
        self._changed.set()

    def _stop(self, signal: StopSignal) -> None:
        if signal.state == "withdrawn":
            return
        for old in self._waiting:
            self._tell(old, "dropped", "")
        self._waiting.clear()
        self._scope.cancel()

    async def _next(self) -> Reply:
        while True:
            wait = self._floor_free_at - self._clock.now() if self._person_since is None else math.inf
            # Less than a microsecond is rounding: a timer cannot wait for so little.
            if self._waiting and (wait < 1e-6 or self._waiting[0].urgency == "urgent"):
                return self._waiting.pop(0)
            self._changed = anyio.Event()
            with anyio.move_on_after(wait if self._waiting else math.inf):
                await self._changed.wait()

    async def _speak(self, reply: Reply) -> None:
        began = self._clock.now()
        spoken = ""
        words = 0
        sentence: Speech

        def progress(position: float) -> None:
            nonlocal spoken, words
            heard = sum(word.time <= position for word in sentence.words)
            if heard > words:
                words = heard
                spoken = " ".join(filter(None, (before, sentence.spoken_until(position))))
                self._tell(reply, "word", spoken)
            since = self._person_since
            # Somebody who was speaking before an urgent reply began does not silence it.
            if since is not None and since >= began and self._clock.now() - since >= self._config.barge_in:
                self._scope.cancel()

        self._speaking = reply
        # Only somebody who begins now pauses it.
        self._player.paused = False
        finished = False
        try:
            with anyio.CancelScope() as self._scope:
                self._tell(reply, "started", "")
                before = ""
                for text in filter(None, _SENTENCE_END.split(reply.text.strip())):
                    if self._superseded:
                        break
                    sentence = await self._synthesise(text, reply)
                    words = 0
                    await self._player.play(sentence.samples, sentence.sample_rate, progress)
                    before = spoken = " ".join(filter(None, (before, text)))
                else:
                    finished = True
        finally:
            self._speaking = None
            self._superseded = False
            self._tell(reply, "finished" if finished else "interrupted", spoken)

    async def _synthesise(self, text: str, reply: Reply) -> Speech:
        voice = self._config.voice
        return await self._clock.run_in_thread(
            lambda: self._synthesiser.synthesise(text, voice=voice, rate_wpm=reply.rate, loudness=reply.loudness)
        )

    def _tell(self, reply: Reply, state: _State, spoken: str) -> None:
        status = VoiceStatus(time=self._clock.now(), cause=reply.id, reply=reply.id, state=state, spoken=spoken)
        self._bus.publish(VOICE_STATUS, status)


def _synthesiser(config: VoiceConfig) -> Synthesis:
    if config.engine == "piper":
        from attune.voice.piper import PiperSynthesiser

        return PiperSynthesiser(config.voice)
    synthesiser = Synthesiser()
    synthesiser.synthesise("", voice=config.voice)
    return synthesiser
