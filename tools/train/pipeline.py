"""The stages of training, each resuming from the files that the ones before it left in the work folder."""

import json
import platform
import shutil
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

import numpy as np
import torch
from torch import nn

from edge.perception.encoder import Encoder
from edge.perception.preprocess import preprocess
from edge.perception.prompts import contrast
from edge.perception.session import open_session
from edge.perception.text import TextTower as RuntimeText
from models.manifest import Image, Manifest
from tools.assets.catalog import find_libraries
from tools.bench import encoder as bench
from tools.eval.encoder import evaluate_naming, evaluate_photographs
from tools.logistic import logistic
from tools.models.measure import measure
from tools.models.reference import NAME as REFERENCE
from tools.train import card, evaluate, image_export, text_tower
from tools.train.batches import Batches
from tools.train.features import Features, is_validation, make_chunks
from tools.train.fetch import fetch
from tools.train.finetune import TrainConfig, train
from tools.train.float_reference import HOME, make_reference
from tools.train.golden import odd_sizes, write_golden, write_preprocess_golden
from tools.train.homes import shoot
from tools.train.image_tower import Front, Head, ImageTower, Neck, Trunk
from tools.train.package import write_manifest
from tools.train.presence import presence
from tools.train.scenes import SceneMaker
from tools.train.sprites import LIBRARIES, load_sprites, render_library, training_entries
from tools.train.validate import validate
from tools.train.vocabulary import Vocabulary
from tools.train.words import NOTHING, TEMPLATES, concept_vectors, imagenet_names, noun

HEIGHT, WIDTH = 224, 288  # px: 7 x 9 deep cells, so that thirds fall between cells; 320 x 240 is stretched by 4 %
REGIONS = ((0.0, 1.0), (0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))
MEAN, STD = (0.498, 0.498, 0.498), (0.502, 0.502, 0.502)  # (x - 127) / 128, as the trunk was trained
SHARE = 0.5  # of the concepts in the fused vector; best of 0.2 … 0.65 on the validation models
# Twice: without the validation models, to measure and calibrate; then from there with all of them, to ship.
MEASURED = TrainConfig()
SHIPPED = TrainConfig(steps=700, rate=4e-4, late_rate=5e-5, seed=1)
TRAINING_CHUNKS, VALIDATION_CHUNKS = 56, 8  # of 500 scenes
CALIBRATION = 64  # pictures that set the int8 ranges
CONTEXT = 128  # tokens


