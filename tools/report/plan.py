"""Floor plans as inline SVG: what the robot believes drawn solid, what is true drawn faint."""

import base64
from html import escape
from math import cos, degrees, sin
from pathlib import Path

from tools.report.record import Map, Replan, Run, Search

_MARGIN = 0.3  # m around the house
_NODE = 0.13  # m, length of a node's tick
SHOWN = 5  # viewpoints of a search; more hide one another


class FloorPlan:
    """Draws the run's plans in one coordinate system: metres, x right, y down, (0, 0) the house's upper left."""

    def __init__(self, run: Run, folder: Path):
        self._run, self._folder = run, folder
        corners = [corner for polygon in run.home.rooms.values() for corner in polygon]
        corners += [end for wall in run.home.walls for end in wall]
        xs, ys = zip(*corners) if corners else ((0.0, 1.0), (0.0, 1.0))
        self._left, self._top = min(xs) - _MARGIN, max(ys) + _MARGIN
        self.width, self.height = max(xs) + _MARGIN - self._left, self._top - min(ys) + _MARGIN

    def defs(self) -> str:
        """Shared parts, once a page: the true house, and the grid's cells as masks that the style sheet colours."""
        shared = f'{self._masks()}<g id="truth">{self._truth()}</g>'
        return f'<svg class="defs" aria-hidden="true"><defs>{shared}</defs></svg>'

    def overview(self) -> str:
        """The whole run: map, path, nodes, where things were said to be and where they are."""
        run = self._run
        parts = [self._ground()]
        if run.mapping:
            parts.append(self._line(run.mapping.path, "path"))
        parts += [self._line(search.path, "path") for search in run.searches]
        parts.append("".join(self._tick(node, "node") for node in run.nodes))
        parts.append(self._dock())
        # Labels last, so that nothing is drawn over them.
        parts += [self._answer(search, str(number)) for number, search in enumerate(run.searches, 1)]
        return self._svg("".join(parts), "Floor plan: map, driven path, nodes, objects", "plan limited")

    def search(self, search: Search, number: int) -> str:
        """One object: the ranked viewpoints with the views behind them, the way there, the answer."""
        parts = [self._ground(), self._line(search.path, "path")]
        for rank, hypothesis in reversed(list(enumerate(search.hypotheses[:SHOWN], 1))):
            kind = "best" if rank == 1 else "other"
            parts.append("".join(self._tick(member, f"member {kind}") for member in hypothesis.members))
            parts.append(self._viewpoint(hypothesis.pose, rank, kind))
        if search.pose:
            parts.append(self._robot(search.pose))
        parts.append(self._answer(search, str(number)))
        return self._svg("".join(parts), f"Floor plan of the search for {search.words}")

    def replan(self, replan: Replan, number: int) -> str:
        """One step of a local search: the probability map over the true walls, and the view chosen."""
        grid = replan.probability
        rows, cols = grid.shape
        x0, y0, theta = self._run.home.start
        middle = grid.origin[0] + cols * grid.resolution / 2, grid.origin[1] + rows * grid.resolution / 2
        x, y = self._at(
            x0 + cos(theta) * middle[0] - sin(theta) * middle[1], y0 + sin(theta) * middle[0] + cos(theta) * middle[1]
        )
        side = max(rows, cols) * grid.resolution
        box = f"{x - side / 2:.2f} {y - side / 2:.2f} {side:.2f} {side:.2f}"
        parts = [f'<g class="probability">{self._image(grid)}</g>', '<use href="#truth"/>']
        parts.append(self._viewpoint(replan.pose, number, "best"))
        return self._svg("".join(parts), f"Probability map of replan {number}", "replan", box)

    def _svg(self, content: str, title: str, kind: str = "plan", box: str | None = None) -> str:
        box = box or f"0 0 {self.width:.2f} {self.height:.2f}"
        return f'<svg class="{kind}" viewBox="{box}" role="img" aria-label="{escape(title)}">{content}</svg>'

    def _at(self, x: float, y: float) -> tuple[float, float]:
        return round(x - self._left, 3), round(self._top - y, 3)

    def _points(self, points) -> str:
        return " ".join("{:g},{:g}".format(*self._at(*point)) for point in points)

    def _masks(self) -> str:
        grid = self._run.map
        if grid is None:
            return ""
        image = self._image(grid)
        # The picture's greys 0, 128 and 255 (unknown, free, occupied) become alpha 0 or 1, hard-edged.
        masks = []
        for name, table in (("free", "0 1 0"), ("occupied", "0 0 1")):
            channels = "".join(f'<feFunc{c} type="discrete" tableValues="{table}"/>' for c in "RGB")
            masks.append(
                f'<filter id="only-{name}" x="0" y="0" width="1" height="1" color-interpolation-filters="sRGB">'
                f"<feComponentTransfer>{channels}</feComponentTransfer></filter>"
                f'<mask id="{name}" maskUnits="userSpaceOnUse" x="0" y="0" width="{self.width:.2f}" '
                f'height="{self.height:.2f}"><g filter="url(#only-{name})">{image}</g></mask>'
            )
        return "".join(masks)

    def _image(self, grid: Map) -> str:
        # Grid cells (col right, row up) to the map frame, to the house frame, to the plan: one affine matrix.
        x0, y0, theta = self._run.home.start
        c, s, r = cos(theta), sin(theta), grid.resolution
        e, f = self._at(x0 + c * grid.origin[0] - s * grid.origin[1], y0 + s * grid.origin[0] + c * grid.origin[1])
        matrix = f"matrix({c * r:.5f} {-s * r:.5f} {-s * r:.5f} {-c * r:.5f} {e:.4f} {f:.4f})"
        rows, cols = grid.shape
        return (
            f'<image href="{data_uri(self._folder / grid.picture)}" width="{cols}" height="{rows}" '
            f'transform="{matrix}" preserveAspectRatio="none" style="image-rendering:pixelated"/>'
        )

    def _truth(self) -> str:
        home = self._run.home
        parts = [f'<polygon class="thing" points="{self._points(thing.footprint)}"/>' for thing in home.things]
        parts += [f'<polyline class="wall" points="{self._points(wall)}"/>' for wall in home.walls]
        return "".join(parts)

    def _ground(self) -> str:
        size = f'width="{self.width:.2f}" height="{self.height:.2f}"'
        cells = "".join(f'<rect class="{kind}" {size} mask="url(#{kind})"/>' for kind in ("free", "occupied"))
        names = []
        for name, polygon in self._run.home.rooms.items():
            x, y = self._at(sum(p[0] for p in polygon) / len(polygon), sum(p[1] for p in polygon) / len(polygon))
            names.append(f'<text class="room" x="{x}" y="{y}">{escape(name)}</text>')
        return (cells if self._run.map else "") + '<use href="#truth"/>' + "".join(names)

    def _line(self, points, kind: str) -> str:
        return f'<polyline class="{kind}" points="{self._points(points)}"/>' if len(points) > 1 else ""

    def _tick(self, pose, kind: str) -> str:
        """A dot with a short line in the direction of view."""
        x, y = self._at(pose[0], pose[1])
        dx, dy = round(_NODE * cos(pose[2]), 3), round(-_NODE * sin(pose[2]), 3)
        return f'<path class="{kind}" d="M{x:g} {y:g}l{dx:g} {dy:g}"/>'

    def _dock(self) -> str:
        x, y = self._at(*self._run.home.start[:2])
        return f'<rect class="dock" x="{x - 0.12:.3f}" y="{y - 0.12:.3f}" width="0.24" height="0.24"/>'

    def _viewpoint(self, pose, rank: int, kind: str) -> str:
        x, y = self._at(pose[0], pose[1])
        turn = f"rotate({-degrees(pose[2]):.1f})"
        wedge = "M0 0L0.82 -0.68A1.07 1.07 0 0 1 0.82 0.68Z"  # 79 degrees, 1.07 m
        label = f'<text class="rank" y="0.08">{rank}</text>'
        return (
            f'<g class="viewpoint {kind}" transform="translate({x:g} {y:g})"><path d="{wedge}" transform="{turn}"/>'
            f'<circle r="0.17"/>{label}</g>'
        )

    def _robot(self, pose) -> str:
        x, y = self._at(pose[0], pose[1])
        turn = f"translate({x:g} {y:g}) rotate({-degrees(pose[2]):.1f})"
        return f'<g class="robot" transform="{turn}"><circle r="0.18"/><path d="M0 0H0.3"/></g>'

    def _answer(self, search: Search, label: str) -> str:
        """A ring at each true place; a dot where the robot says that it is, tied to the nearest ring."""
        kind = search.verdict.replace(" ", "-")
        truths = [self._at(*place) for place in search.true_positions]
        parts = [f'<circle class="true" cx="{x}" cy="{y}" r="0.2"/>' for x, y in truths]
        said = self._at(*search.position) if search.position else None
        if said and truths:
            nearest = min(truths, key=lambda place: (place[0] - said[0]) ** 2 + (place[1] - said[1]) ** 2)
            parts.append('<path class="miss" d="M{:g} {:g}L{:g} {:g}"/>'.format(*said, *nearest))
        if said:
            parts.append(f'<circle class="said" cx="{said[0]}" cy="{said[1]}" r="0.17"/>')
            parts.append(f'<text class="number" x="{said[0]}" y="{said[1] + 0.08:.3f}">{label}</text>')
        else:
            parts += [f'<text class="number outside" x="{x}" y="{y + 0.08:.3f}">{label}</text>' for x, y in truths]
        return f'<g class="answer {kind}">{"".join(parts)}</g>'


def data_uri(path: Path) -> str:
    """A picture file as the text that a page can carry in itself. Raises OSError when it cannot be read."""
    kind = "jpeg" if path.suffix in (".jpg", ".jpeg") else path.suffix[1:]
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
