import json

import msgspec
import pytest

from tools.report.record import Run


def test_what_is_saved_is_loaded(run, tmp_path):
    run.save(tmp_path)
    assert Run.load(tmp_path) == run


def test_the_file_is_plain_json(run, tmp_path):
    data = json.loads(run.save(tmp_path).read_text())
    assert [search["verdict"] for search in data["searches"]] == ["confirmed", "wrong", "no claim"]
    assert data["processes"][1]["peak_pss"] == 131.2


def test_another_json_file_is_refused(tmp_path):
    (tmp_path / "report.json").write_text('{"started": 3}')
    with pytest.raises(msgspec.ValidationError):
        Run.load(tmp_path)
