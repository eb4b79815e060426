"""The site of the docs: broken links within it are found, and it is served on this machine alone."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """Return a site of two pages, whose links lead somewhere."""
    (tmp_path / "guide").mkdir()
    (tmp_path / "picture.png").write_bytes(b"")
    (tmp_path / "index.html").write_text(
        '<a href="guide/">a folder</a> <a href="guide/index.html#start">an anchor</a> <img src="picture.png">'
        '<a href="https://example.org/#x">elsewhere</a> <a href="?q=1">itself</a> <h1 id="top">Title</h1>'
    )
    (tmp_path / "guide" / "index.html").write_text('<h1 id="start">Start</h1> <a href="../index.html#top">back</a>')
    return tmp_path


def test_links_of_a_site(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    from site_links import broken_links

    assert broken_links(site) == []
    (site / "guide" / "index.html").write_text('<a href="../no.html">1</a><a href="#no">2</a><script src="no.js">')
    assert broken_links(site) == [
        "guide/index.html: ../no.html",
        "guide/index.html: #no",
        "guide/index.html: no.js",
        "index.html: guide/index.html#start",
    ]


def test_the_search_finds_pages_by_other_words(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    from search_words import OF_PAGES, words_of

    assert words_of("gallery", "Fibres in the centres of tracts") == ["center", "fiber"]
    assert words_of("guide", "A needle") == ["tractography", "ROI", "biopsy"]
    assert words_of("guide", "Tractography: the ROI and the biopsy") == []
    assert [page for page in OF_PAGES if not (ROOT / "docs" / f"{page}.md").exists()] == []


def test_the_site_is_served_until_an_interrupt(site: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        command = [sys.executable, str(ROOT / ".ci" / "serve"), str(site), str(taken.getsockname()[1])]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            assert server.stdout.readline().endswith("; a free one is taken instead\n")
            address = server.stdout.readline().split()[0]
            assert address.startswith("http://127.0.0.1:")
            with urlopen(address, timeout=30) as page:
                assert b"Title" in page.read()
            server.send_signal(signal.SIGINT)
            rest, errors = server.communicate(timeout=30)
            assert (server.returncode, rest, errors) == (0, "\n", "")
