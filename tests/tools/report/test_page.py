import base64
from html.parser import HTMLParser

import pytest
from msgspec.structs import replace

from tools.report.page import write_page

VOID = {"meta", "br", "img", "link", "hr", "input"}


class Outline(HTMLParser):
    """Checks that tags nest, and keeps text and attributes."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.text, self.images = [], [], [], []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag == "image":
            self.images.append(dict(attributes)["href"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.text.append(data)


@pytest.fixture
def page(run, tmp_path):
    outline = Outline()
    outline.source = write_page(run, tmp_path).read_text()
    outline.feed(outline.source)
    outline.close()
    outline.words = " ".join(outline.text)
    return outline


def test_tags_nest_and_nothing_is_left_open(page):
    assert page.open == []


def test_says_what_happened(page):
    assert "1 of 3 objects found in the cottage, 1 wrongly claimed" in page.words
    for text in ("teddy bear", "21.5 s", "7.2 m", "1.8°", "confirmed", "wrong", "no claim", "not in memory"):
        assert text in page.words
    assert "36.0 m² of free floor and 3 nodes" in page.words
    assert "Time ran out: 1 object was not asked for." in page.words


def test_states_the_memory_of_each_process_against_the_budget(page):
    for text in ("sim", "robot", "host", "131.2", "98.1", "33.1", "within 170 MB"):
        assert text in page.words


def test_states_how_it_was_run(page):
    for text in ('vlpg demo --object "teddy bear"', "Example CPU, 2 cores", "python 3.11.7", "seed"):
        assert text in page.words


def test_escapes_what_the_user_asked_for(page):
    assert "script" not in page.tags
    assert "<script>alert(1)</script> & co" in page.words


def test_carries_its_pictures_and_needs_no_network(page, tmp_path):
    jpeg = base64.b64encode((tmp_path / "picture-1.jpg").read_bytes()).decode()
    assert f"data:image/jpeg;base64,{jpeg}" in page.images
    assert all(href.startswith("data:image/") for href in page.images)
    assert "http://" not in page.source and "https://" not in page.source and "url(http" not in page.source


def test_shows_each_replan_of_a_local_search(page, tmp_path):
    likely = base64.b64encode((tmp_path / "replan.png").read_bytes()).decode()
    assert page.images.count(f"data:image/png;base64,{likely}") == 2  # of the two searches that looked around
    assert "The local search, look by look" in page.words


def test_a_robot_over_budget_is_said_to_be(run, tmp_path):
    heavy = replace(run.processes[1], peak_pss=171.0)
    run = replace(run, processes=[heavy])
    assert "over 170 MB" in write_page(run, tmp_path).read_text()


def test_a_robot_that_leaves_text_to_the_host_has_a_smaller_budget(run, tmp_path):
    text = write_page(replace(run, offload="host"), tmp_path).read_text()
    assert "over 130 MB" in text and "left all text to the host" in text


def test_a_run_that_broke_off_early_still_has_a_page(run, tmp_path):
    run = replace(run, map=None, mapping=None, nodes=[], searches=[], processes=[])
    assert "The home was not mapped." in write_page(run, tmp_path).read_text()
