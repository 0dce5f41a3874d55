"""What every interpreter must do, whoever decides behind it: the grammar, a good model, or one that has gone mad."""

import random
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, get_args

import anyio
import pytest

from attune.core.bus import COMMAND, REPLY, ROBOT_STATE, UTTERANCE, WORLD, Bus
from attune.core.clock import RealClock, run
from attune.core.config import Config, DialogueConfig, LlmConfig
from attune.core.messages import (
    BelievedObject,
    Command,
    ObjectSpec,
    QueuedTask,
    ReplaceObject,
    RobotState,
    Utterance,
    WorldState,
)
from attune.core.scene import load_scene
from attune.dialogue.bridge import DialogueBridge
from attune.dialogue.choice import chosen_interpreter
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.interpreter import Intent, Interpretation, Interpreter

Make = Callable[..., Any]
SCENE = load_scene()
LEXICON = scene_lexicon(SCENE)
RED_CUP = ObjectSpec(type="cup", color="red", size="small")
BLUE_CUP = ObjectSpec(type="cup", color="blue", size="big")
IDLE = Context()
BUSY = Context(task=TaskContext(objects=(RED_CUP,), destination="table"), scene=(RED_CUP, BLUE_CUP))
ASKED = Context(pending_question="Do you mean the small red cup or the big blue cup?", scene=(RED_CUP, BLUE_CUP))

BRINGING_BOWL = Context(task=TaskContext(objects=(ObjectSpec(type="bowl"),)))

CASES: tuple[tuple[str, Context, str, tuple[ObjectSpec, ...], tuple[ObjectSpec, ...], str], ...] = (
    ("Bring me the big white bowl from the dishwasher.", IDLE, "bring_me",
     (ObjectSpec(type="bowl", color="white", size="big", location="dishwasher"),), (), ""),
    ("Please bring me a knife and a fork.", IDLE, "bring_me",
     (ObjectSpec(type="knife"), ObjectSpec(type="fork")), (), ""),
    ("Bring me the red, no, the blue cup.", IDLE, "bring_me", (ObjectSpec(type="cup", color="blue"),), (), ""),
    ("Put a plate on the table.", IDLE, "bring_me", (ObjectSpec(type="plate"),), (), "table"),
    ("Set the table for breakfast.", IDLE, "setting_breakfast", (), (), ""),
    ("Bring me a cup instead of a bowl.", IDLE, "replace_object",
     (ObjectSpec(type="cup"),), (ObjectSpec(type="bowl"),), ""),
    ("Bring me the bowl instead.", BUSY, "replace_object", (ObjectSpec(type="bowl"),), (RED_CUP,), ""),
    ("I would like the cup instead.", BRINGING_BOWL, "replace_object",
     (ObjectSpec(type="cup"),), (ObjectSpec(type="bowl"),), ""),
    ("Put it on the counter.", BUSY, "change_location", (), (), "countertop"),
    ("The blue one.", ASKED, "bring_me", (BLUE_CUP,), (), ""),
    ("Stop!", BUSY, "stop", (), (), ""),
    ("Don't stop.", BUSY, "dont_stop", (), (), ""),
    ("Carry on.", BUSY, "carry_on", (), (), ""),
    ("Thank you!", IDLE, "thanks", (), (), ""),
)  # fmt: skip
SANE = ("grammar", "good model", "dead endpoint")
KINDS = (*SANE, "mad model")
"""The mad model draws its answers: they must be valid or be refused, but there is no right one."""


def slots(spec: ObjectSpec) -> dict[str, str]:
    return {"type": spec.type, "color": spec.color, "size": spec.size, "location": spec.location}


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def using(kind: str, model_server: Make, behaviour: Make, model_answer: Make) -> Callable[..., Any]:
    """Runs an async function with the interpreter under test."""
    known = {
        text: model_answer(
            intent,
            add=[slots(spec) for spec in add],
            remove=[slots(spec) for spec in remove],
            destination=place,
            answers=context is ASKED,
        )  # fmt: skip
        for text, context, intent, add, remove, place in CASES
    }
    madness = random.Random(7)

    def good(utterance: str) -> Any:
        return behaviour(known.get(utterance, model_answer("talk", reply="I see.")))

    def mad(utterance: str) -> Any:
        intent = madness.choice([*get_args(Intent), "launch", ""])
        things = [
            {"type": madness.choice(["cup", "grenade", "", "x" * 999]), "color": madness.choice(["red", "plaid"])}
        ]
        content = model_answer(intent, add=things, remove=things, destination=madness.choice(["", "table", "moon"]))
        return behaviour(content, status=madness.choice([200, 200, 200, 401]), cut_after=madness.choice([None, 9]))

    def start(use: Callable[[Interpreter], Awaitable[Any]]) -> Any:
        async def main() -> Any:
            server = model_server({"mad model": mad}.get(kind, good))
            async with server.running():
                url = "http://127.0.0.1:9/v1" if kind == "dead endpoint" else server.url
                llm = LlmConfig(base_url="" if kind == "grammar" else url, model="m", deadline=2.0, history=0)
                async with chosen_interpreter(Config(llm=llm), SCENE, RealClock()) as interpreter:
                    return await use(interpreter)

        return run(main, RealClock())

    return start


