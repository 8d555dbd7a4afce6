"""What a folder may not ask for."""

import json

import pytest

pytest.importorskip("open_clip")

from models.manifest import ModelError  # noqa: E402
from tools.models.openclip import from_folder  # noqa: E402


@pytest.mark.parametrize("key", ["trust_remote_code", "trust\\u005fremote_code"])
def test_a_model_that_would_run_code_of_its_own_is_refused_however_it_is_spelt(tmp_path, key):
    config = json.dumps({"model_cfg": {"text_cfg": {"tokenizer_kwargs": {"KEY": True}}}}).replace("KEY", key)
    (tmp_path / "open_clip_config.json").write_text(config)
    with pytest.raises(ModelError, match="run code of its own"):
        from_folder(tmp_path, "someone/something", "")
