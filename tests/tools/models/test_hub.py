import pytest

from tools.models.hub import Repository, endpoint, offline


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("me/toy", Repository("me/toy")),
        ("me/toy@v2", Repository("me/toy", "v2")),
        ("me/toy@refs/pr/1", Repository("me/toy", "refs/pr/1")),
        ("toy", None),
        ("a/b/c", None),
        ("me/tö", None),
        ("me/toy@", None),
    ],
)
def test_a_repositorys_name(text, expected):
    assert Repository.parse(text) == expected
    assert expected is None or str(expected) == text


def test_the_environment_says_where_the_hub_is(monkeypatch):
    monkeypatch.setenv("HF_ENDPOINT", "http://mirror/")
    assert Repository("me/toy").url() == "http://mirror/me/toy/resolve/main"
    monkeypatch.setenv("HF_ENDPOINT", "")
    assert endpoint() == "https://huggingface.co"


@pytest.mark.parametrize(("value", "expected"), [("1", True), ("true", True), ("YES", True), ("0", False), ("", False)])
def test_offline_mode(monkeypatch, value, expected):
    monkeypatch.setenv("HF_HUB_OFFLINE", value)
    assert offline() == expected
