"""Pairs from OpenCLIP: its named architectures with its own weights or a checkpoint, and its folders."""

import copy
import json
from pathlib import Path

import torch
from tokenizers import Regex, Tokenizer, normalizers
from torch import nn
from torch.nn import functional

from models.manifest import ModelError
from tools.models.attention import write_out_attention
from tools.models.clip_tokenizer import from_open_clip
from tools.models.export import export_graph, export_text
from tools.models.grad_cam import export_saliency
from tools.models.loading import loading
from tools.models.pair import IMAGE, SALIENCY, TEXT, TOKENIZER, Pair
from tools.models.siglip_tokenizer import canonical
from tools.models.tower import Tower


def named(name: str, tag: str | None, checkpoint: Path | None) -> Pair:
    """The architecture ``name`` with OpenCLIP's weights ``tag``, or those of a file.

    Raises:
        ModelError: no such architecture or weights, no weights stated, or the file does not fit.
    """
    import open_clip

    if name not in open_clip.list_models():
        raise ModelError(
            f"OpenCLIP has no model {name}; `python -c 'import open_clip; print(open_clip.list_models())'`."
        )
    tags = open_clip.list_pretrained_tags_by_model(name)
    if checkpoint is None and tag not in tags:
        raise ModelError(
            f"Say which weights: {name}@TAG with one of {', '.join(tags) or 'none'}, or --checkpoint FILE."
        )
    if checkpoint is not None and not checkpoint.is_file():
        raise ModelError(f"There is no checkpoint {checkpoint}.")
    quick = bool(checkpoint is None and open_clip.get_pretrained_cfg(name, tag).get("quick_gelu"))
    source = f"OpenCLIP {name}" + (f"@{tag}" if checkpoint is None else f", checkpoint {checkpoint.name}")
    weights = str(checkpoint) if checkpoint else tag
    with loading(source):
        model = open_clip.create_model(name, weights, force_quick_gelu=quick, pretrained_image=False)
        return _pair(model, open_clip.get_tokenizer(name), source, "")


def from_folder(folder: Path, source: str, licence: str) -> Pair:
    """A folder with ``open_clip_config.json`` and weights, as OpenCLIP puts it on a hub.

    Raises:
        ModelError: it cannot be read, or has no weights.
    """
    import open_clip

    with loading(source):
        settings = json.loads((folder / "open_clip_config.json").read_text())
    if "trust_remote_code" in _keys(settings):
        raise ModelError(f"{source} asks to run code of its own (trust_remote_code); such a model is not imported.")
    place = f"local-dir:{folder}"
    with loading(source):
        model = open_clip.create_model(place, require_pretrained=True)
        return _pair(model, open_clip.get_tokenizer(place), source, licence)


