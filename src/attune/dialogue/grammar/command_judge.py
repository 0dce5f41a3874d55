"""What an utterance asks for, by a log-linear model of its words and a network of their meanings together."""

from functools import cache

import numpy as np

from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.command_model import COMMANDS, CommandModel, load_command_model
from attune.dialogue.grammar.command_network import CommandNetwork, load_command_network
from attune.dialogue.grammar.network_words import words_about, words_of
from attune.dialogue.interpreter import CommandIntent
from attune.dialogue.lexicon import Lexicon

_NETWORK = 0.8
"""How much the network's opinion counts beside the model's; chosen on authors whom neither had seen."""
_TINY = 1e-9


class CommandJudge:
    """Blends both opinions.

    Args:
        model: The log-linear one.
        network: The network.
    """

    def __init__(self, model: CommandModel, network: CommandNetwork) -> None:
        self._model = model
        self._network = network

    def judge(self, sentence: Sentence, context: Context, lexicon: Lexicon) -> dict[CommandIntent, float]:
        """The probability of each command."""
        judged = self._model.judge(sentence, context, lexicon)
        by_words = np.log(np.array([judged[command] for command in COMMANDS]) + _TINY)
        by_meaning = self._network.judge(words_of(sentence), words_about(context))
        likelihoods = np.exp(by_words + _NETWORK * by_meaning)
        return dict(zip(COMMANDS, (likelihoods / likelihoods.sum()).tolist(), strict=True))


@cache
def load_command_judge() -> CommandJudge:
    """The judge that comes with Attune."""
    return CommandJudge(load_command_model(), load_command_network())
