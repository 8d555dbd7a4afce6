"""The page's style sheet: light and dark by the reader's setting, plain on paper."""

CSS = """
:root { color-scheme: light dark;
  --page:#fff; --text:#1c1e21; --quiet:#5f6670; --rule:#d9dce1; --panel:#f5f6f8;
  --free:#e9edf2; --occupied:#39414d; --truth:#c2a36b; --path:#2f6fde; --node:#7a5bd0;
  --good:#1a7f45; --bad:#c62f2f; --none:#6b7280; --on:#fff; --box:#ffd60a; }
@media (prefers-color-scheme: dark) { :root {
  --page:#15171a; --text:#e6e8eb; --quiet:#9aa3ae; --rule:#34393f; --panel:#1d2024;
  --free:#2a3038; --occupied:#b4bdc9; --truth:#a5853f; --path:#6ea2ff; --node:#b19af5;
  --good:#4cc27e; --bad:#ff6f6a; --none:#98a1ad; --on:#101214; } }
@media print { :root { color-scheme: light; } .card { break-inside: avoid; } }
* { box-sizing: border-box; }
body { margin:0; background:var(--page); color:var(--text);
  font:16px/1.5 system-ui,-apple-system,"Segoe UI",sans-serif; }
main { max-width:1080px; margin:0 auto; padding:32px 20px 64px; }
h1 { font-size:1.7rem; line-height:1.25; margin:0 0 4px; } h2 { font-size:1.2rem; margin:40px 0 12px; }
h3 { font-size:1.05rem; margin:0; }
p { margin:0 0 10px; max-width:46rem; } .figure + p { margin-top:10px; } .quiet { color:var(--quiet); }
.note { border-left:4px solid var(--bad); padding:6px 12px; background:var(--panel); max-width:none; }
.scroll { overflow-x:auto; } .scroll table { min-width:42rem; }
table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums; }
th,td { text-align:left; padding:7px 14px 7px 0; border-bottom:1px solid var(--rule); vertical-align:top; }
th { font-weight:600; font-size:.85rem; color:var(--quiet); } td.n,th.n { text-align:right; white-space:nowrap; }
.confirmed { color:var(--good); } .wrong { color:var(--bad); } .no-claim { color:var(--none); }
b.confirmed,b.wrong,b.no-claim { font-weight:600; white-space:nowrap; }
figure { margin:0; } figcaption { font-size:.85rem; color:var(--quiet); padding-top:6px; }
.figure { border:1px solid var(--rule); border-radius:8px; padding:10px; background:var(--page); }
.legend { display:flex; flex-wrap:wrap; gap:4px 18px; font-size:.85rem; color:var(--quiet); padding-top:8px; }
.legend svg { width:22px; height:14px; vertical-align:-2px; margin-right:5px; }
.card { border:1px solid var(--rule); border-radius:8px; padding:14px; margin-bottom:18px; }
.card header { display:flex; flex-wrap:wrap; gap:2px 14px; align-items:baseline; margin-bottom:10px; }
.pair { display:grid; grid-template-columns:1fr 1fr; gap:14px; align-items:start; }
@media (max-width:720px) { .pair { grid-template-columns:1fr; } }
.picture { display:block; width:100%; height:auto; border-radius:6px; background:var(--panel); }
.picture rect { fill:none; stroke:var(--box); stroke-width:2.5; } .picture rect.under { stroke:#000; stroke-width:4.5; }
.replans { display:grid; grid-template-columns:repeat(auto-fill,minmax(150px,1fr)); gap:8px; padding-top:14px; }
svg.replan { display:block; width:100%; border-radius:6px; background:#000; }
svg.replan .viewpoint path { opacity:.5; } svg.replan .viewpoint circle { fill:var(--bad); }
.empty { background:var(--panel); border-radius:6px; padding:60px 14px; text-align:center; color:var(--quiet); }
svg.defs { position:absolute; width:0; height:0; } svg.plan { display:block; width:100%; height:auto; }
svg.plan.limited { max-height:720px; }
.free { fill:var(--free); } .occupied { fill:var(--occupied); }
.wall { stroke:var(--truth); stroke-width:.045; fill:none; opacity:.8; }
.thing { fill:none; stroke:var(--truth); stroke-width:.02; opacity:.75; }
.room { font-size:.26px; fill:var(--quiet); text-anchor:middle; }
.room,.number.outside { paint-order:stroke; stroke:var(--free); stroke-width:.09; stroke-linejoin:round; }
.path { fill:none; stroke:var(--path); stroke-width:.045; stroke-linejoin:round; opacity:.75; }
.node { fill:none; stroke:var(--node); stroke-width:.035; stroke-linecap:round; opacity:.8; }
.dock { fill:none; stroke:var(--text); stroke-width:.045; }
.member { fill:none; stroke-width:.05; stroke-linecap:round; stroke:var(--node); } .member.other { opacity:.45; }
.viewpoint path { fill:var(--node); opacity:.18; } .viewpoint circle { fill:var(--node); }
.viewpoint.other circle { opacity:.6; } .viewpoint.other path { opacity:.09; }
.rank,.number { font-size:.24px; font-weight:700; text-anchor:middle; fill:var(--on); }
.robot circle { fill:var(--path); } .robot path { stroke:var(--path); stroke-width:.08; stroke-linecap:round; }
.answer { color:var(--none); } .answer.confirmed { color:var(--good); } .answer.wrong { color:var(--bad); }
.true { fill:none; stroke:currentColor; stroke-width:.05; } .said { fill:currentColor; }
.miss { stroke:currentColor; stroke-width:.04; stroke-dasharray:.1 .07; } .number.outside { fill:currentColor; }
.chart { display:block; width:100%; height:auto; margin-top:12px; }
.chart text { font-size:12px; fill:var(--quiet); } .chart .axis { stroke:var(--rule); }
.chart .budget { stroke:var(--bad); stroke-dasharray:5 4; } .chart polyline { fill:none; stroke-width:2; }
.s0 { stroke:var(--path); } .s1 { stroke:var(--node); } .s2 { stroke:var(--none); }
code { font-family:ui-monospace,Menlo,Consolas,monospace; font-size:.88em; overflow-wrap:anywhere; }
dl { display:grid; grid-template-columns:max-content 1fr; gap:3px 18px; margin:0; }
dt { color:var(--quiet); } dd { margin:0; }
"""
