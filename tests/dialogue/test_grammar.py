"""The embedded interpreter on our own sentences: a tuned part, and a part written before the rules and left alone."""

import json
import time
from pathlib import Path

import pytest

from attune.cli.understanding import COMMANDS, LineContext
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.corpus import Sampler, domain_sentences, scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.interpreter import Interpretation

SENTENCES = [json.loads(line) for line in (Path(__file__).parent / "sentences.jsonl").read_text("utf-8").splitlines()]
EMBEDDED = GrammarInterpreter()


def read(text: str, **context: object) -> Interpretation:
    return EMBEDDED.read(text, LineContext.model_validate(context).context())


def outcome(meaning: Interpretation) -> dict[str, object]:
    known = meaning.intent in COMMANDS
    objects = {
        "add": meaning.add if known else (),
        "remove": meaning.remove if known else (),
    }
    plain = {
        key: [{name: getattr(spec, name) for name in ("type", "color", "size", "location")} for spec in specs]
        for key, specs in objects.items()
    }
    return {
        "command": meaning.intent if known else "other",
        **plain,
        "destination": meaning.destination if known else "",
    }


@pytest.mark.parametrize("line", [line for line in SENTENCES if line["part"] == "tuned"], ids=lambda line: line["id"])
def test_a_sentence_of_the_tuned_part_is_understood_whole(line: dict[str, dict[str, object]]) -> None:
    assert outcome(read(str(line["utterance"]), **line["context"])) == line["expect"]


def test_at_least_95_percent_of_the_held_out_commands_are_right_and_no_stop_is_missed() -> None:
    held_out = [line for line in SENTENCES if line["part"] == "held_out"]
    got = [outcome(read(line["utterance"], **line["context"]))["command"] for line in held_out]
    wrong = [
        (line["utterance"], command)
        for line, command in zip(held_out, got, strict=True)
        if command != line["expect"]["command"]
    ]
    assert len(wrong) <= 0.05 * len(held_out), wrong
    assert not [text for text, command in wrong if command != "stop" and "stop" in text.lower().split()]


def test_the_sampled_language_of_the_recogniser_is_understood_by_the_interpreter() -> None:
    lexicon = scene_lexicon(load_scene())
    sampler, interpreter = Sampler(lexicon, seed=11), GrammarInterpreter(lexicon)
    cup = TaskContext(objects=(ObjectSpec(type="cup", color="red"),))
    for intent in ("setting_breakfast", "stop", "carry_on", "put_back", "cancel_object", "style", "status"):
        sentences = [sampler.sentence(intent) for _ in range(60)]
        readings = [interpreter.read(text, Context(task=cup)).intent for text in sentences]
        right = {"style": {"style", "repeat", "stated_age"}}.get(intent, {intent})
        assert [text for text, got in zip(sentences, readings, strict=True) if got not in right] == []


def test_sampling_is_reproducible_and_has_every_type_and_place() -> None:
    sentences = domain_sentences(load_scene(), count=1500, seed=4)
    assert sentences == domain_sentences(load_scene(), count=1500, seed=4)
    assert len(sentences) == 1500
    words = {word for sentence in sentences for word in sentence.split()}
    assert {
        "milk",
        "bowl",
        "cereal",
        "spoon",
        "cup",
        "plate",
        "bread",
        "knife",
        "fork",
        "glass",
        "juice",
        "mug",
    } <= words
    assert {"countertop", "table", "cabinet", "dishwasher", "drawer", "fridge", "shelf"} <= words
    assert all(sentence == sentence.lower() and not set(sentence) & set(".,!?<>|()") for sentence in sentences)


def test_things_of_a_lines_scene_are_words_of_that_line_only() -> None:
    scene = [{"type": "hair_dryer", "color": "turquoise", "size": "", "location": "wardrobe"}]
    meaning = read("bring me the turquoise hair dryer from the wardrobe", scene=scene)
    assert meaning.add == (ObjectSpec(type="hair_dryer", color="turquoise", location="wardrobe"),)
    assert read("bring me the turquoise hair dryer").intent == "unknown_object"


