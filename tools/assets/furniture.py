"""Make the simulator's furniture pack from the CC0 library: `python -m tools.assets.furniture [LIBRARIES] [--out DIR]`.

Every model becomes two sheets of sprites (sprite_sheet.py) and an entry in catalog.json; CREDITS.md names its author.
"""

import argparse
import json
import re
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from tools.assets.catalog import INSTALLED, Entry, Library, find_libraries, open_library
from tools.assets.obj_model import load_mesh
from tools.assets.shape import footprint, outline, top
from tools.assets.sprite_sheet import draw_sheet

LIBRARY = "BlendSwap-CC-0"
LICENCE = "CC0-1.0"
PACK = Path(__file__).parents[2] / "firmware_sim" / "furniture_pack"
NOT_FURNITURE = {"Vehicles", "Characters", "Staircases", "Doors and windows"}
MAX_SIDE = 3.0  # m; larger things do not fit into a room
NAMES = {  # plain English where the catalog's name is not what one would ask for
    "ammo-box": "Wooden box",
    "bootie": "Ankle boots",
    "box": "Plastic box",
    "caballito": "Rocking horse",
    "cartoon-biplane": "Toy biplane",
    "cupcake": "Cupcake",
    "deer": "Deer figurine",
    "fire-extinguisher": "Fire extinguisher",
    "flacon": "Perfume bottle",
    "house-puzzle": "Jigsaw puzzle",
    "iphone": "Mobile phone",
    "kitchenaid": "Stand mixer",
    "knife-stand-swap": "Knife rack",
    "lamp2": "Chandelier",
    "locked-locker": "Locker",
    "modern-vanity": "Bathroom vanity",
    "motorbike": "Spring rider",
    "number-lock": "Keypad lock",
    "relax-chair": "Chaise longue",
    "rigged-fan": "Fan",
    "silla2": "Bar stool",
    "stove": "Gas hob",
    "table-football": "Football table",
    "tetrapak": "Milk carton",
    "toilets-unit": "Toilet",
    "umbrella": "Parasol",
    "wood-toy": "Wooden toy",
}
CREDITS_HEAD = """# Credits of the furniture

Rendered from 3-D models in the library "Blend Swap CC-0" (version {version}) of Sweet Home 3D, cleaned and converted to
OBJ by Emmanuel Puybaret (eTeks). All of them are public domain under CC0 1.0
(https://creativecommons.org/publicdomain/zero/1.0/). Their authors at https://www.blendswap.com, with thanks:

| model | name | author | source | licence |
|---|---|---|---|---|
"""


def belongs(entry: Entry) -> bool:
    """Is this a thing to furnish a room with?"""
    return not entry.door_or_window and entry.category not in NOT_FURNITURE and max(entry.size) <= MAX_SIDE


def source(library: Library, entry: Entry) -> str:
    """Where the model came from, as the licence file beside it says: an address, or a dash."""
    folder = entry.model.rsplit("/", 1)[0].lstrip("/").lower() + "/"
    for name in library.names():
        if name.startswith(folder) and name.endswith((".txt", ".html")):
            number = re.search(r"blendswap\.com/blends/view/(\d+)", library.read(name).decode("latin-1"))
            number = number or re.match(r"(\d{4,})", name.removeprefix(folder))
            if number:
                return f"https://www.blendswap.com/blends/view/{number[1]}"
    return "–"


def make_model(path: Path, out: Path, entry: Entry) -> dict:
    """Render one model into ``out`` and describe it for catalog.json."""
    mesh = load_mesh(open_library(path), entry)
    hangs = round(entry.elevation, 4) if entry.elevation and entry.elevation > 0 else None
    sheet = draw_sheet(mesh, hangs)
    (out / f"{entry.id}.webp").write_bytes(sheet.colour)
    (out / f"{entry.id}.relief.webp").write_bytes(sheet.relief)
    return {
        "id": entry.id,
        "name": NAMES.get(entry.id, entry.name),
        "tags": list(entry.tags),
        "category": entry.category,
        "size": [round(side, 4) for side in entry.size],
        "elevation": hangs,
        "top": top(mesh, entry.drop_on_top),
        "footprint": footprint(mesh).round(4).tolist(),
        "slices": outline(mesh).round(4).tolist(),
        "creator": entry.creator,
        "licence": LICENCE,
        "sprites": sheet.layout,
    }


def make_pack(libraries: Path, out: Path, only: list[str], processes: int) -> None:
    """Write the pack into ``out``; ``only`` limits it to some model ids (the catalog keeps the others)."""
    found = find_libraries(libraries)
    if LIBRARY not in found:
        raise FileNotFoundError(f"{LIBRARY}.sh3f is not in {libraries}: run `apt-get install sweethome3d-furniture`.")
    library = open_library(found[LIBRARY])
    wanted = [entry for entry in library if belongs(entry)]
    out.mkdir(parents=True, exist_ok=True)
    chosen = [entry for entry in wanted if not only or entry.id in only]
    with ProcessPoolExecutor(processes) as pool:
        made = {}
        for model in pool.map(partial(make_model, found[LIBRARY], out), chosen):
            made[model["id"]] = model
            print(f"{len(made)}/{len(chosen)} {model['id']}", file=sys.stderr)
    catalog = out / "catalog.json"
    if only and catalog.exists():
        made = {model["id"]: model for model in json.loads(catalog.read_text())["models"]} | made
    models = [made[key] for key in sorted(made)]
    lines = ",\n".join(json.dumps(model, ensure_ascii=False, separators=(",", ":")) for model in models)
    catalog.write_text(f'{{"library":"{LIBRARY} {library.version}","models":[\n{lines}\n]}}\n')
    sources = {entry.id: source(library, entry) for entry in wanted}
    rows = [f"| {m['id']} | {m['name']} | {m['creator']} | {sources[m['id']]} | CC0 1.0 |" for m in models]
    (out / "CREDITS.md").write_text(CREDITS_HEAD.format(version=library.version) + "\n".join(rows) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("libraries", nargs="?", type=Path, default=INSTALLED, help="folder with the .sh3f files")
    parser.add_argument("--out", type=Path, default=PACK, help="folder of the pack")
    parser.add_argument("--only", nargs="*", default=[], help="model ids; default all")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    try:
        make_pack(options.libraries, options.out, options.only, options.processes)
    except (FileNotFoundError, ValueError) as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
