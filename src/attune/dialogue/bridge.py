"""The dialogue bridge: from utterances to commands for the robot, and from the robot's states to words."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import anyio

from attune.core.bus import (
    EVENT,
    REPLY,
    ROBOT_STATE,
    ROBOT_STOP,
    SPEECH_ACTIVITY,
    SPEECH_STOP,
    UTTERANCE,
    VOICE_STATUS,
    WORLD,
    Bus,
)
from attune.core.clock import Clock
from attune.core.codec import to_data
from attune.core.config import DialogueConfig
from attune.core.events import Event, EventKind
from attune.core.messages import (
    AgeGroup,
    Band,
    RobotState,
    SpeechActivity,
    StopSignal,
    Utterance,
    WorldState,
    years_of,
)
from attune.core.scene import Scene
from attune.dialogue.commands import commands_for
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.filter import Filter
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.grounding import believed
from attune.dialogue.interpreter import Interpretation, Interpreter
from attune.dialogue.lexicon import load_lexicon
from attune.dialogue.llm import LlmInterpreter, describe_style
from attune.dialogue.memory import Memory
from attune.dialogue.narrator import Narrator
from attune.dialogue.policies import load_policies
from attune.dialogue.profiles import ProfileStore
from attune.dialogue.repair import Repairer
from attune.dialogue.replies import Phrasebook
from attune.dialogue.requests import Requests
from attune.dialogue.situation import Situation
from attune.dialogue.speaker import Speaker
from attune.dialogue.stopper import Stopper


@dataclass(slots=True)
class _Fragment:
    """An utterance that broke off and waits for its continuation."""

    utterance: Utterance
    reason: str
    scope: anyio.CancelScope


class DialogueBridge:
    """Listens to utterances and the robot; publishes commands and replies.

    Args:
        bus: The session's bus.
        clock: The session's clock.
        scene: The kitchen: vocabulary, and what is believed before the robot has told anything.
        config: Thresholds, times and files.
        interpreter: Who understands; None takes the embedded one.
        profiles: What is remembered about people, with their consent; None remembers nothing.
        older_from: The first age group that counts as older, for ages that people state.

    Raises:
        AttuneError: A file that the configuration names is wrong.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        scene: Scene,
        config: DialogueConfig,
        interpreter: Interpreter | None = None,
        profiles: ProfileStore | None = None,
        older_from: AgeGroup = "sixties",
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._config = config
        lexicon = scene_lexicon(scene, load_lexicon(Path(config.lexicon) if config.lexicon else None))
        self._embedded = GrammarInterpreter(lexicon)
        self._interpreter: Interpreter = interpreter or self._embedded
        if isinstance(interpreter, LlmInterpreter):
            interpreter.style = lambda: describe_style(self.speaker.policy)
        self._filter = Filter(config)
        self._repairer = Repairer(lexicon)
        self._stopper = Stopper(bus, clock)
        self._situation = Situation(scene, config.question_expires)
        policies = load_policies(Path(config.policies) if config.policies else None)
        phrasebook = Phrasebook(path=Path(config.replies) if config.replies else None)
        self.speaker = Speaker(bus, clock, policies, phrasebook)
        """How the robot speaks to the person; its preferences can be set from a profile."""
        self._memory = Memory(profiles, self.speaker)
        self._narrator = Narrator(self.speaker)
        self._requests = Requests(bus, clock, self.speaker, self._situation, self._narrator, self._embedded)
        self._scene = scene
        self._older_from = years_of(older_from)
        self._fragment: _Fragment | None = None
        self._speaking = False
        self._stopped: dict[str, bool] = {}
        self._stops = 0
        self._stops_before: dict[str, int] = {}
        self._group: anyio.abc.TaskGroup | None = None

    async def run(self) -> None:
        """Work until cancelled."""
        with (
            self._bus.subscribe(UTTERANCE) as utterances,
            self._bus.subscribe(ROBOT_STATE) as states,
        ):
            endings = [
                self._bus.on(UTTERANCE, self._stop_first),
                self._bus.on(SPEECH_STOP, self._spotted),
                self._bus.on(ROBOT_STOP, self._halted),
                self._bus.on(SPEECH_ACTIVITY, self._activity),
                self._bus.on(WORLD, self._world),
                self._bus.on(VOICE_STATUS, self.speaker.spoken),
                self._bus.on(REPLY, lambda reply: setattr(self._situation, "last_said", reply.text)),
            ]
            try:
                async with anyio.create_task_group() as group:
                    self._group = group
                    group.start_soon(self._each, utterances, self._heard, name="utterances")
                    group.start_soon(self._each, states, self._state, name="states")
                    group.start_soon(self._requests.run, name="requests")
            finally:
                self._group = None
                for end in endings:
                    end()

    @staticmethod
    async def _each(messages: Any, handle: Any) -> None:
        async for message in messages:
            await handle(message)

    # --- stopping: decided inside the publish, before any other work -------------------------------------------

    def _spotted(self, signal: StopSignal) -> None:
        self._stopper.spot(signal)
        if signal.state == "spotted" and self._group is not None:
            self._group.start_soon(self._take_back_later, signal, name="spotted stop")

    def _halted(self, signal: StopSignal) -> None:
        self._stops += signal.state == "confirmed"

    async def _take_back_later(self, signal: StopSignal) -> None:
        await self._clock.sleep(self._config.stop_waits_for_text)
        if self._stopper.spotted is signal:
            self._stopper.withdraw("no words confirmed it in time", signal.id)

    def _stop_first(self, utterance: Utterance) -> None:
        if not utterance.is_final:
            return
        self._stops_before[utterance.id] = self._stops
        if self._filter.hears_nothing(utterance):
            self._stopper.withdraw("it was no speech to the robot", utterance.id)
            return
        meaning = self._embedded.read(utterance.text, self._situation.context(self._clock.now()))
        if meaning.intent == "stop":
            self._stopped[utterance.id] = True
            self._stopper.confirm(utterance, self._band(utterance))
        else:
            self._stopper.withdraw("the sentence was no order to stop", utterance.id)

    # --- hearing -----------------------------------------------------------------------------------------------

    def _activity(self, activity: SpeechActivity) -> None:
        self._speaking = activity.speaking

    async def _heard(self, utterance: Utterance) -> None:
        if not utterance.is_final:
            return
        stops_before = self._stops_before.pop(utterance.id, self._stops)
        self._tell("heard", utterance, text=utterance.text, confidence=utterance.confidence, age=utterance.age.band)
        self.speaker.hear_age(utterance.age.band)
        self._memory.hear_age(utterance.age.band)
        if self._stopped.pop(utterance.id, False):
            self._take_fragment()
            self._tell("understood", utterance, "stop", intent="stop")
            self._requests.stop(utterance.id)
            return
        nothing = self._filter.hears_nothing(utterance)
        if nothing:
            self._tell("ignored", utterance, nothing)
            return
        about_memory = self._memory.answer(utterance.text)
        if about_memory:
            if isinstance(self._interpreter, LlmInterpreter):
                self._interpreter.forget()
            self._tell("understood", utterance, "about being remembered", intent=about_memory)
            self.speaker.say("talk", about_memory, cause=utterance.id, kept=self._memory.kept)
            return
        meaning = await self._understand(utterance)
        if stops_before != self._stops:
            # A language model takes its time: what was said before a stop must not move the robot after it.
            self._tell("ignored", utterance, "overtaken by a stop", intent=meaning.intent)
            return
        decision = self._filter.decide(utterance, meaning, expecting=self._situation.pending is not None)
        match decision.verdict:
            case "ignore":
                self._tell("ignored", utterance, decision.reason, intent=meaning.intent)
            case "wait":
                self._wait_for_more(utterance, decision.reason)
            case "ask":
                self._tell("ignored", utterance, f"asked back: {decision.reason}", intent=meaning.intent)
                self._requests.ask_back(utterance, meaning)
            case "act":
                self._act(utterance, meaning)

    async def _understand(self, utterance: Utterance) -> Interpretation:
        context = self._situation.context(self._clock.now())
        fragment = self._take_fragment()
        if fragment is not None:
            joined = f"{fragment.utterance.text.rstrip(' .…')} {utterance.text}"
            together = await self._interpreter.interpret(joined, context)
            if commands_for(together, context, now=0.0, cause="", band="unknown"):
                return replace(together, reason=f"continues what was begun: {together.reason}")
        meaning = await self._interpreter.interpret(utterance.text, context)
        return await self._repairer.repaired(meaning, utterance, context, self._embedded)

    def _wait_for_more(self, utterance: Utterance, reason: str) -> None:
        self._fragment = _Fragment(utterance, reason, anyio.CancelScope())
        if self._group is not None:
            self._group.start_soon(self._give_up_waiting, self._fragment, name="fragment")

    async def _give_up_waiting(self, fragment: _Fragment) -> None:
        with fragment.scope:
            await self._clock.sleep(self._config.fragment_wait)
            while self._speaking:
                await self._clock.sleep(0.2)
            self._fragment = None
            self._tell("ignored", fragment.utterance, f"{fragment.reason}, and nothing followed", intent="fragment")
            if fragment.utterance.typed or fragment.utterance.confidence >= self._config.confidence_ask:
                self._requests.ask_for_the_rest(fragment.utterance)

    def _take_fragment(self) -> _Fragment | None:
        fragment, self._fragment = self._fragment, None
        if fragment is not None:
            fragment.scope.cancel()
        return fragment

    # --- acting ------------------------------------------------------------------------------------------------

    def _act(self, utterance: Utterance, meaning: Interpretation) -> None:
        meaning = self._requests.answered(meaning, utterance.id)
        self._tell(
            "understood", utterance, meaning.reason, intent=meaning.intent, confidence=meaning.confidence,
            add=to_data_list(meaning.add), remove=to_data_list(meaning.remove), destination=meaning.destination,
        )  # fmt: skip
        match meaning.intent:
            case "style" if not self.speaker.wish(meaning.style, utterance.id):
                self.speaker.say("talk", "style_limit", cause=utterance.id, wish=meaning.style)
                return
            case "stated_age":
                self.speaker.preferences = replace(self.speaker.preferences, band=self._stated(meaning))
        if meaning.intent in {"style", "stated_age"}:
            self._memory.keep_wishes()
        self._requests.act(utterance, meaning, self._band(utterance))

    # --- the robot ---------------------------------------------------------------------------------------------

    def _world(self, world: WorldState) -> None:
        self._situation.known = believed(world.objects, self._scene)

    async def _state(self, state: RobotState) -> None:
        self._situation.state = state
        self._narrator.state(state)

    def _stated(self, meaning: Interpretation) -> Band:
        """The band of the age that the person stated."""
        if not meaning.age:
            return meaning.band
        return "older" if meaning.age >= self._older_from else "younger"

    def _band(self, utterance: Utterance) -> Band:
        return utterance.age.band if self.speaker.preferences.band == "unknown" else self.speaker.preferences.band

    def _tell(self, kind: EventKind, utterance: Utterance, reason: str = "", **data: Any) -> None:
        self._bus.publish(
            EVENT,
            Event(time=self._clock.now(), cause=utterance.id, kind=kind, text=reason, data={**data, "reason": reason}),
        )


def to_data_list(specs: Any) -> list[dict[str, str]]:
    """Objects as plain data, without what is not given."""
    return [{key: value for key, value in to_data(spec).items() if value} for spec in specs]
