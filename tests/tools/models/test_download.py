import hashlib

import pytest

from models.manifest import File, ModelError
from tools.models.download import TRIES, Missing, download, read

CONTENT = bytes(i * i % 251 for i in range(300_000))
FILE = File("weights.bin", hashlib.sha256(CONTENT).hexdigest(), len(CONTENT))


@pytest.fixture
def server(serve, tmp_path):
    (tmp_path / "served").mkdir()
    (tmp_path / "served" / FILE.name).write_bytes(CONTENT)
    return serve(tmp_path / "served")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "got").mkdir()
    return tmp_path / "got"


def fetch(server, folder, **options):
    download(f"{server.url}/{FILE.name}", folder, FILE, **options)


def test_a_whole_file(server, folder):
    seen = []
    fetch(server, folder, progress=seen.append)
    assert (folder / FILE.name).read_bytes() == CONTENT
    assert seen == sorted(seen) and seen[-1] == len(CONTENT)
    assert [path.name for path in folder.iterdir()] == [FILE.name]


def test_a_broken_connection_is_resumed_where_it_was(server, folder):
    server.cuts[FILE.name] = [1000, 50_000]
    fetch(server, folder)
    assert (folder / FILE.name).read_bytes() == CONTENT
    assert [asked for _, asked, _ in server.asked] == [None, "bytes=1000-", "bytes=51000-"]


def test_the_next_call_goes_on_where_the_last_one_gave_up(server, folder):
    server.cuts[FILE.name] = [1000] * TRIES
    with pytest.raises(ModelError, match="broke.*run the command again"):
        fetch(server, folder)
    assert (folder / "weights.bin.part").stat().st_size == 1000 * TRIES
    fetch(server, folder)
    assert (folder / FILE.name).read_bytes() == CONTENT
    assert server.asked[-1][1] == f"bytes={1000 * TRIES}-"


def test_a_server_without_ranges_starts_over(server, folder):
    server.ranges, server.cuts[FILE.name] = False, [1000]
    fetch(server, folder)
    assert (folder / FILE.name).read_bytes() == CONTENT


def test_what_is_there_is_not_fetched_again(server, folder):
    fetch(server, folder)
    seen = []
    fetch(server, folder, progress=seen.append)
    assert len(server.asked) == 1 and seen == [FILE.size]


@pytest.mark.parametrize("content", [CONTENT[:-1] + b"x", CONTENT + b"more", CONTENT[:-1], b""])
def test_a_damaged_file_is_not_kept(server, folder, content):
    (server.folder / FILE.name).write_bytes(content)
    with pytest.raises(ModelError, match="damaged"):
        fetch(server, folder)
    assert list(folder.iterdir()) == []


def test_a_file_of_another_version_that_was_begun_is_found_out(server, folder):
    (folder / "weights.bin.part").write_bytes(b"old" * 1000)
    with pytest.raises(ModelError, match="damaged"):
        fetch(server, folder)
    fetch(server, folder)
    assert (folder / FILE.name).read_bytes() == CONTENT


def test_a_file_that_became_shorter_than_what_is_there(server, folder):
    (folder / "weights.bin.part").write_bytes(CONTENT[:1000])
    (server.folder / FILE.name).write_bytes(CONTENT[:500])
    with pytest.raises(ModelError, match="was changed"):
        fetch(server, folder)
    assert list(folder.iterdir()) == []


def test_an_empty_file(server, folder):
    (server.folder / "empty").write_bytes(b"")
    download(f"{server.url}/empty", folder, File("empty", hashlib.sha256(b"").hexdigest(), 0))
    assert (folder / "empty").read_bytes() == b""


@pytest.mark.parametrize(("status", "words"), [(404, "There is no"), (401, "HF_TOKEN"), (403, "TOKEN"), (500, "500")])
def test_refusals_are_one_sentence(server, folder, status, words):
    server.status = status
    with pytest.raises(ModelError, match=words):
        fetch(server, folder)


def test_the_token_is_not_passed_on_to_another_server(server, serve, folder):
    first = serve(server.folder)
    first.redirect = server.url
    fetch(first, folder, token="secret")
    assert first.asked[0][2] == "Bearer secret" and server.asked[0][2] is None


@pytest.mark.parametrize("url", ["http://127.0.0.1:1/x", "http://host.invalid/x", "http://", "https://[/", "nonsense"])
def test_what_cannot_be_reached_is_one_sentence(url):
    with pytest.raises(ModelError, match="cannot be reached"):
        read(url)


def test_a_description_has_a_size(server):
    assert len(read(f"{server.url}/{FILE.name}")) == len(CONTENT)
    with pytest.raises(ModelError, match="larger than"):
        read(f"{server.url}/{FILE.name}", limit=1000)
    with pytest.raises(Missing):
        read(f"{server.url}/nothing")
