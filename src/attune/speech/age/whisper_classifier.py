"""The age model of the paper in PyTorch: Whisper's encoder and an attention-based classifier.

This module needs torch and transformers; import it only where a model is trained, converted or run with them.

The names of the weights are those of the checkpoint that the paper's authors published: `encoder.*`,
`projector.attention.{q,k,v,out}_proj.weight`, `projector.self_attn_layer_norm.*`, `projector.final_layer_norm.*`,
`projector.linear.*`, `classifier.*`, and `layer_weights` where the layers are summed.
"""

from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional
from transformers import WhisperConfig
from transformers.models.whisper.modeling_whisper import WhisperEncoder

from attune.core.messages import AGE_GROUPS
from attune.speech.age.options import AgeModelOptions


class SelfAttention(nn.Module):
    """Multi-head self-attention with projections without bias."""

    def __init__(self, width: int, heads: int, dropout: float) -> None:
        super().__init__()
        self.heads = heads
        self.dropout = dropout
        self.k_proj = nn.Linear(width, width, bias=False)
        self.v_proj = nn.Linear(width, width, bias=False)
        self.q_proj = nn.Linear(width, width, bias=False)
        self.out_proj = nn.Linear(width, width, bias=False)

    def forward(self, frames: Tensor, heard: Tensor | None) -> Tensor:
        """Frames of shape (batch, time, width); `heard` of shape (batch, time) is False where there is none."""
        batch, time, width = frames.shape
        split = (batch, time, self.heads, width // self.heads)
        query, key, value = (
            layer(frames).view(split).transpose(1, 2) for layer in (self.q_proj, self.k_proj, self.v_proj)
        )
        mixed = functional.scaled_dot_product_attention(
            query,
            key,
            value,
            attn_mask=None if heard is None else heard[:, None, None, :],
            dropout_p=self.dropout if self.training else 0.0,
        )
        return cast(Tensor, self.out_proj(mixed.transpose(1, 2).reshape(batch, time, width)))


class AttentionBlock(nn.Module):
    """Layer norm, self-attention, residual, layer norm, projection with rectification."""

    def __init__(self, width: int, options: AgeModelOptions) -> None:
        super().__init__()
        self.self_attn_layer_norm = nn.LayerNorm(width)
        self.final_layer_norm = nn.LayerNorm(width)
        self.attention = SelfAttention(width, options.heads, options.dropout)
        self.linear = nn.Linear(width, options.projection)
        self.dropout = nn.Dropout(options.dropout)

    def forward(self, frames: Tensor, heard: Tensor | None) -> Tensor:
        """From shape (batch, time, width) to (batch, time, projection)."""
        mixed = frames + self.dropout(self.attention(self.self_attn_layer_norm(frames), heard))
        return cast(Tensor, self.dropout(functional.relu(self.linear(self.final_layer_norm(mixed)))))


class AgeHead(nn.Module):
    """From encoder frames to the logits of the nine groups.

    Args:
        width: Of the encoder's frames.
        states: How many states an encoder gives (its layers and the embedding); used with `layers="weighted"`.
        options: The variant.
    """

    def __init__(self, width: int, states: int, options: AgeModelOptions) -> None:
        super().__init__()
        self.options = options
        if options.layers == "weighted":
            self.layer_weights = nn.Parameter(torch.ones(states) / states)
        self.projector = AttentionBlock(width, options)
        if options.pooling == "attention":
            self.pooling = nn.Linear(options.projection, 1)
        self.classifier = nn.Linear(options.projection, len(AGE_GROUPS))

    def forward(self, frames: Tensor, heard: Tensor | None = None) -> Tensor:
        """Logits, shape (batch, 9).

        Args:
            frames: Shape (batch, time, width), or (batch, states, time, width) with `layers="weighted"`.
            heard: Shape (batch, time), False where a shorter utterance was filled up.
        """
        if self.options.layers == "weighted":
            weights = functional.softmax(self.layer_weights, dim=-1)
            frames = (frames * weights[:, None, None]).sum(dim=1)
        projected = self.projector(frames, heard)
        if self.options.pooling == "attention":
            scores = self.pooling(projected).squeeze(-1)
        else:
            scores = projected.new_zeros(projected.shape[:2])
        if heard is not None:
            scores = scores.masked_fill(~heard, float("-inf"))
        # With equal scores this is the mean over what was heard.
        pooled = (functional.softmax(scores, dim=1)[:, :, None] * projected).sum(dim=1)
        return cast(Tensor, self.classifier(pooled))


class WhisperAgeClassifier(nn.Module):
    """The whole model: log-mel features in, logits of the nine groups out.

    Args:
        config: Of the Whisper model whose encoder is used.
        options: The variant of the classifier.
    """

    def __init__(self, config: WhisperConfig, options: AgeModelOptions) -> None:
        super().__init__()
        self.config = config
        self.options = options
        self.encoder = WhisperEncoder(config)
        self.head = AgeHead(config.d_model, config.encoder_layers + 1, options)

    def encode(self, features: Tensor, lengths: Tensor | None = None) -> tuple[Tensor, Tensor | None]:
        """Run the encoder on the true length.

        Whisper's own code insists on 30 s; the layers do not. What a shorter utterance of a batch was filled up with
        is hidden from every layer, so that a batch gives the same frames as one utterance at a time.

        Args:
            features: Shape (batch, bands, even number of frames), filled up at the end.
            lengths: True number of feature frames of each utterance, even; None when all fill the batch.

        Returns:
            Frames of shape (batch, time, width), or (batch, states, time, width) with `layers="weighted"`, and which
            of them, (batch, time), are of the utterance (None: all).
        """
        encoder = self.encoder
        heard = mask = None
        if lengths is not None:
            valid = torch.arange(features.shape[-1], device=features.device) < lengths[:, None]
            heard = valid[:, ::2]
            features = features * valid[:, None, :]
            mask = torch.zeros(heard.shape, dtype=features.dtype, device=features.device)
            mask = mask.masked_fill(~heard, torch.finfo(features.dtype).min)[:, None, None, :]
        states = functional.gelu(encoder.conv1(features))
        if lengths is not None:
            states = states * valid[:, None, :]
        states = functional.gelu(encoder.conv2(states)).transpose(1, 2)
        states = states + encoder.embed_positions.weight[: states.shape[1]]
        every = [states]
        for layer in encoder.layers:
            states = layer(states, mask)
            every.append(states)
        every[-1] = encoder.layer_norm(states)
        chosen = every if self.options.layers == "weighted" else every[-1:]
        thinned = [self._thin(state, heard) for state in chosen]
        if heard is not None:
            heard = heard[:, :: self.options.frame_stride]
        return (torch.stack(thinned, dim=1) if self.options.layers == "weighted" else thinned[0]), heard

    def forward(self, features: Tensor, lengths: Tensor | None = None) -> Tensor:
        """Logits of shape (batch, 9); the arguments are those of `encode`."""
        frames, heard = self.encode(features, lengths)
        return cast(Tensor, self.head(frames, heard))

    def probabilities(self, features: Tensor, lengths: Tensor | None = None) -> Tensor:
        """Calibrated probabilities of shape (batch, 9)."""
        return functional.softmax(self(features, lengths) / self.options.temperature, dim=-1)

    def _thin(self, states: Tensor, heard: Tensor | None) -> Tensor:
        stride = self.options.frame_stride
        if stride == 1:
            return states

        def average(rows: Tensor) -> Tensor:
            return functional.avg_pool1d(rows, stride, ceil_mode=True, count_include_pad=False)

        if heard is None:
            return average(states.transpose(1, 2)).transpose(1, 2)
        share = heard.to(states.dtype)[:, None, :]
        total = average(states.transpose(1, 2) * share)
        return (total / average(share).clamp_min(1e-6)).transpose(1, 2)
