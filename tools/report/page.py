"""The page itself: plain HTML around the plans, the pictures and the tables."""

from html import escape
from math import degrees
from pathlib import Path

from edge.budget import SMALLEST
from tools.report.memory_chart import memory_chart
from tools.report.plan import SHOWN, FloorPlan, data_uri
from tools.report.record import Run, Search
from tools.report.style import CSS


def write_page(run: Run, folder: Path) -> Path:
    """Write ``folder/report.html``, which carries everything in itself; returns its path.

    Raises OSError when a picture that the record names cannot be read from ``folder``.
    """
    path = Path(folder) / "report.html"
    path.write_text(_page(run, Path(folder)), encoding="utf-8")
    return path


def _page(run: Run, folder: Path) -> str:
    plan = FloorPlan(run, folder)
    cards = [_card(search, number, plan, folder) for number, search in enumerate(run.searches, 1)]
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in run.notes)
    return "\n".join(
        [
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(run.home.name)}: vlpg demo, {escape(run.started)}</title>",
            f"<style>{CSS}</style></head><body>{plan.defs()}<main>",
            f"<h1>{escape(_headline(run))}</h1>",
            f'<p class="quiet">{escape(_subtitle(run))}</p>{notes}',
            _outcomes(run.searches),
            "<h2>The home, as the robot knows it</h2>",
            f'<figure class="figure">{plan.overview()}{_LEGEND}</figure>',
            f"<p class='quiet'>{escape(_mapping(run))}</p>",
            "<h2>The searches</h2>" if cards else "",
            *cards,
            "<h2>Memory</h2>",
            _memory(run),
            "<h2>How it was run</h2>",
            _circumstances(run),
            "</main></body></html>",
        ]
    )


def _headline(run: Run) -> str:
    confirmed = sum(search.verdict == "confirmed" for search in run.searches)
    wrong = sum(search.verdict == "wrong" for search in run.searches)
    text = f"{confirmed} of {len(run.searches)} objects found in the {run.home.name}"
    return f"{text}, {wrong} wrongly claimed" if wrong else text


def _subtitle(run: Run) -> str:
    return f"vlpg demo, {run.started.replace('T', ' ')}, {run.wall:.0f} s of wall time"


def _mapping(run: Run) -> str:
    mapping = run.mapping
    if mapping is None:
        return "The home was not mapped."
    whole = "Mapped" if mapping.complete else "Mapped in part"
    return (
        f"{whole}: {mapping.area:.1f} m² of free floor and {mapping.nodes} nodes, in {mapping.duration:.0f} s and "
        f"{mapping.distance:.1f} m of driving ({mapping.wall:.0f} s of wall time)."
    )


def _outcomes(searches: list[Search]) -> str:
    if not searches:
        return "<p>No object was asked for.</p>"
    rows = []
    for number, search in enumerate(searches, 1):
        kind = search.verdict.replace(" ", "-")
        claimed = search.verdict != "no claim" and search.angular_error is not None
        error = f"{abs(degrees(search.angular_error)):.1f}°" if claimed else ""
        rows.append(
            f'<tr><td class="n">{number}</td><td>{escape(search.words)}</td><td>{escape(search.status)}</td>'
            f'<td><b class="{kind}">{search.verdict}</b><br><span class="quiet">{escape(search.remark)}</span></td>'
            f'<td class="n">{error}</td><td class="n">{search.duration:.1f} s</td>'
            f'<td class="n">{search.distance:.1f} m</td></tr>'
        )
    head = (
        '<tr><th class="n">#</th><th>asked for</th><th>robot says</th><th>ground truth says</th>'
        '<th class="n">angular error</th><th class="n">time</th><th class="n">distance</th></tr>'
    )
    return _table("outcomes", head, rows)


def _table(kind: str, head: str, rows: list[str]) -> str:
    body = f"<thead>{head}</thead><tbody>{''.join(rows)}</tbody>"
    return f'<div class="scroll"><table class="{kind}">{body}</table></div>'


def _card(search: Search, number: int, plan: FloorPlan, folder: Path) -> str:
    kind = search.verdict.replace(" ", "-")
    facts = [search.status]
    if search.confidence is not None:
        of = "" if search.status == "found" else " of the best guess"
        facts.append(f"{search.confidence:.0%} sure{of}")
    facts += [f"{search.duration:.1f} s ({search.wall:.0f} s of wall time)", f"{search.distance:.1f} m"]
    viewpoints = len(search.hypotheses)
    ranked = f"{viewpoints} ranked viewpoint{'s' * (viewpoints != 1)}" if viewpoints else "No viewpoint"
    if viewpoints > SHOWN:
        ranked = f"The best {SHOWN} of {ranked}"
    caption = f"{ranked} from memory{', and the way driven' if len(search.path) > 1 else ''}."
    return (
        f'<section class="card"><header><h3>{number}. {escape(search.words)}</h3>'
        f'<b class="{kind}">{search.verdict}</b><span class="quiet">{escape(", ".join(facts))}</span></header>'
        f'<div class="pair"><figure>{_picture(search, folder)}<figcaption>{escape(search.remark)}</figcaption></figure>'
        f"<figure>{plan.search(search, number)}<figcaption>{caption}</figcaption></figure></div>"
        f"{_replans(search, plan)}</section>"
    )