def _keys(value) -> set[str]:
    """All keys at any depth of what was read from JSON, however they were written there."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return set(value if isinstance(value, dict) else ()).union(*map(_keys, inner))


def _pair(model: nn.Module, tokenizer, source: str, licence: str) -> Pair:
    import open_clip

    model = model.eval().requires_grad_(False).float()
    settings = open_clip.get_model_preprocess_cfg(model)
    size = settings["size"]
    height, width = (size, size) if isinstance(size, int) else size
    text = getattr(model, "text", model)
    short = _is_causal(text)

    def see(pixels):
        with torch.no_grad():
            return model.encode_image(torch.tensor(pixels), normalize=True)[0].numpy()

    def read(prompt):
        with torch.no_grad():
            return model.encode_text(tokenizer([prompt]), normalize=True)[0].numpy()

    def export(folder):
        plain = _plain(model)
        cut, _ = _cut(plain.visual)
        tower = Tower(plain, plain.encode_image, cut, (height, width))
        export_graph(tower, (torch.zeros(1, 3, height, width),), folder / IMAGE, ["image"], ["vectors", *tower.names])
        export_saliency(tower, folder / SALIENCY)
        ids = tokenizer(["a photo"])
        if short:
            ids = ids[:, : int(ids[0].argmax()) + 1]
        tower = _CausalText(getattr(plain, "text", plain)) if short else _FixedText(plain)
        export_text(tower, ids, folder / TEXT, fixed=not short)
        (folder / TOKENIZER).write_text(_tokenizer_json(tokenizer))

    return Pair(
        source=source, licence=licence, kind=_cut(model.visual)[1], height=height, width=width,
        mean=tuple(settings["mean"]), std=tuple(settings["std"]), logit_scale=float(model.logit_scale.exp()),
        context_length=int(model.context_length), pad_id=None if short else _pad_id(tokenizer),
        export=export, see=see, read=read,
    )  # fmt: skip


def _plain(model: nn.Module) -> nn.Module:
    """A copy without what serves training only: branches that can be merged, attention kernels without ONNX form."""
    model = copy.deepcopy(model)
    write_out_attention(model)
    if hasattr(model.visual, "trunk"):
        from timm.utils.model import reparameterize_model

        model.visual.trunk = reparameterize_model(model.visual.trunk, inplace=True)
        for module in model.visual.modules():
            if hasattr(module, "fused_attn"):
                module.fused_attn = False
    return model


def _cut(visual: nn.Module) -> tuple[nn.Module, str]:
    """The module whose input is the last spatial map, and what kind of tower that makes it."""
    if hasattr(visual, "attnpool"):
        return visual.attnpool, "CLIP ResNet, attention pool"
    if hasattr(visual, "transformer"):
        return visual.transformer.resblocks[-1], "ViT"
    trunk = getattr(visual, "trunk", None)
    name = getattr(trunk, "default_cfg", {}).get("architecture", "timm")
    if hasattr(trunk, "blocks"):
        return trunk.blocks[-1], f"ViT ({name})"
    if hasattr(trunk, "head"):
        return trunk.head, f"CNN ({name}), pooled"
    raise ModelError(f"{type(visual).__name__} is an image tower without a last block or pooling that vlpg knows.")


def _is_causal(text: nn.Module) -> bool:
    """Whether tokens see only what is before them and the last one is read: then prompts need no filling."""
    reads_last = getattr(text, "pool_type", getattr(text, "text_pool_type", None)) in ("argmax", "eos")
    return getattr(text, "attn_mask", None) is not None and getattr(text, "cls_emb", None) is None and reads_last


class _CausalText(nn.Module):
    """CLIP's text tower over prompts of any length, ids (1, T) that end in the end token."""

    def __init__(self, text: nn.Module):
        super().__init__()
        self.text = text

    def forward(self, ids):
        text, length = self.text, ids.shape[1]
        x = text.token_embedding(ids) + text.positional_embedding[:length]
        x = text.transformer(x, attn_mask=text.attn_mask[:length, :length])
        x = text.ln_final(x)[:, -1]
        if isinstance(text.text_projection, nn.Linear):
            x = text.text_projection(x)
        elif text.text_projection is not None:
            x = x @ text.text_projection
        return functional.normalize(x, dim=-1)


class _FixedText(nn.Module):
    """The model's own text tower, over prompts filled to its context length."""

    def __init__(self, model: nn.Module):
        super().__init__()
        self.model = model

    def forward(self, ids):
        return self.model.encode_text(ids, normalize=True)


def _pad_id(tokenizer) -> int:
    inner = getattr(tokenizer, "tokenizer", None)  # Hugging Face's, inside; OpenCLIP's own fills with zeros
    return int(inner.pad_token_id or 0) if inner is not None else 0


def _tokenizer_json(tokenizer) -> str:
    import open_clip

    if isinstance(tokenizer, open_clip.SimpleTokenizer):
        return from_open_clip(tokenizer)
    inner = getattr(getattr(tokenizer, "tokenizer", None), "backend_tokenizer", None)
    if inner is None:
        raise ModelError(f"{type(tokenizer).__name__} has no form that the robot's tokenizer reads.")
    ours = Tokenizer.from_str(inner.to_str())
    steps = {
        "_clean_canonicalize": [normalizers.Replace("_", " "), *canonical()],
        "_clean_lower": [normalizers.Replace(Regex(r"\s+"), " "), normalizers.Strip(), normalizers.Lowercase()],
    }.get(tokenizer.clean_fn.__name__, [normalizers.Replace(Regex(r"\s+"), " "), normalizers.Strip()])
    ours.normalizer = normalizers.Sequence(steps + ([ours.normalizer] if ours.normalizer else []))
    return ours.to_str()
