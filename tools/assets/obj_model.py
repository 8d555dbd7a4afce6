"""Wavefront OBJ + MTL models of a furniture library as triangles in metres, in the furniture frame.

The furniture frame: origin at the centre of the bounding box on its base plane, x to the right (width), y to the back
(depth; the front faces -y), z up.
"""

from dataclasses import dataclass
from pathlib import PurePosixPath

import cv2
import numpy as np

from tools.assets.catalog import Entry, Library

CREASE = np.cos(np.radians(60.0))  # corners sharper than this stay sharp under smooth shading
MAX_TEXTURE = 1024  # px, longer side; no render is larger


@dataclass(frozen=True)
class Material:
    """How a surface looks: a texture, or else one colour."""

    colour: np.ndarray  # (3,) RGB in 0..1
    opacity: float = 1.0
    texture: np.ndarray | None = None  # (h, w, 4) RGBA uint8, first row at the top


@dataclass(frozen=True)
class Mesh:
    """Triangles with everything a renderer needs."""

    corners: np.ndarray  # (T, 3, 3) m
    normals: np.ndarray  # (T, 3, 3) unit
    uv: np.ndarray  # (T, 3, 2), v up
    material: np.ndarray  # (T,) index into `materials`
    materials: list[Material]
    size: tuple[float, float, float]  # width, depth, height, m


def load_mesh(library: Library, entry: Entry) -> Mesh:
    """The model of ``entry``, rotated and scaled as its catalog says. Raises ValueError when it holds no faces."""
    folder = PurePosixPath(entry.model).parent
    text = library.read(entry.model).decode("latin-1")
    vertices, uvs, normals, faces, names, library_file = _parse_obj(text)
    if not faces:
        raise ValueError(f"{entry.model} in {library.path} holds no faces.")
    known = _parse_mtl(library, folder, library_file)
    materials = [known.get(name, Material(np.full(3, 0.7))) for name in names]

    points = vertices @ entry.rotation.T
    used = points[np.unique(np.concatenate([face[0] for face in faces]))]
    low, high = used.min(0), used.max(0)
    extent = np.maximum(high - low, 1e-9)
    width, depth, height = entry.size
    scale = np.array([width, height, depth]) / extent
    points = (points - [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]) * scale
    points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)
    if len(normals):
        normals = (normals @ entry.rotation.T) / scale
        normals = np.stack([normals[:, 0], -normals[:, 2], normals[:, 1]], 1)

    index, uv_index, normal_index, material, smooth = _triangles(faces, points)
    corners = points[index]
    uv = np.where(uv_index[..., None] >= 0, uvs[uv_index] if len(uvs) else 0.0, 0.0)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    shading = _normals(flat, index, normal_index, normals, smooth)
    return Mesh(
        corners.astype(np.float32), shading.astype(np.float32), uv.astype(np.float32), material, materials, entry.size
    )


def _parse_obj(text: str):
    """Vertices (V, 3), texture coordinates (U, 2), normals (N, 3), faces, material names, name of the MTL file.

    A face is (vertex indices, uv indices or None, normal indices or None, material, smoothing group or 0).
    """
    rows = {"v": [], "vt": [], "vn": []}
    faces, names, library_file = [], {}, ""
    material = names.setdefault("", 0)
    smooth = 0
    for line in text.splitlines():
        kind, _, rest = line.strip().partition(" ")
        if kind in rows:
            rows[kind].append(rest.split()[: 2 if kind == "vt" else 3])
        elif kind == "f":
            parts = [part.split("/") for part in rest.split()]
            if len(parts) < 3:
                continue
            indices = [np.array([_index(p[0], len(rows["v"])) for p in parts]), None, None]
            for slot, table in ((1, "vt"), (2, "vn")):
                if all(len(p) > slot and p[slot] for p in parts):
                    indices[slot] = np.array([_index(p[slot], len(rows[table])) for p in parts])
            faces.append((*indices, material, smooth))
        elif kind == "usemtl":
            material = names.setdefault(rest.strip(), len(names))
        elif kind == "s":
            value = rest.strip()
            smooth = 0 if value in ("off", "0", "") else int(value) if value.isdigit() else 1
        elif kind == "mtllib":
            library_file = rest.strip()
    vertices = np.array(rows["v"], float).reshape(-1, 3)
    uvs = np.array([r if len(r) == 2 else [r[0], 0.0] for r in rows["vt"]], float).reshape(-1, 2)
    return vertices, uvs, np.array(rows["vn"], float).reshape(-1, 3), faces, list(names), library_file


def _index(text: str, count: int) -> int:
    """OBJ counts from 1, or backwards from the end with negative numbers."""
    number = int(text)
    return number - 1 if number > 0 else count + number


def _parse_mtl(library: Library, folder: PurePosixPath, name: str) -> dict[str, Material]:
    try:
        text = library.read(str(folder / name)).decode("latin-1")
    except KeyError:
        return {}
    found, current = {}, None
    for line in text.splitlines():
        kind, _, rest = line.strip().partition(" ")
        if kind == "newmtl":
            current = found.setdefault(rest.strip(), {})
        elif current is not None and kind in ("Kd", "Ks", "d", "map_Kd", "map_d"):
            current[kind] = rest.strip()
    images: dict[str, np.ndarray | None] = {}
    return {key: _material(library, folder, values, images) for key, values in found.items()}