def _replans(search: Search, plan: FloorPlan) -> str:
    if not search.replans:
        return ""
    maps = "".join(plan.replan(replan, step) for step, replan in enumerate(search.replans, 1))
    caption = "The local search, look by look: the brighter, the likelier the object is there; then the view chosen."
    return f'<figure><div class="replans">{maps}</div><figcaption>{caption}</figcaption></figure>'


def _picture(search: Search, folder: Path) -> str:
    if search.picture is None or search.picture_size is None:
        return '<div class="empty">no picture</div>'
    width, height = search.picture_size
    box = ""
    if search.box is not None:
        x0, y0, x1, y1 = search.box
        shape = f'x="{x0:.1f}" y="{y0:.1f}" width="{x1 - x0:.1f}" height="{y1 - y0:.1f}"'
        box = f'<rect class="under" {shape}/><rect {shape}/>'
    return (
        f'<svg class="picture" viewBox="0 0 {width} {height}" role="img" aria-label="the last camera picture">'
        f'<image href="{data_uri(folder / search.picture)}" width="{width}" height="{height}"/>{box}</svg>'
    )


def _memory(run: Run) -> str:
    budget = SMALLEST.peak(text=run.offload != "host")  # in "auto", too, it must have room for its own text tower
    rows = []
    for process in run.processes:
        verdict = ""
        if process.name == "robot":
            kept = process.peak_pss <= budget
            word = "within" if kept else "over"
            verdict = f'<b class="{"confirmed" if kept else "wrong"}">{word} {budget:.0f} MB</b>'
        figures = (process.peak_pss, process.anonymous, process.file_backed, process.peak_rss)
        cells = "".join(f'<td class="n">{figure:.1f}</td>' for figure in figures)
        rows.append(f"<tr><td>{escape(process.name)}</td>{cells}<td>{verdict}</td></tr>")
    head = (
        '<tr><th>process</th><th class="n">peak PSS, MB</th><th class="n">of it anonymous</th>'
        '<th class="n">file-backed</th><th class="n">peak RSS, MB</th><th>budget of the robot</th></tr>'
    )
    source = (
        "1 MB = 10⁶ bytes. From /proc/&lt;pid&gt;/smaps_rollup, twice a second; PSS divides a page by the number of "
        "processes that share it."
    )
    table = f"<p>{_TEXT[run.offload]}</p>{_table('memory', head, rows)}"
    return f'{table}{memory_chart(run.processes, budget)}<p class="quiet">{source}</p>'


_TEXT = {
    "never": "Everything was on board: the robot encoded pictures and text itself.",
    "auto": "The robot encoded pictures itself and left text to the host while that was there.",
    "host": "The robot encoded pictures itself and left all text to the host.",
}


def _circumstances(run: Run) -> str:
    facts = {"command": f"<code>{escape(run.command)}</code>", "seed": str(run.seed)}
    facts["simulated time"] = f"up to {run.speed:g} times as fast as real time"
    facts |= {name: escape(value) for name, value in run.machine.items()}
    facts["versions"] = escape(", ".join(f"{name} {version}" for name, version in run.versions.items()))
    return f"<dl>{''.join(f'<dt>{escape(name)}</dt><dd>{value}</dd>' for name, value in facts.items())}</dl>"


def _key(shape: str, text: str) -> str:
    return f'<span><svg viewBox="0 0 .66 .42">{shape}</svg>{text}</span>'


_LEGEND = (
    '<div class="legend">'
    + _key('<rect class="free" width=".66" height=".42"/>', "free floor in the robot's map")
    + _key('<rect class="occupied" width=".66" height=".42"/>', "occupied in the robot's map")
    + _key('<path class="wall" d="M0 .1H.66"/><path class="thing" d="M.1 .2H.56V.4H.1Z"/>', "true walls and furniture")
    + _key('<path class="path" d="M0 .3L.3 .1L.66 .25"/>', "driven path")
    + _key('<path class="node" d="M.1 .3l.12 -.1M.4 .3l.1 .05"/>', "nodes: place and direction of a remembered view")
    + _key('<circle class="true" cx=".33" cy=".21" r=".17"/>', "where an object truly is")
    + _key('<circle class="said" cx=".33" cy=".21" r=".17"/>', "where the robot says that it is")
    + _key('<rect class="dock" x=".2" y=".08" width=".26" height=".26"/>', "start")
    + "</div>"
)