class Pipeline:
    """Stages by name. ``furniture`` holds the libraries, ``work`` what can be made again, ``model`` is the result."""

    def __init__(self, furniture: Path, work: Path, model: Path):
        self.furniture, self.work, self.model = furniture, work, model
        self.fetched = work / "fetched"
        self.image = Image("image.onnx", "saliency.onnx", HEIGHT, WIDTH, MEAN, STD, REGIONS)

    def fetch(self) -> None:
        fetch(self.fetched)

    def render(self) -> None:
        libraries = find_libraries(self.furniture)
        with ProcessPoolExecutor(2) as pool:
            jobs = [pool.submit(render_library, libraries[name], self.work / "sprites") for name in LIBRARIES]
            jobs.append(pool.submit(evaluate.render_held_out, libraries, self.work / "held_out"))
            for job in jobs:
                job.result()

    def features(self) -> None:
        """What the frozen front of the trunk sees in many scenes, for training and for validation."""
        graph = self.work / "export" / "front.onnx"
        image_export.export_front(Front(self._trunk(), self._classifier(), REGIONS), HEIGHT, WIDTH, graph)
        session = open_session(graph)

        def see(rgb):
            middle, logits = session.run(None, {"image": preprocess(rgb, self.image)})
            return middle[0], logits

        entries = training_entries(self.furniture)
        held = np.array([is_validation(entry) for entry in entries])
        for name, use, count in (("val", held, VALIDATION_CHUNKS), ("train", ~held, TRAINING_CHUNKS)):
            make_chunks(entries, np.flatnonzero(use), self.work / "sprites", see, self.work / "features" / name, count)

    def train(self) -> None:
        entries, encode = training_entries(self.furniture), self._text().encode
        vocabulary = Vocabulary(entries, encode)
        tower = self._new_tower()
        self._trained("measured", tower, MEASURED, ["train"], entries, vocabulary)
        report = self._measure(tower, self._features("val"), entries, encode)
        (self.work / "validation.json").write_text(json.dumps(report, indent=2))
        print(json.dumps(report["scores"]))
        self._trained("shipped", tower, SHIPPED, ["train", "val"], entries, vocabulary)

    def _trained(self, name: str, tower: ImageTower, config: TrainConfig, scenes, entries, vocabulary) -> None:
        """Train the tower on the scenes of those names, or load what this has left before."""
        file = self.work / f"{name}.pt"
        if file.exists():
            tower.load_state_dict(torch.load(file, weights_only=True))
            return
        batches = Batches(self._features(*scenes), REGIONS, len(entries), config.batch, config.windows, config.seed)
        train(tower, batches, vocabulary, config, self.work / f"{name}.ckpt")
        torch.save(tower.state_dict(), file)

    def export(self) -> None:
        image_export.export_float(self._trained_tower(), HEIGHT, WIDTH, self.work / "export" / "image_float.onnx")

    def quantize(self) -> None:
        """The finished model folder, and the golden file of the robot's tests."""
        tower = self._trained_tower()
        report = json.loads((self.work / "validation.json").read_text())
        self.model.mkdir(parents=True, exist_ok=True)
        pictures = (preprocess(rgb, self.image) for rgb in self._pictures(CALIBRATION))
        image_export.quantize(self.work / "export" / "image_float.onnx", self.model / "image.onnx", pictures)
        image_export.export_saliency(tower.head, HEIGHT, WIDTH, self.model / "saliency.onnx")
        self._text()
        for name in ("text.onnx", "text.onnx.data", "tokenizer.json"):
            shutil.copy(self.work / "text" / name, self.model)
        (self.model / REFERENCE).unlink(missing_ok=True)  # that of other weights; the next stage makes it anew
        write_manifest(self.model, self._fields(self.model.name, report["relevance"], MEASURED.scale))
        tests = Path("tests/edge/perception")
        views = [shot.rgb for shot in shoot(HOME, 6)[1]]  # of CC0 furniture: the file is committed
        write_golden(tower, views, self.image, Encoder.load(self.model), tests / "encoder_golden.npz")
        write_preprocess_golden(odd_sizes(), self.image, tests / "preprocess_golden.npz")

    def reference(self) -> None:
        """What the towers say in float32 on a few pictures and prompts, as a file of the finished model."""
        text = text_tower.TextTower.load(self.fetched / "minilm")
        tokenizer, held_out = self.model / "tokenizer.json", self.work / "held_out"
        make_reference(self._trained_tower(), self.image, text, tokenizer, held_out).save(self.model)
        self._rewrite_manifest(self.model)

    def evaluate(self) -> None:
        """All that the card says of the int8 model, beside the same in float32; and the card's pictures."""
        pictures = self.work / "held_out"
        shipped, exact = Encoder.load(self.model), Encoder.load(self._float_model())
        results = {
            "int8": evaluate_naming(shipped, self.furniture, pictures, self.model),
            "float32": evaluate_naming(exact, self.furniture, pictures),
            "parity": evaluate.parity(shipped, exact, pictures),
            "homes": evaluate.evaluate_homes(shipped),
            "photographs": evaluate_photographs(shipped, self.model),
        }
        manifest = Manifest.load(self.model)
        with tempfile.TemporaryDirectory() as folder:
            results["peers"] = [asdict(peer) for peer in bench.measure(bench.peers(manifest, Path(folder))[0])]
        runtimes = f"ONNX Runtime {version('onnxruntime')}, PyTorch {version('torch')}"
        results["machine"] = f"On {platform.machine()}, {runtimes}"
        (self.work / "evaluation.json").write_text(json.dumps(results, indent=1))
        print(json.dumps({key: value for key, value in results.items() if key != "photographs"}))
        quality = {key: results["int8"][key] for key in ("top1", "top5")} | {"top5_float32": results["float32"]["top5"]}
        quality |= {key: results["homes"][key] for key in ("first", "within10", "pointing", "iou")}
        self._rewrite_manifest(self.model, measured=measure(manifest) | quality)

    def card(self) -> None:
        validation = json.loads((self.work / "validation.json").read_text())
        results = json.loads((self.work / "evaluation.json").read_text())
        scenes = len(self._features("train", "val").middle)
        held = sum(map(is_validation, training_entries(self.furniture)))
        text = card.write(Manifest.load(self.model), scenes, held, len(TEMPLATES), SHARE, validation, results)
        (self.model / "MODEL_CARD.md").write_text(text)

    def _text(self) -> RuntimeText:
        """The int8 text tower, packed alone into the work folder on first use: it is locked, so it comes first."""
        folder = self.work / "text"
        if not (folder / "text.onnx").exists():
            plain = self.work / "export" / "text_float.onnx"
            plain.parent.mkdir(parents=True, exist_ok=True)
            text_tower.export(text_tower.TextTower.load(self.fetched / "minilm"), plain)
            folder.mkdir(exist_ok=True)
            shutil.copy(self.fetched / "minilm" / "tokenizer.json", folder)
            text_tower.quantize(plain, folder / "text.onnx")
        write_manifest(folder, self._fields("text", {"slope": 1.0, "offset": 0.0}, 1.0))
        return RuntimeText(Manifest.load(folder))

    def _trunk(self) -> Trunk:
        return Trunk.load(self.fetched / "efficientnet-lite0.pth")

    def _classifier(self) -> nn.Linear:
        weight, bias = self._trunk().classifier()
        classifier = nn.Linear(*weight.T.shape)
        classifier.weight, classifier.bias = nn.Parameter(weight), nn.Parameter(bias)
        return classifier

    def _new_tower(self) -> ImageTower:
        saved = self.work / "concepts.npy"
        if not saved.exists():
            np.save(saved, concept_vectors(imagenet_names(self.fetched), self._text().encode))
        torch.manual_seed(0)
        head = Head(self._classifier(), torch.tensor(np.load(saved)), SHARE)
        return ImageTower(self._trunk(), Neck(), head, REGIONS).requires_grad_(False)

    def _trained_tower(self) -> ImageTower:
        tower = self._new_tower()
        tower.load_state_dict(torch.load(self.work / "shipped.pt", weights_only=True))
        image_export.round_weights(tower.head)
        return tower.eval()

    def _features(self, *names: str) -> Features:
        return Features.load(
            sorted(file for name in names for file in (self.work / "features" / name).glob("[0-9][0-9][0-9].npz"))
        )

    def _measure(self, tower: ImageTower, validation: Features, entries, encode) -> dict:
        """Scores of the validation models, and the calibration fitted on them."""
        nouns = sorted({noun(entry) for entry in entries if is_validation(entry)})
        nothing = encode([NOTHING])[0]
        texts = encode([contrast(name)[0] for name in nouns])
        score, vectors = validate(tower, validation, entries, dict(zip(nouns, texts - nothing)))
        truth = presence(validation, entries, nouns, REGIONS)
        known = ~np.isnan(truth)
        slope, offset = logistic((vectors @ texts.T)[known], truth[known] == 1, balanced=True)
        relevance = {"slope": round(slope, 3), "offset": round(offset, 3)}
        return {"scores": asdict(score), "config": asdict(MEASURED), "relevance": relevance}

    def _pictures(self, count: int) -> list[np.ndarray]:
        """Scenes of the training models for int8 ranges, the same each time."""
        entries = training_entries(self.furniture)[::3]
        maker = SceneMaker(entries, [load_sprites(self.work / "sprites", entry) for entry in entries], seed=1)
        scenes = [maker.close_up(i * 3 % len(entries)) if i % 2 else maker.view(1 + i % 5) for i in range(count)]
        return [scene.rgb for scene in scenes]

    def _float_model(self) -> Path:
        """The finished model with its image tower in float32, for comparison."""
        folder = self.work / "float32"
        shutil.copytree(self.model, folder, dirs_exist_ok=True)
        (folder / "image.onnx.data").unlink(missing_ok=True)
        shutil.copy(self.work / "export" / "image_float.onnx", folder / "image.onnx")
        self._rewrite_manifest(folder)
        return folder

    def _rewrite_manifest(self, folder: Path, **changes) -> None:
        """Of a finished model: with other fields, or because its files are others."""
        fields = json.loads((folder / "manifest.json").read_text()) | changes
        write_manifest(folder, {key: value for key, value in fields.items() if key != "files"})

    def _fields(self, name: str, relevance: dict, scale: float) -> dict:
        """The manifest without its files."""
        image = asdict(self.image)
        text = {"graph": "text.onnx", "tokenizer": "tokenizer.json", "context_length": CONTEXT}
        return {"name": name, "dim": 384, "logit_scale": scale, "image": image, "text": text, "relevance": relevance}
