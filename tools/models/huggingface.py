"""Pairs from Hugging Face folders: CLIP (TinyCLIP, too), SigLIP, and BLIP's encoders."""

import copy
import json
from pathlib import Path

import torch
from torch import nn
from torch.nn import functional

from models.manifest import ModelError
from tools.models.export import export_graph, export_text
from tools.models.grad_cam import export_saliency
from tools.models.loading import loading
from tools.models.pair import CLIP_MEAN, CLIP_STD, IMAGE, SALIENCY, TEXT, TOKENIZER, Pair
from tools.models.siglip_tokenizer import from_sentencepiece
from tools.models.tower import Tower

KINDS = ("clip", "siglip", "blip")
# BLIP's checkpoints do not keep the temperature that it was trained with; this is where training starts (Li et al.
# 2022, as in MoCo).
_BLIP_SCALE = 1 / 0.07
_PROBES = ("a photo of a teddy bear", "the fridge, in a kitchen's corner", "Two chairs & a TABLE; no. 42!")


def from_folder(folder: Path, source: str, licence: str) -> Pair:
    """A folder with ``config.json`` of one of ``KINDS``, weights and tokenizer.

    Raises:
        ModelError: of another kind, incomplete, or without vectors in a common space.
    """
    import transformers

    transformers.utils.logging.disable_progress_bar()
    with loading(source):
        config = json.loads((folder / "config.json").read_text())
    kind = config.get("model_type")
    if kind not in KINDS:
        raise ModelError(f"{source} is a {kind} model; of Hugging Face's, vlpg imports {', '.join(KINDS)}.")
    name = {"clip": "CLIPModel", "siglip": "SiglipModel", "blip": "BlipForImageTextRetrieval"}[kind]
    if kind == "blip" and name not in config.get("architectures", []):
        raise ModelError(f"{source} has no vectors for both pictures and words; take a BLIP for retrieval (itm).")
    with loading(source):
        options = {"local_files_only": True}
        model = getattr(transformers, name).from_pretrained(folder, attn_implementation="eager", **options)
        tokenizer = transformers.AutoTokenizer.from_pretrained(folder, **options)
        return _pair(model.eval().requires_grad_(False).float(), tokenizer, kind, folder, source, licence)


def _pair(model: nn.Module, tokenizer, kind: str, folder: Path, source: str, licence: str) -> Pair:
    towers = _Blip(model) if kind == "blip" else _Clip(model)
    vision, words = model.config.vision_config, model.config.text_config
    size = vision.image_size
    mean, std = normalization(folder, kind)
    fixed = kind == "siglip"
    context = min(words.max_position_embeddings, tokenizer.model_max_length)

    def tokenize(prompt):
        padding = "max_length" if fixed else False
        return tokenizer(prompt, truncation=True, max_length=context, padding=padding, return_tensors="pt").input_ids

    def see(pixels):
        with torch.no_grad():
            return functional.normalize(towers.image(torch.tensor(pixels)), dim=-1)[0].numpy()

    def read(prompt):
        with torch.no_grad():
            return functional.normalize(towers.text(tokenize(prompt)), dim=-1)[0].numpy()

    def export(target):
        tower = Tower(model, towers.image, model.vision_model.encoder.layers[-1], (size, size))
        export_graph(tower, (torch.zeros(1, 3, size, size),), target / IMAGE, ["image"], ["vectors", *tower.names])
        export_saliency(tower, target / SALIENCY)
        text = {"clip": _CausalText, "siglip": _Text, "blip": _Text}[kind](towers)
        export_text(text, tokenize(_PROBES[0]), target / TEXT, fixed)
        (target / TOKENIZER).write_text(_tokenizer_json(tokenizer, folder, source))

    return Pair(
        source=source, licence=licence, kind="ViT", height=size, width=size, mean=mean, std=std,
        logit_scale=towers.scale, context_length=context, pad_id=int(tokenizer.pad_token_id) if fixed else None,
        export=export, see=see, read=read,
    )  # fmt: skip


class _Clip(nn.Module):
    """CLIP's and SigLIP's way to vectors."""

    def __init__(self, model: nn.Module):
        super().__init__()
        self.model = model
        self.scale = float(model.logit_scale.exp())

    def image(self, pixels):
        return self.model.get_image_features(pixel_values=pixels).pooler_output

    def text(self, ids):
        return self.model.get_text_features(input_ids=ids).pooler_output


class _Blip(nn.Module):
    """BLIP's: the first token of each encoder, projected; the text encoder without its sight of a picture."""

    def __init__(self, model: nn.Module):
        super().__init__()
        self.model = model
        self.scale = _BLIP_SCALE

    def image(self, pixels):
        return self.model.vision_proj(self.model.vision_model(pixel_values=pixels).last_hidden_state[:, 0])

    def text(self, ids):
        hidden = self.model.text_encoder(input_ids=ids, attention_mask=torch.ones_like(ids)).last_hidden_state
        return self.model.text_proj(hidden[:, 0])


class _Text(nn.Module):
    """The model's own text tower: ids (1, T) to the unit vector (1, D)."""

    def __init__(self, towers: nn.Module):
        super().__init__()
        self.towers = towers

    def forward(self, ids):
        return functional.normalize(self.towers.text(ids), dim=-1)


class _CausalText(nn.Module):
    """CLIP's text tower over ids (1, T) of any length that end in the end token, the one that is read."""

    def __init__(self, towers: nn.Module):
        super().__init__()
        self.model = towers.model

    def forward(self, ids):
        text, length = self.model.text_model, ids.shape[1]
        longest = text.config.max_position_embeddings
        mask = torch.full((longest, longest), torch.finfo(torch.float32).min).triu(1)[None, None, :length, :length]
        x = text.encoder(inputs_embeds=text.embeddings(input_ids=ids), attention_mask=mask).last_hidden_state
        return functional.normalize(self.model.text_projection(text.final_layer_norm(x)[:, -1]), dim=-1)


def normalization(folder: Path, kind: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Mean and standard deviation of the pixels, from the folder or as is usual for its kind."""
    settings = {}
    for name in ("processor_config.json", "preprocessor_config.json"):
        if (folder / name).is_file():
            read = json.loads((folder / name).read_text())
            settings = read.get("image_processor", read)
    mean, std = ((0.5,) * 3, (0.5,) * 3) if kind == "siglip" else (CLIP_MEAN, CLIP_STD)
    return tuple(settings.get("image_mean", mean)), tuple(settings.get("image_std", std))


def _tokenizer_json(tokenizer, folder: Path, source: str) -> str:
    """The robot's tokenizer file, checked against the framework's own tokenizer on a few prompts."""
    from tokenizers import Tokenizer

    ready, pieces = folder / "tokenizer.json", folder / "spiece.model"
    if getattr(tokenizer, "backend_tokenizer", None) is not None:
        text = copy.deepcopy(tokenizer.backend_tokenizer).to_str()
    elif ready.is_file():
        text = ready.read_text()
    elif pieces.is_file():
        text = from_sentencepiece(pieces)
    else:
        raise ModelError(f"{source} has neither tokenizer.json nor spiece.model, by which the robot could read words.")
    ours = Tokenizer.from_str(text)
    ours.no_padding()
    ours.no_truncation()
    for probe in _PROBES:
        if ours.encode(probe).ids != list(tokenizer(probe).input_ids):
            raise ModelError(f"The tokenizer of {source} cannot be converted: it reads {probe!r} differently then.")
    return ours.to_str()