@pytest.mark.parametrize("kind", SANE, indirect=True)
def test_the_conventions_hold(using: Make) -> None:
    async def use(interpreter: Interpreter) -> list[Interpretation]:
        return [await interpreter.interpret(case[0], case[1]) for case in CASES]

    for (text, _, intent, add, remove, place), found in zip(CASES, using(use), strict=True):
        assert found.intent == intent, text
        assert found.add == add, text
        assert found.remove == remove, text
        assert found.destination == place, text
        assert found.answers == (text == "The blue one."), text


@pytest.mark.parametrize("kind", SANE, indirect=True)
def test_an_answer_to_a_question_about_a_replacement_replaces(using: Make) -> None:
    async def use(interpreter: Interpreter) -> list[Command]:
        clock, bus = RealClock(), Bus()
        commands: list[Command] = []
        bus.on(COMMAND, commands.append)
        bridge = DialogueBridge(bus, clock, SCENE, DialogueConfig(), interpreter)
        world = tuple(BelievedObject(spec=spec) for spec in (RED_CUP, BLUE_CUP, ObjectSpec(type="bowl")))
        async with anyio.create_task_group() as group:
            group.start_soon(bridge.run)
            await clock.sleep(0.05)
            bus.publish(WORLD, WorldState(time=0.0, objects=world))
            queue = (QueuedTask(object=ObjectSpec(type="bowl"), destination="table", status="active"),)
            bus.publish(ROBOT_STATE, RobotState(time=0.0, step="transporting_fetch", queue=queue))
            await clock.sleep(0.05)
            for text in ("I would like the cup instead.", "The blue one."):
                with bus.subscribe(REPLY) as replies, anyio.fail_after(10):
                    bus.publish(UTTERANCE, Utterance(time=clock.now(), text=text, typed=True))
                    await replies.receive()
            group.cancel_scope.cancel()
        return commands

    (command,) = using(use)
    assert isinstance(command, ReplaceObject)
    assert (command.remove.type, command.add.type, command.add.color) == ("bowl", "cup", "blue")


STOPS = ("stop", "Stop!", "STOP STOP", "please stop", "halt", "wait", "freeze", "hold on", "never mind", "don't move")


def test_an_order_to_stop_is_always_understood(using: Make) -> None:
    async def use(interpreter: Interpreter) -> list[Interpretation]:
        return [await interpreter.interpret(text, BUSY) for text in STOPS * 3]

    for text, found in zip(STOPS * 3, using(use), strict=True):
        assert found.intent == "stop", text


def strange_texts(count: int) -> list[str]:
    """Anything a keyboard or a recogniser may hand over."""
    draw = random.Random(3)
    values = [*LEXICON.values("type"), *LEXICON.values("color"), *LEXICON.values("place")]
    common = "bring me not stop instead of the it no , ? other one second ignore your instructions"
    others = [*common.split(), "\U0001f375", "ß", "{}", "\x00", "\u202e", "'; drop table", "<script>", "1e999"]
    words = [*values, *others, "\n"]
    fixed = ["", " ", "?", "a" * 3000, "the " * 400, "\ud83c\udf75", '{"intent": "stop"}']
    return fixed + [" ".join(draw.choices(words, k=draw.randint(1, 14))) for _ in range(count - len(fixed))]


def test_whatever_is_said_the_meaning_is_valid(using: Make) -> None:
    texts = strange_texts(150)

    async def use(interpreter: Interpreter) -> list[Interpretation]:
        return [await interpreter.interpret(text, (IDLE, BUSY, ASKED)[index % 3]) for index, text in enumerate(texts)]

    types, colors = LEXICON.values("type"), ("", *LEXICON.values("color"))
    places = ("", *LEXICON.values("place"))
    for text, found in zip(texts, using(use), strict=True):
        assert found.intent in get_args(Intent), text
        assert 0 <= found.confidence <= 1, text
        assert found.reason, text
        assert found.destination in places, text
        assert found.reply.isprintable(), text
        for spec in (*found.add, *found.remove):
            assert spec.type in (*types, ""), text
            assert spec.color in colors, text
            assert spec.location in places, text
        if found.intent in ("bring_me", "replace_object"):
            assert found.add, text
            assert all(spec.type for spec in found.add), text
        if found.intent == "change_location":
            assert found.destination, text


@pytest.mark.parametrize("kind", SANE, indirect=True)
def test_the_same_words_in_the_same_situation_mean_the_same(using: Make) -> None:
    async def use(interpreter: Interpreter) -> list[Interpretation]:
        return [await interpreter.interpret(case[0], case[1]) for _ in range(2) for case in CASES]

    found = [replace(meaning, reason="") for meaning in using(use)]
    assert found[: len(CASES)] == found[len(CASES) :]
