import hashlib
import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from models.manifest import ModelError
from tools.models.hub import Repository, endpoint, offline

COMMIT = "0123456789abcdef0123456789abcdef01234567"


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


class _Hub(BaseHTTPRequestHandler):
    """As much of a hub's interface as huggingface_hub asks for, with one repository, me/toy."""

    FILES = {"config.json": b'{"model_type": "clip"}', "README.md": b"# toy", "tf_model.h5": b"h5"}
    FILES |= {"model.safetensors": b"weights", "pytorch_model.bin": b"the same weights"}

    def do_HEAD(self):
        self._answer(body=False)

    def do_GET(self):
        self._answer(body=True)

    def _answer(self, body):
        self.server.asked.append((self.path, self.headers["Authorization"]))
        if self.path.startswith("/api/models/me/toy/tree/"):
            files = [{"type": "file", "path": name, "size": len(f), "oid": _oid(f)} for name, f in self.FILES.items()]
            return self._send(json.dumps(files).encode(), body)
        if self.path.startswith("/api/models/me/toy"):
            content = json.dumps({"id": "me/toy", "sha": COMMIT, "siblings": [{"rfilename": n} for n in self.FILES]})
            return self._send(content.encode(), body)
        name = self.path.rpartition("/")[2]
        if self.path.startswith("/me/toy/resolve/") and name in self.FILES:
            return self._send(self.FILES[name], body)
        self.send_response(404)
        self.send_header("X-Error-Code", "RepoNotFound")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def _send(self, content, body):
        self.send_response(200)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("ETag", _oid(content))
        self.send_header("X-Repo-Commit", COMMIT)
        self.end_headers()
        if body:
            self.wfile.write(content)

    def log_message(self, *arguments):
        pass


def _oid(content):
    return hashlib.sha1(b"blob %d\0" % len(content) + content).hexdigest()


@pytest.fixture
def server(monkeypatch, tmp_path):
    """A hub on the loopback interface, and an empty cache."""
    constants = pytest.importorskip("huggingface_hub.constants")
    hub = ThreadingHTTPServer(("127.0.0.1", 0), _Hub)
    hub.daemon_threads, hub.asked = True, []
    thread = threading.Thread(target=hub.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    monkeypatch.setenv("HF_ENDPOINT", f"http://127.0.0.1:{hub.server_address[1]}")
    monkeypatch.setenv("HF_TOKEN", "secret")
    monkeypatch.delenv("HF_HUB_OFFLINE", raising=False)
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
    yield hub
    hub.shutdown()
    thread.join()
    hub.server_close()


def test_a_snapshot_comes_from_hub_or_cache(server, monkeypatch):
    folder = Repository("me/toy").snapshot()
    assert {path.name for path in folder.iterdir()} == {"config.json", "README.md", "model.safetensors"}
    assert json.loads((folder / "config.json").read_text()) == {"model_type": "clip"}
    assert {authorization for _, authorization in server.asked} == {"Bearer secret"}
    server.asked.clear()
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    assert Repository("me/toy").snapshot() == folder
    assert server.asked == []


def test_what_a_hub_does_not_have(server):
    with pytest.raises(ModelError, match="does not give me/nothing .404.; check the name"):
        Repository("me/nothing").snapshot()


def test_a_snapshot_that_is_not_in_the_cache(server, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    with pytest.raises(ModelError, match="HF_HUB_OFFLINE is set, so me/toy is not fetched"):
        Repository("me/toy").snapshot()
    monkeypatch.delenv("HF_HUB_OFFLINE")
    monkeypatch.setenv("HF_ENDPOINT", "http://127.0.0.1:1")
    with pytest.raises(ModelError, match="cannot be reached and me/toy is not in the cache"):
        Repository("me/toy").snapshot()
