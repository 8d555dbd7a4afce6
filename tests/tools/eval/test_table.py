import csv
from dataclasses import replace
from math import exp, radians

import pytest

from tools.eval.chart import draw
from tools.eval.episode import Episode
from tools.eval.table import margins, rows, show, write_csv

RIGHT = Episode(
    home="a", method="vlpg-nav", noun="couch", disturbance="", truth="", toured=True, status="found", success=True,
    cause="", in_view=True, angular_error=radians(9), pixel_error=30.0, score=0.9, remembered=0.8, confidence=0.7,
    duration=20.0, distance=5.0, contacts=0, pose_error=0.03,
)  # fmt: skip
WRONG = replace(RIGHT, success=False, cause="claims another thing", in_view=False, angular_error=2.0, pixel_error=80.0)
SILENT = replace(WRONG, status="not found", cause="looked elsewhere")


@pytest.fixture
def episodes():
    ours = [RIGHT, replace(RIGHT, noun="bed"), replace(WRONG, home="b"), replace(SILENT, home="b", noun="bed")]
    theirs = [replace(WRONG, method="viewpoint", home=e.home, noun=e.noun) for e in ours]
    return ours + theirs


def test_a_row_counts_a_method(episodes):
    ours, theirs = rows(episodes)
    assert (ours.method, ours.episodes, ours.claims, ours.right) == ("vlpg-nav", 4, 3, 2)
    assert ours.success.mean == 0.5 and ours.sae.mean == pytest.approx(exp(-0.01) / 2)
    assert ours.degrees.mean == pytest.approx(9) and ours.pixels.mean == 30  # of the successes alone
    assert ours.causes == {"claims another thing": 1, "looked elsewhere": 1}
    assert theirs.success.mean == 0 and theirs.claims == 4


def test_to_be_right_that_a_thing_is_gone_is_no_claim():
    silent = replace(RIGHT, disturbance="remove", status="not found")
    (row,) = rows([silent, replace(silent, noun="bed"), replace(WRONG, disturbance="remove", noun="cup")])
    assert row.success.mean == pytest.approx(2 / 3) and (row.right, row.claims) == (0, 1)


def test_margins_compare_the_same_questions(episodes):
    success, weighted = margins(episodes)["viewpoint"]
    assert success.mean == 0.5 and (success.low, success.high) == (0.0, 1.0)
    assert weighted.mean == pytest.approx(exp(-0.01) / 2)


def test_margins_hold_what_was_disturbed_against_the_same():
    ours = [RIGHT, replace(RIGHT, disturbance="push"), replace(WRONG, method="viewpoint", disturbance="push")]
    found = margins(ours)
    assert found["viewpoint, push"][0].mean == 1.0  # against vlpg-nav pushed
    assert found["vlpg-nav, push"][0].mean == 0.0  # what the push costs it
    assert "viewpoint" not in found


def test_rows_that_were_told_the_truth_stand_beside_the_one_that_was_not():
    found = margins([WRONG, replace(RIGHT, truth="encoder")])
    assert found["vlpg-nav, true encoder"][0].mean == -1.0  # what the encoder costs


def test_the_text_tells_each_figure(episodes):
    text = show(episodes)
    assert "0.50 [0.00, 1.00]" in text and "2 of 3" in text and "1 looked elsewhere" in text
    assert "+0.50 [+0.00, +1.00] more success" in text


def test_files_hold_every_episode(episodes, tmp_path):
    write_csv(episodes, rows(episodes), tmp_path / "e.csv")
    with (tmp_path / "e.csv").open() as stream:
        read = list(csv.DictReader(stream))
    assert len(read) == 8 and read[0]["noun"] == "couch" and read[2]["cause"] == "claims another thing"
    with (tmp_path / "e-table.csv").open() as stream:
        table = {row["method"]: row for row in csv.DictReader(stream)}
    assert set(table) == {row.method for row in rows(episodes)}
    for row in rows(episodes):
        line = table[row.method]
        assert [float(line[f"sae{end}"]) for end in ("", "_low", "_high")] == [row.sae.mean, row.sae.low, row.sae.high]
        assert line["causes"].count(";") == max(len(row.causes) - 1, 0)
    draw(episodes, tmp_path / "e.png")
    assert (tmp_path / "e.png").read_bytes().startswith(b"\x89PNG")