def _material(library: Library, folder: PurePosixPath, values: dict[str, str], images: dict) -> Material:
    def numbers(key: str, default: list[float]) -> np.ndarray:
        try:
            return np.array(values[key].split()[:3], float)
        except (KeyError, ValueError):
            return np.array(default)

    diffuse, specular = numbers("Kd", [0.7] * 3), numbers("Ks", [0.0] * 3)
    # Chrome and glass come as black with a strong highlight; there is nothing to mirror here, so part of it is diffuse.
    colour = np.clip(diffuse + 0.35 * specular * (diffuse.max() < 0.2), 0, 1)
    opacity = float(numbers("d", [1.0])[0])
    texture = None
    if "map_Kd" in values:
        texture = _image(library, folder, values["map_Kd"], images)
        if texture is not None and "map_d" in values:
            mask = _image(library, folder, values["map_d"], images)
            if mask is not None and values["map_d"] != values["map_Kd"]:
                mask = cv2.resize(mask, texture.shape[1::-1], interpolation=cv2.INTER_AREA)
                texture = np.dstack([texture[..., :3], mask[..., :3].max(2)])
    return Material(colour, opacity, texture)


def _image(library: Library, folder: PurePosixPath, name: str, images: dict) -> np.ndarray | None:
    """Texture (h, w, 4) RGBA, or None when the library does not hold it or it cannot be decoded."""
    if name not in images:
        images[name] = None
        plain = name.replace("\\", "/")
        for candidate in (folder / plain, folder / PurePosixPath(plain.split()[-1]).name):  # the latter drops options
            try:
                data = library.read(str(candidate))
            except KeyError:
                continue
            image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
            if image is not None:
                images[name] = _rgba(image)
                break
    return images[name]


def _rgba(image: np.ndarray) -> np.ndarray:
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2RGBA)
    else:
        image = cv2.cvtColor(image, cv2.COLOR_BGRA2RGBA if image.shape[2] == 4 else cv2.COLOR_BGR2RGBA)
    factor = MAX_TEXTURE / max(image.shape[:2])
    return image if factor >= 1 else cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


def _triangles(faces: list, points: np.ndarray):
    """Vertex, uv and normal indices (T, 3) with -1 = none, material (T,), smoothing group (T,)."""
    index, uv, normal, material, smooth = [], [], [], [], []
    for vertices, uvs, normals, mat, group in faces:
        for corners in _cut(points[vertices]) if len(vertices) > 3 else ([0, 1, 2],):
            index.append(vertices[corners])
            uv.append(uvs[corners] if uvs is not None else (-1, -1, -1))
            normal.append(normals[corners] if normals is not None else (-1, -1, -1))
            material.append(mat)
            smooth.append(group)
    return np.array(index), np.array(uv), np.array(normal), np.array(material, np.int32), np.array(smooth)


def _cut(polygon: np.ndarray) -> list[list[int]]:
    """Triangulate a planar polygon (N, 3) by clipping ears; convex ones become a fan."""
    count = len(polygon)
    ahead = np.roll(polygon, -1, 0)
    normal = np.cross(polygon, ahead).sum(0)
    axis = int(np.argmax(np.abs(normal)))
    flat = np.delete(polygon, axis, 1)
    if (normal[axis] < 0) != (axis == 1):
        flat = flat * [-1, 1]  # counter-clockwise, so that convex corners turn left
    step = np.roll(flat, -1, 0) - flat
    before = np.roll(step, 1, 0)
    turn = before[:, 0] * step[:, 1] - before[:, 1] * step[:, 0]
    left = list(range(count))
    if (turn >= 0).all():
        return [[0, i, i + 1] for i in range(1, count - 1)]
    triangles = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _area(flat[a], flat[b], flat[c]) <= 0:
                continue
            if not any(_inside(flat[p], flat[a], flat[b], flat[c]) for p in left if p not in (a, b, c)):
                break
        else:
            a, b, c, k = left[-1], left[0], left[1], 0  # degenerate: cut anything
        triangles.append([a, b, c])
        del left[k]
    return [*triangles, left]


def _area(a, b, c) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _inside(p, a, b, c) -> bool:
    return _area(a, b, p) >= 0 and _area(b, c, p) >= 0 and _area(c, a, p) >= 0


def _normals(flat, index, normal_index, given, smooth) -> np.ndarray:
    """Corner normals (T, 3, 3): the file's; else smoothed over the smoothing group; else the triangle's own."""
    own = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    key = index.astype(np.int64) * (smooth.max() + 1) + smooth[:, None]
    unique, inverse = np.unique(key, return_inverse=True)
    sums = np.zeros((len(unique), 3))
    np.add.at(sums, inverse.reshape(-1), np.repeat(flat, 3, 0))
    smoothed = sums[inverse.reshape(index.shape)]
    smoothed /= np.maximum(np.linalg.norm(smoothed, axis=2, keepdims=True), 1e-12)
    sharp = ((smoothed * own[:, None]).sum(2) < CREASE) | (smooth == 0)[:, None]
    result = np.where(sharp[..., None], own[:, None], smoothed)
    if len(given):
        read = given[normal_index]
        length = np.linalg.norm(read, axis=2, keepdims=True)
        good = (normal_index >= 0)[..., None] & (length > 1e-9)
        result = np.where(good, read / np.maximum(length, 1e-12), result)
    return result
