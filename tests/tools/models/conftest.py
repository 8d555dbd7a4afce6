"""A shelf of the test's own, a small finished model, and a web server that knows ranges and can be made to fail."""

import hashlib
import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

FIELDS = {
    "name": "toy",
    "dim": 4,
    "logit_scale": 100.0,
    "image": {
        "graph": "image.onnx", "saliency": "saliency.onnx", "height": 8, "width": 8,
        "mean": [0.5] * 3, "std": [0.5] * 3, "regions": [[0.0, 1.0]],
    },
    "text": {"graph": "text.onnx", "tokenizer": "tokenizer.json", "context_length": 16},
    "relevance": {"slope": 1.0, "offset": 0.0},
    "source": "the tests", "licence": "CC0-1.0", "measured": {"image_ms": 1.5},
}  # fmt: skip


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """The user's model folder, empty; not made yet."""
    folder = tmp_path / "shelf"
    monkeypatch.setenv("VLPG_MODELS", str(folder))
    return folder


@pytest.fixture
def toy(tmp_path):
    """A whole model folder, but for graphs that could run."""
    folder = tmp_path / "toy"
    folder.mkdir()
    files = []
    for i, name in enumerate(("image.onnx", "saliency.onnx", "text.onnx", "tokenizer.json")):
        content = bytes(range(256)) * (100 + 1000 * i)
        (folder / name).write_bytes(content)
        files.append({"name": name, "sha256": hashlib.sha256(content).hexdigest(), "size": len(content)})
    (folder / "manifest.json").write_text(json.dumps(FIELDS | {"files": files}))
    (folder / "MODEL_CARD.md").write_text("# toy\n")
    return folder


class Server(ThreadingHTTPServer):
    """Serves ``folder`` on a free port of the loopback interface.

    ``asked`` has (path, Range, Authorization) of each request. ``cuts`` {path: bytes, ...} ends each next answer for a
    path after so many bytes, once. ``ranges`` switches resumption off; ``redirect`` sends on to another server.
    """

    daemon_threads = True

    def __init__(self, folder):
        super().__init__(("127.0.0.1", 0), _Handler)
        self.folder, self.asked, self.cuts, self.ranges, self.redirect, self.status = folder, [], {}, True, None, None

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_address[1]}"


class _Handler(BaseHTTPRequestHandler):
    def do_GET(self):
        server, path = self.server, self.path.lstrip("/")
        server.asked.append((path, self.headers["Range"], self.headers["Authorization"]))
        file = server.folder / path
        if server.redirect:
            self.send_response(302)
            self.send_header("Location", f"{server.redirect}/{path}")
            return self.end_headers()
        if server.status or not file.is_file():
            return self.send_error(server.status or 404)
        content, start = file.read_bytes(), 0
        if self.headers["Range"] and server.ranges:
            start = int(self.headers["Range"].removeprefix("bytes=").rstrip("-"))
            if start >= len(content):
                return self.send_error(416)
        self.send_response(206 if start else 200)
        self.send_header("Content-Length", str(len(content) - start))
        self.end_headers()
        cut = server.cuts.get(path)
        if cut:
            self.wfile.write(content[start : start + cut.pop(0)])
            if not cut:
                del server.cuts[path]
            self.close_connection = True
        else:
            self.wfile.write(content[start:])

    def log_message(self, *arguments):
        pass


@pytest.fixture
def serve(monkeypatch):
    """Starts a ``Server`` for a folder."""
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    for name in ("HF_HUB_OFFLINE", "HF_ENDPOINT", "HF_TOKEN"):
        monkeypatch.delenv(name, raising=False)
    running = []

    def start(folder):
        server = Server(folder)
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        running.append((server, thread))
        return server

    yield start
    for server, thread in running:
        server.shutdown()
        thread.join()
        server.server_close()
