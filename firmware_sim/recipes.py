"""How people furnish a room: which things, where, and what goes with them. Model ids are those of the pack."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Piece:
    """One thing for a room, out of several models that would do, and its companions.

    ``place``: "wall" = back against a wall; "floor" = anywhere, turned anyhow; "centre" = in the middle of the room;
    for companions also "on" = on top, "beside" = next to it along the same wall, "before" = in front of it, facing it,
    "around" = at any side of it, facing it.
    """

    models: tuple[str, ...]
    place: Literal["wall", "floor", "centre", "on", "beside", "before", "around"]
    chance: float = 1.0  # that it is there at all
    companions: tuple["Piece", ...] = ()


PLANTS = ("plant", "decorative-plant")
SMALL_PLANTS = ("little-plant", "orchids", "augalas", "cactus")
CHAIRS = ("oak-chair", "antique-chair", "chair2", "thonet", "osaka-chair", "plastic-chair", "silla-blanca", "chair")
LAMPS = ("desklamp", "japanese-lantern")

COUNTER_TOP = Piece(("coffee-brewer", "kitchenaid", "knife-stand-swap", "bread"), "on", 0.8)

RECIPES: dict[str, tuple[Piece, ...]] = {
    "living room": (
        Piece(("couch", "sofa2", "winchester-sofa"), "wall", companions=(Piece(("handbag",), "on", 0.4),)),
        Piece(("television-cabinet", "shelves"), "wall", companions=(Piece(("led-tv",), "on"),)),
        Piece(("armchair2", "winchester-armchair", "modern-armchair"), "wall", 0.9),
        Piece(("piano-aqueue",), "wall", 0.3, (Piece(("piano-bench",), "before"),)),
        Piece(("bookcase", "vertical-shelves"), "wall", 0.8),
        Piece(("table-with-tablecloth",), "wall", 0.6, (Piece(SMALL_PLANTS, "on"),)),
        Piece(PLANTS, "wall", 0.8),
        Piece(("speaker3", "speaker2"), "wall", 0.5),
        Piece(("electric-guitar",), "wall", 0.5),
        Piece(("cuckoo-clock",), "wall", 0.5),
        Piece(("stone-lantern", "table-fan", "relax-chair"), "floor", 0.4),
    ),
    "kitchen": (
        Piece(("refrigerator", "large-fridge"), "wall"),
        Piece(("sink-cabinet",), "wall", companions=(
            Piece(("drawers-cabinet",), "beside", companions=(COUNTER_TOP,)),
            Piece(("lower-cabinet",), "beside", companions=(COUNTER_TOP,)),
        )),
        Piece(("double-oven", "oven"), "wall"),
        Piece(("oak-table", "table-with-tablecloth", "island-extension"), "centre", companions=(
            Piece(CHAIRS, "around"),
            Piece(CHAIRS, "around", 0.7),
            Piece(("tetrapak", "beer-glass", "yogurt-bottle"), "on", 0.8),
            Piece((*SMALL_PLANTS, "kitchenaid"), "on", 0.6),
        )),
        Piece(("silla2", "stool2", "stool"), "floor", 0.6),
        Piece(("high-cabinet", "barrel"), "wall", 0.5),
        Piece(("dustbin",), "wall", 0.7),
    ),
    "bedroom": (
        Piece(("bed-with-texture", "bed2", "bed3", "bed1"), "wall", companions=(
            Piece(("bedside-table2",), "beside", companions=(Piece(LAMPS, "on"),)),
            Piece(("teddy-bear", "handbag"), "on", 0.6),
        )),
        Piece(("wardrobe-with-sliding-doors",), "wall", 0.9),
        Piece(("chair-with-cushion", "modern-armchair", "design-chair"), "wall", 0.7, (
            Piece(("handbag",), "on", 0.5),
        )),
        Piece(("radiator3", "radiator", "radiator2"), "wall", 0.7),
        Piece(("briefcase",), "floor", 0.5),
        Piece(("bootie",), "wall", 0.4),
    ),
    "child's room": (
        Piece(("baby-rocking-bed", "bed1", "bed2"), "wall"),
        Piece(("cupboard",), "wall"),
        Piece(("caballito", "motorbike"), "floor"),
        Piece(("teddy-bear",), "floor", 0.9),
        Piece(("basketball",), "floor", 0.8),
        Piece(("potty",), "wall", 0.6),
        Piece(("box", "ammo-box"), "wall", 0.6),
    ),
    "bathroom": (
        Piece(("toilets-unit",), "wall"),
        Piece(("washbasin", "modern-vanity"), "wall"),
        Piece(("shower-stall",), "wall", 0.9),
        Piece(("bidet",), "wall", 0.6),
        Piece(("towel3", "towel2"), "wall", 0.8),
        Piece(("dustbin",), "wall", 0.5),
    ),
    "office": (
        Piece(("lb-desk", "desk"), "wall", companions=(
            Piece(("armchair",), "before"),
            Piece(LAMPS, "on", 0.8),
            Piece(("locked-locker", "table-fan"), "on", 0.6),
        )),
        Piece(("white-board",), "wall", 0.7),
        Piece(("bookcase", "vertical-shelves"), "wall", 0.8),
        Piece(("crate",), "wall", 0.5, (Piece(("table-fan", "rigged-fan"), "on", 0.7),)),
        Piece(("speaker2",), "floor", 0.4),
        Piece(("briefcase",), "floor", 0.6),
        Piece(("fire-extinguisher",), "wall", 0.4),
    ),
    "hall": (
        Piece(("bench",), "wall"),
        Piece(("umbrella-folded",), "wall"),
        Piece(("fire-extinguisher",), "wall", 0.7),
        Piece(("barrel", "crate"), "wall", 0.5),
        Piece(("bootie",), "wall", 0.6),
        Piece(("stone-lantern", "lantern"), "wall", 0.4),
    ),
}  # fmt: skip

# Where on top there is room, for models of which a part rises above the top: x, y in the model frame [m].
TOP_SPOTS = {"television-cabinet": (-0.25, -0.05), "desk": (-0.1, 0.02)}
