"""A small network that hears orders to stop, over Google's speech embedding; numpy only.

The sound becomes a mel spectrogram, each 40 ms of that an embedding of the last 0.8 s (convolutions trained on human
speech), and a head with a memory of 2 s tells from the embeddings what has just been said. The head was trained by
`scripts/stop_spotter`, on synthetic speech only. Where the weights come from: `attune/data/stop_network.txt`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from attune.speech.audio import SAMPLE_RATE, Samples

Array = NDArray[np.float32]
Weights = Mapping[str, Array]

FRAME, HOP = 512, 160
"""Of the spectrogram [samples]."""
BANDS = 32
STEP = 4
"""Spectrogram rows for each embedding."""
CONVOLUTIONS = 20
POOLED = {2: (2, 2), 6: (1, 2), 10: (2, 2), 14: (1, 2)}
"""After these convolutions: rows and bands of which the largest is kept."""
EVERY = 2
"""The step that the embedding was made for, in ours."""
DILATIONS = (2, 4, 8, 8)
"""Steps between the three taps of the head's layers."""
_WINDOW = 400
_LOWEST, _HIGHEST = 60.0, 3800.0
_LEAST_POWER = 1.0
"""Of 16-bit samples: what is softer is digital silence."""
_LEAK, _FLOOR = 0.2, -0.4


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the network makes of the sound so far; probabilities.

    Attributes:
        stop: "Stop" has just been said, as an order.
        relative: So has "halt", "freeze", "wait", "hold on", "pause" or the like.
        order: What was said in the last 2 s was an order to stop, and no more than that. It can be told half a second
            after the end.
    """

    stop: float
    relative: float
    order: float


class StopNetwork:
    """Follows one stream. Belongs to one thread at a time; takes 1 to 3 % of one core."""

    def __init__(self) -> None:
        self._weights = _weights()
        self._samples: Samples = np.zeros(FRAME - HOP, np.float32)
        self._past: dict[str, Array] = {}

    def accept(self, samples: Samples) -> Verdict | None:
        """Take the next samples, 16 kHz mono.

        Returns:
            The newest verdict; None if there is no new one: there is one each 40 ms.
        """
        self._samples = np.concatenate([self._samples, samples])
        verdict = None
        while len(self._samples) >= FRAME + (STEP - 1) * HOP:
            verdict = self._judge(self._embedding(spectrogram(self._samples[: FRAME + (STEP - 1) * HOP])))
            self._samples = self._samples[STEP * HOP :]
        return verdict

    def _embedding(self, rows: Array) -> Array:
        """Of these rows of the spectrogram and those before them; shape (1, 96)."""
        hidden = rows[:, :, np.newaxis]
        for index in range(CONVOLUTIONS - 1):
            kernel = self._weights[f"embedding.{index}.weight"]  # rows, bands, channels in, channels out
            if kernel.shape[0] > 1:
                hidden = self._with_past(f"embedding.{index}", hidden, 2)
            hidden = _convolution(hidden, kernel)
            hidden += self._weights[f"embedding.{index}.bias"]
            hidden = np.maximum(np.maximum(hidden, _LEAK * hidden), _FLOOR)
            if index in POOLED:
                hidden = _largest(hidden, *POOLED[index])
        # The embedding was made for steps of 80 ms. Here are two in one: the last maximum slides, and what follows
        # takes every second.
        hidden = _largest(self._with_past("pairs", hidden, 1), 2, 2)
        taps = self._with_past("taps", hidden, 2 * EVERY)[::EVERY]
        return taps.reshape(1, -1) @ self._weights[f"embedding.{CONVOLUTIONS - 1}.weight"].reshape(taps.size, -1)

    def _judge(self, embedding: Array) -> Verdict:
        weights = self._weights
        hidden = np.maximum(embedding @ weights["head.in.weight"] + weights["head.in.bias"], 0)
        for layer, dilation in enumerate(DILATIONS):
            name = f"head.{layer}"
            taps = self._with_past(name, hidden, 2 * dilation)[::dilation].reshape(1, -1)
            hidden = hidden + np.maximum(taps @ weights[f"{name}.weight"] + weights[f"{name}.bias"], 0)
        logits = (hidden @ weights["head.out.weight"] + weights["head.out.bias"])[0]
        stop, relative, order = 1 / (1 + np.exp(-logits.astype(float)))
        return Verdict(float(stop), float(relative), float(order))

    def _with_past(self, name: str, new: Array, count: int) -> Array:
        """What was there before it, so many rows, and the new; zeros at first."""
        past = self._past.get(name)
        if past is None:
            past = np.zeros((count, *new.shape[1:]), np.float32)
        rows = np.concatenate([past, new])
        self._past[name] = rows[-count:]
        return rows


def _convolution(hidden: Array, kernel: Array) -> Array:
    """Over rows without a border; over bands with one of zeros."""
    height, width, channels_in, channels_out = kernel.shape
    rows, bands = hidden.shape[0] - height + 1, hidden.shape[1]
    if width > 1:
        bordered = np.zeros((hidden.shape[0], bands + 2, channels_in), np.float32)
        bordered[:, 1:-1] = hidden
        hidden = bordered
    taps = [hidden[row : row + rows, band : band + bands] for row in range(height) for band in range(width)]
    flat = np.concatenate(taps, axis=2).reshape(rows * bands, -1)
    return (flat @ kernel.reshape(-1, channels_out)).reshape(rows, bands, channels_out)


def _largest(hidden: NDArray[np.float32], rows: int, bands: int) -> NDArray[np.float32]:
    kept = hidden[: hidden.shape[0] // rows * rows, : hidden.shape[1] // bands * bands]
    kept = kept.reshape(kept.shape[0] // rows, rows, kept.shape[1] // bands, bands, -1)
    return np.asarray(kept.max(axis=(1, 3)))


def spectrogram(samples: Samples) -> NDArray[np.float32]:
    """Mel spectrogram as the embedding knows it: one row each 10 ms, logarithmic, shape (n, 32)."""
    frames = np.lib.stride_tricks.sliding_window_view(samples, FRAME)[::HOP]
    window, filters = _filters()
    power = np.square(np.abs(np.fft.rfft(frames * window, axis=1))) @ filters
    return np.asarray(np.log10(np.maximum(power, _LEAST_POWER)) + 2, np.float32)


@cache
def _filters() -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The window for samples of -1 to 1, and the bands (Slaney's mel scale and areas)."""
    window = np.zeros(FRAME, np.float32)
    before = (FRAME - _WINDOW) // 2
    window[before : before + _WINDOW] = 32768 * (0.5 - 0.5 * np.cos(2 * np.pi * np.arange(_WINDOW) / _WINDOW))
    octave = np.log(6.4) / 27

    def mel(frequency: float) -> float:
        return frequency * 3 / 200 if frequency < 1000 else 15 + np.log(frequency / 1000) / octave

    mels = np.linspace(mel(_LOWEST), mel(_HIGHEST), BANDS + 2)
    edges = np.where(mels < 15, mels * 200 / 3, 1000 * np.exp((mels - 15) * octave))
    bins = np.arange(FRAME // 2 + 1)[:, np.newaxis] * SAMPLE_RATE / FRAME
    rising, falling = (bins - edges[:-2]) / np.diff(edges)[:-1], (edges[2:] - bins) / np.diff(edges)[1:]
    filters = np.maximum(0, np.minimum(rising, falling)) * 2 / (edges[2:] - edges[:-2])
    return window, filters.astype(np.float32)


@cache
def _weights() -> Weights:
    with (resources.files("attune.data") / "stop_network.npz").open("rb") as file, np.load(file) as found:
        return {name: found[name].astype(np.float32) for name in found.files}


def names() -> Iterator[str]:
    """Of the arrays that make up the weights."""
    for index in range(CONVOLUTIONS):
        yield f"embedding.{index}.weight"
        if index < CONVOLUTIONS - 1:
            yield f"embedding.{index}.bias"
    for layer in ("in", *range(len(DILATIONS)), "out"):
        yield from (f"head.{layer}.weight", f"head.{layer}.bias")
