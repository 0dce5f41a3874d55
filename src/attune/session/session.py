"""The session: one robot in one kitchen, and whoever talks to it. Wires the modules together; decides nothing."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from attune.core import messages as m
from attune.core.bus import EVENT, ROBOT_STATE, ROBOT_STOP, SPEECH_STOP, UTTERANCE, Bus
from attune.core.clock import Clock
from attune.core.config import Config
from attune.core.events import Event
from attune.core.log import get_logger
from attune.core.scene import Scene, load_scene
from attune.dialogue.bridge import DialogueBridge
from attune.dialogue.choice import make_interpreter
from attune.dialogue.completeness import completeness, reads_as_stop
from attune.dialogue.corpus import domain_sentences
from attune.dialogue.llm import LlmInterpreter
from attune.dialogue.profiles import ProfileStore
from attune.planner.planner import Planner
from attune.robots.interface import Robot
from attune.speech.echo import make_cleaner
from attune.voice.voice import Voice

if TYPE_CHECKING:
    from attune.speech.audio import AudioSource
    from attune.speech.listener import Listener
    from attune.voice.playback import Output

RESTING: frozenset[m.Step] = frozenset({"idle", "task_done", "already_done", "stopped", "failed"})
"""Steps in which the robot waits for a person."""


class Session:
    """All modules, connected over one bus.

    Args:
        config: The configuration.
        clock: Real for people, virtual for tests and trials.
        audio: Where speech comes from; None for typed text only.
        loudspeaker: Where the robot's voice sounds; None opens what the configuration names.
        scene: The kitchen; None reads the one the configuration names.
        robot: The robot; None makes the one the configuration names.
        profiles: What is remembered about people who agreed to it; None remembers nothing.

    Raises:
        AttuneError: The scene, a model or a device is wrong or missing.
    """

    def __init__(
        self,
        config: Config,
        clock: Clock,
        *,
        audio: AudioSource | None = None,
        loudspeaker: Output | None = None,
        scene: Scene | None = None,
        robot: Robot | None = None,
        profiles: ProfileStore | None = None,
    ) -> None:
        self.config = config
        self.clock = clock
        self.bus = Bus()
        self.scene = scene or load_scene(Path(config.robot.scene) if config.robot.scene else None)
        self.robot = robot or make_robot(config, self.scene, clock)
        self.planner = Planner(self.bus, clock, self.scene, self.robot, config.planner)
        self._interpreter = make_interpreter(config, self.scene, clock)
        self.dialogue = DialogueBridge(
            self.bus, clock, self.scene, config.dialogue, self._interpreter, profiles, config.speech.older_from
        )
        is_audible = loudspeaker is not None or config.voice.output == "speaker"
        self._cleaner = make_cleaner(config.speech, self_talk=is_audible) if audio is not None else None
        on_playback = self._cleaner.played if self._cleaner else None
        self.voice = Voice(self.bus, clock, config.voice, on_playback=on_playback, output=loudspeaker)
        self._audio = audio
        self.bus.on(SPEECH_STOP, self._forward_stop)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Run all modules while the block lasts. A module that fails ends the block with its error."""
        async with anyio.create_task_group() as group:
            group.start_soon(self.robot.run, name="robot")
            group.start_soon(self.planner.run, name="planner")
            group.start_soon(self.dialogue.run, name="dialogue")
            group.start_soon(self.voice.run, name="voice")
            await self._until_planner_is_up()
            if self._audio is not None:
                group.start_soon(self._listener(self._audio).run, name="listener")
            self._event("session_started", robot=self.config.robot.kind, hears=self._audio is not None)
            try:
                yield
            finally:
                self._event("session_ended")
                group.cancel_scope.cancel()
                if isinstance(self._interpreter, LlmInterpreter):
                    with anyio.CancelScope(shield=True):
                        await self._interpreter.close()

    def say(self, text: str, age: m.AgeEstimate = m.AgeEstimate()) -> m.Utterance:
        """Hear a typed utterance, as if it had been spoken clearly."""
        now = self.clock.now()
        utterance = m.Utterance(time=now, text=text, age=age, start=now, end=now, typed=True)
        self.bus.publish(UTTERANCE, utterance)
        return utterance

    def stop(self, source: str = "button") -> None:
        """Halt the robot at once and give up the plan."""
        self.robot.halt()
        self.bus.publish(ROBOT_STOP, m.StopSignal(time=self.clock.now(), state="confirmed", source=source))  # type: ignore[arg-type]

    async def settled(self, quiet: float = 1.0) -> m.RobotState:
        """Wait until the robot has had nothing to do for `quiet` seconds; returns its state."""
        with self.bus.subscribe(ROBOT_STATE) as states:
            state = await states.receive()
            while True:
                with anyio.move_on_after(quiet if state.step in RESTING else math.inf) as waiting:
                    state = await states.receive()
                if waiting.cancelled_caught:
                    return state

    def _listener(self, audio: AudioSource) -> Listener:
        from attune.speech.age.choice import make_age_estimator
        from attune.speech.listener import Listener

        speech = self.config.speech
        return Listener(
            self.bus,
            self.clock,
            audio,
            domain_sentences(self.scene),
            speech,
            age=make_age_estimator(speech.age, speech.older_from),
            is_complete=completeness(self.scene),
            is_stop=reads_as_stop(self.scene),
            band=lambda: self.dialogue.speaker.band,
            clean=self._cleaner.clean if self._cleaner else lambda frame: frame,
        )

    def _forward_stop(self, signal: m.StopSignal) -> None:
        self.bus.publish(ROBOT_STOP, signal)

    async def _until_planner_is_up(self) -> None:
        with self.bus.subscribe(ROBOT_STATE) as states:
            await states.receive()

    def _event(self, kind: str, **data: object) -> None:
        self.bus.publish(EVENT, Event(time=self.clock.now(), kind=kind, data=data))  # type: ignore[arg-type]
        get_logger("session").info(kind, **data)


def make_robot(config: Config, scene: Scene, clock: Clock) -> Robot:
    """The robot that the configuration names."""
    if config.robot.kind == "symbolic":
        from attune.robots.symbolic import SymbolicRobot

        return SymbolicRobot(scene, clock, seed=config.robot.seed)
    from attune.robots.mujoco.robot import MujocoRobot

    return MujocoRobot(scene, clock, config.robot)
