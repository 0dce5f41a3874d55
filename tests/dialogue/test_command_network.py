import math
from pathlib import Path

import numpy as np
import pytest

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.grammar.command_model import COMMANDS, load_command_model
from attune.dialogue.grammar.command_network import WIDTHS, CommandNetwork, encode, load_command_network, pieces
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.grammar.network_words import words_about, words_of

KNOWN = {"[UNK]": 0, "[SEP]": 1, "tea": 2, "##pot": 3, "##s": 4, "stop": 5, "idle": 6}


def test_an_unknown_word_is_read_in_the_longest_known_pieces() -> None:
    assert pieces("teapots", KNOWN) == ["tea", "##pot", "##s"]
    assert pieces("stop", KNOWN) == ["stop"]
    assert pieces("teacup", KNOWN) == ["[UNK]"]
    assert encode(["teapot", "stop"], ["idle"], KNOWN) == [2, 3, 5, 1, 6]


def test_a_long_utterance_leaves_room_for_the_situation() -> None:
    assert encode(["stop"] * 100, ["idle"] * 100, KNOWN) == [5] * 44 + [1] + [6] * 19


def test_the_network_reads_things_by_their_plain_names_and_says_the_situation() -> None:
    sentence, _ = GrammarInterpreter().sentence("Robot, could you bring the littler red beaker from the icebox?")
    assert words_of(sentence)[:5] == ["robot", ",", "could", "you", "bring"]
    task = TaskContext(objects=(ObjectSpec(type="cup", color="red"),), destination="table")
    assert words_about(Context(task=task, last_robot_utterance="I'm on my way.")) == (
        ["busy", "bring", "me", "red", "cup", "to", "table", "said", "i", "am", "on", "my", "way", "."]
    )
    assert words_about(Context()) == ["idle"]


def test_the_strongest_response_anywhere_in_the_sentence_decides() -> None:
    embeddings = np.array([[0], [0], [0], [0], [0], [100], [-100]], np.int8)
    filters = [(np.ones((width, 1), np.float32), np.zeros(1, np.float32)) for width in WIDTHS]
    head = np.zeros((len(WIDTHS), len(COMMANDS)), np.float32)
    head[0, COMMANDS.index("stop")] = 1.0
    network = CommandNetwork(
        KNOWN, embeddings, 0.01, np.zeros((2, 1), np.float32), filters, (head, np.zeros(len(COMMANDS), np.float32))
    )
    strength = math.exp(math.tanh(1.0))
    judged = np.exp(network.judge(["tea", "stop", "tea"], ["idle"]))
    assert judged[COMMANDS.index("stop")] == pytest.approx(strength / (strength + 5), rel=1e-4)
    assert np.exp(network.judge(["tea"], ["idle"])) == pytest.approx([1 / 6] * 6)


def test_a_network_that_was_written_and_read_judges_as_before(tmp_path: Path) -> None:
    network = load_command_network()
    network.save(tmp_path / "network.npz")
    words = ["would", "you", "be", "so", "kind", "as", "to", "hand", "me", "the", "saucer"]
    again = CommandNetwork.load(tmp_path / "network.npz")
    assert again.judge(words, ["idle"]) == pytest.approx(network.judge(words, ["idle"]))


def test_words_that_nobody_wrote_are_judged_by_what_they_mean() -> None:
    model, network = load_command_model(), load_command_network()
    for strange, words, meant in (
        ("procure", "procure the spoon", "bring_me"),
        ("refrain", "robot , refrain from moving", "stop"),
    ):
        assert not model.knows(strange)
        assert COMMANDS[int(network.judge(words.split(), ["idle"]).argmax())] == meant