def test_an_answer_takes_all_that_the_question_gave_the_option() -> None:
    question = "The big red cup from the shelf or the small blue one from the table?"
    assert read("the blue one", pending_question=question).add == (
        ObjectSpec(type="cup", color="blue", size="small", location="table"),
    )


@pytest.mark.parametrize("offer", ["Do you want milk as well?", "Would you like some milk?"])
@pytest.mark.parametrize("answer", ["No milk, thanks.", "I'm fine without milk", "no, I've got milk already"])
def test_what_is_offered_is_refused_by_its_name(offer: str, answer: str) -> None:
    assert read(answer, pending_question=offer, last_robot_utterance=offer).intent == "deny"


@pytest.mark.parametrize(
    "text", ["Stop it, Tobi, that tickles!", "stop it jamie that hurts", "Wait, Ruby, I'm coming too"]
)
def test_a_stop_that_names_somebody_else_is_not_for_the_robot(text: str) -> None:
    assert read(text).intent == "talk"
    task = {"command": "bring_me", "objects": [{"type": "cup"}]}
    assert read(text, task=task).intent == "talk"
    assert read(text.split(maxsplit=1)[0], task=task).intent == "stop"
    assert read(f"{text.split(maxsplit=1)[0].strip(',')}, robot!", task=task).intent == "stop"


@pytest.mark.parametrize(
    "text", ["Stooop!", "nvm", "could you wait a little, my mother is walking past", "pause that till I'm back"]
)
def test_a_stop_is_understood_at_work_and_idle(text: str) -> None:
    assert read(text).intent == "stop"
    assert read(text, task={"command": "bring_me", "objects": [{"type": "cup"}]}).intent == "stop"


def test_who_has_one_already_wants_no_other() -> None:
    task = {"command": "bring_me", "objects": [{"type": "spoon"}]}
    meaning = read("never mind the spoon, I've already got one", task=task)
    assert (meaning.intent, meaning.remove, meaning.add) == ("cancel_object", (ObjectSpec(type="spoon"),), ())


def test_a_little_at_the_end_is_no_size() -> None:
    task = {"command": "bring_me", "objects": [{"type": "fork"}]}
    assert read("slow down a little", task=task).style == "slower"
    assert read("the big cup and a little plate").add[1].size == "small"


@pytest.mark.parametrize("text", ["Just get me the damn fork!", "gonna bring me the fork?"])
def test_a_small_word_before_an_order_calls_nobody(text: str) -> None:
    assert read(text).add == (ObjectSpec(type="fork"),)


@pytest.mark.parametrize(
    "text", ["Hey Google, cancel my alarm", "Omg Chloe stop, I'm dying", "Stop whisking, it's ready"]
)
def test_another_machine_or_person_is_told_to_stop(text: str) -> None:
    assert read(text, task={"command": "bring_me", "objects": [{"type": "cup"}]}).intent == "talk"


def test_who_else_was_spoken_of_does_not_hide_a_stop() -> None:
    task = {"command": "bring_me", "objects": [{"type": "cup"}]}
    assert read("cut it out, you guys", task=task).intent == "talk"
    assert read("these spoons are for you guys please stop", task=task).intent == "stop"
    assert read("robot, wait, Mum is on the phone", task=task).intent == "stop"


def test_internal_intents_are_told_apart() -> None:
    assert read("put it back please").intent == "put_back"
    assert read("forget the spoon").intent == "cancel_object"
    assert read("carry on").intent == "carry_on"
    assert read("please speak a bit slower").style == "slower"
    assert read("you don't have to tell me everything").style == "less"
    assert read("I am 78 years old").age == 78
    assert read("I'm in my seventies").age == 70
    assert read("can you speak more slowly").style == "slower"
    assert read("talk normally again").style == "normal"
    assert read("what are you doing?").status == "doing"
    assert read("could you repeat that").intent == "repeat"


@pytest.mark.parametrize(
    "text", ["", "   ", "?!", "ÄÖ 漢字 🙂", "a " * 400, "no, " * 200, "bring " * 100, "\x00\x01", "the red " * 50]
)
def test_no_text_makes_the_interpreter_fail_or_slow(text: str) -> None:
    began = time.process_time()
    assert read(text, pending_question=text, last_robot_utterance=text).intent not in {"stop", "setting_breakfast"}
    assert time.process_time() - began < 2.0
