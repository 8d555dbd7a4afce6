"""``vlpg eval encoder``: how well an encoder names things it was never trained on, and finds them again in homes.

Three parts: pictures of held-out furniture, named among all held-out names; generated homes that no training has seen;
and real photographs that other packages carry. A part whose data is not there is left out, and how to get it is said.
"""

import argparse
import importlib.util
import json
import tempfile
from dataclasses import asdict
from math import isnan
from pathlib import Path

from edge.perception.encoder import Encoder
from edge.process import cache_file
from models.manifest import DEFAULT, ModelError
from tools.assets.catalog import INSTALLED, find_libraries
from tools.eval import photographs
from tools.eval.naming import Answer, Vocabulary, confusions, said_too_often, share
from tools.eval.options import check_folder
from tools.eval.sheets import CONFUSIONS, HELD_OUT, PHOTOS, confusions_sheet, held_out_sheet, photographs_sheet
from tools.train.evaluate import HOMES, LIBRARY, evaluate_homes, held_out, name_held_out, render_held_out, score

MISTAKES = 15  # confusions that are listed


def evaluate_naming(encoder: Encoder, furniture: Path, pictures: Path, sheets: Path | None = None) -> dict | str:
    """Scores and confusions on the held-out models, or a sentence that says what is missing.

    ``pictures`` gets the renderings that are not there yet; ``sheets`` gets contact sheets.
    """
    if importlib.util.find_spec("numba") is None:
        return "Held-out furniture is left out: rendering it needs numba (pip install '.[assets]')."
    try:
        libraries = find_libraries(furniture)
    except FileNotFoundError as error:
        return f"Held-out furniture is left out. {error}"
    if LIBRARY not in libraries:
        return f"Held-out furniture is left out: {furniture} has no {LIBRARY}.sh3f."
    render_held_out(libraries, pictures)
    answers = name_held_out(encoder, held_out(libraries), pictures)
    if sheets is not None:
        held_out_sheet(answers, pictures, sheets / HELD_OUT)
        confusions_sheet(answers, pictures, sheets / CONFUSIONS)
    result = asdict(score(answers, _trained(furniture, libraries)))
    return result | {
        "confusions": confusions(answers, MISTAKES), "said_too_often": said_too_often(answers, MISTAKES),
        "never_in_top5": _never(answers),
    }  # fmt: skip


def evaluate_photographs(encoder: Encoder, sheets: Path | None = None) -> dict | str:
    """Answers to the photographs that are there, or a sentence that says what is missing."""
    found = [(photograph, photographs.load(photograph)) for photograph in photographs.PHOTOGRAPHS]
    found = [(photograph, rgb) for photograph, rgb in found if rgb is not None]
    if not found:
        return "Photographs are left out: they come with scikit-image and scikit-learn (pip install scikit-image)."
    vocabulary = Vocabulary(encoder, photographs.vocabulary())
    answers = [vocabulary.ask(photograph.file, rgb, photograph.truths) for photograph, rgb in found]
    if sheets is not None:
        photographs_sheet(answers, sheets / PHOTOS)
    return {
        "names": len(vocabulary.names), "pictures": len(answers), "top1": share(answers, 1), "top5": share(answers, 5),
        "answers": [asdict(answer) for answer in answers],
    }  # fmt: skip


def show(result: dict) -> None:
    """Print what was measured."""
    naming, homes, photos = result["naming"], result["homes"], result["photographs"]
    if naming:
        print(f"held-out furniture, {naming['pictures']} pictures, {naming['names']} names")
        kinds = [("", "all"), ("seen_", "names that training knew"), ("unseen_", "names it did not")]
        if isnan(naming["seen_top1"]):  # without the libraries of the training nobody can tell which it knew
            del kinds[1:]
            print("  (which of the names training knew is told where sweethome3d-furniture-nonfree is installed, too)")
        for kind, words in kinds:
            print(f"  {words:26} top-1 {naming[f'{kind}top1']:6.1%}   top-5 {naming[f'{kind}top5']:6.1%}")
        print("  most often confused: " + ", ".join(f"{a} with {b} ({n})" for a, b, n in naming["confusions"][:5]))
    if homes:
        print(f"{homes['homes']} homes that no training has seen, 120 views each")
        print(f"of {homes['queries']} names, a view that truly shows the thing is")
        print(f"  first            {homes['first']:6.1%}")
        print(f"  among the first 10 {homes['within10']:4.1%}")
        print(f"of {homes['sightings']} things in view, the saliency")
        print(f"  peaks inside     {homes['pointing']:6.1%}")
        print(f"  overlaps (IoU)   {homes['iou']:6.1%}")
    if photos:
        print(f"real photographs, {photos['pictures']} pictures, {photos['names']} names")
        for answer in photos["answers"]:
            print(f"  {answer['truth']:14} is name {answer['rank'] + 1:3}: {', '.join(answer['best'][:3])}")
        if photos["pictures"] < len(photographs.PHOTOGRAPHS):
            print(f"  {len(photographs.PHOTOGRAPHS) - photos['pictures']} more come with scikit-image and scikit-learn")


def main(arguments: list[str] | None = None) -> None:
    """``vlpg eval encoder``."""
    parser = argparse.ArgumentParser(prog="vlpg eval encoder", description=__doc__.split(": ", 1)[1])
    parser.add_argument("--model", default=DEFAULT, help="name or folder of the encoder (default: %(default)s)")
    parser.add_argument("--homes", type=int, default=len(HOMES), help="generated homes, 120 views each (default: 8)")
    parser.add_argument("--furniture", type=Path, default=INSTALLED, help="folder of Sweet Home 3D's .sh3f libraries")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures and answers there, too")
    parser.add_argument("--sheets", type=Path, metavar="FOLDER", help="write contact sheets there, as JPEG")
    options = parser.parse_args(arguments)
    if options.homes < 1:
        parser.error("--homes must be at least 1")
    if options.json:
        check_folder(parser, options.json)
    try:
        encoder = Encoder.load(options.model)
        if options.sheets:
            options.sheets.mkdir(parents=True, exist_ok=True)
    except (ModelError, OSError) as error:
        parser.exit(2, f"vlpg eval encoder: {error}\n")
    seeds = range(HOMES.start, HOMES.start + options.homes)
    with tempfile.TemporaryDirectory() as scratch:
        pictures = cache_file("held-out") or Path(scratch)
        parts = {
            "naming": evaluate_naming(encoder, options.furniture, pictures, options.sheets),
            "homes": evaluate_homes(encoder, seeds) | {"homes": options.homes},
            "photographs": evaluate_photographs(encoder, options.sheets),
        }
    result = {name: part if isinstance(part, dict) else None for name, part in parts.items()}
    print(f"{encoder.name}, sha256 {encoder.digest[:12]}")
    show(result)
    for part in parts.values():
        if isinstance(part, str):
            print(part)
    if options.json:
        result = {"model": encoder.name, "digest": encoder.digest} | result
        options.json.write_text(json.dumps(result, indent=1))


def _trained(furniture: Path, libraries: dict[str, Path]) -> set[str]:
    """Names that training used; empty when its libraries are not there."""
    from tools.train.sprites import LIBRARIES, training_entries
    from tools.train.words import names

    if not set(LIBRARIES) <= set(libraries):
        return set()
    return {name for entry in training_entries(furniture) for name in names(entry)}


def _never(answers: list[Answer]) -> list[str]:
    """Names of things whose right name was not among the first five for any of their pictures."""
    known = {answer.truth for answer in answers if answer.rank < 5}
    return sorted({answer.truth for answer in answers} - known)


if __name__ == "__main__":
    main()
