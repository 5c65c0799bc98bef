# SPDX-License-Identifier: BSD-3-Clause
"""The page of a run: complete, closed in itself, and shown by a browser."""

import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest
import yaml

from signorom_post.cli import main
from signorom_post.log import Log
from signorom_post.page import build_page
from signorom_post.results import Results

VOID = {"meta", "img", "link", "br"}


class Reader(HTMLParser):
    """Tags that are open, sources of pictures, and the text that a reader sees."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """A tag that is no picture stays open until it is closed."""
        if tag not in VOID:
            self.open.append(tag)
        self.sources += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        """Tags close in their order."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Text of the page."""
        if self.open and self.open[-1] != "style":
            self.text += data + "\n"


def read(page: str) -> Reader:
    """The page, whose tags must all be closed."""
    reader = Reader()
    reader.feed(page)
    assert not reader.open
    return reader


@pytest.fixture(scope="module")
def page(results: Results) -> str:
    """Of the whole folder."""
    return build_page(results, Log())


@pytest.fixture
def words_only(folder: Path) -> Path:
    """A folder with nothing to draw."""
    for path in [*folder.glob("*.h5"), *folder.glob("*.csv")]:
        path.unlink()
    return folder


def test_page_tells_the_run(page: str) -> None:
    """Verdict, errors, worst points, pictures, deck; each number as the report has it."""
    reader = read(page)
    assert "Two half disks pressed together" in reader.text
    assert "Errors at 101 points" in reader.text
    assert "2.7e-04" in reader.text  # median of e_lambda_rid
    assert "squeeze = 0.156 m: 1.6E-02" in reader.text
    assert "The bodies at rest and displaced" in reader.text
    assert len(reader.sources) >= 4


def test_page_asks_for_nothing_from_elsewhere(page: str) -> None:
    """Pictures are inside, and there is no script, font or address."""
    assert all(source.startswith("data:image/png;base64,") for source in read(page).sources)
    assert not re.search(r"https?:|<script|@import|url\(", re.sub(r'"data:[^"]*"', "", page))


@pytest.mark.parametrize(
    ("validation", "words", "kind"),
    [
        ({"accepted": True, "verdict": "accepted: p95 is 1e-9"}, "accepted: p95 is 1e-9", "accepted"),
        ({"accepted": False, "verdict": "not accepted: p95 is 0.2"}, "not accepted: p95 is 0.2", "rejected"),
        (
            {"accepted": False, "verdict": "v", "forces": "accepted: 1e-9", "fields": "NOT accepted: 0.1"},
            "forces accepted: 1e-9<br>fields NOT accepted: 0.1</p>",
            "rejected",
        ),
        (None, "There is no verdict", "unknown"),
    ],
)
def test_verdict(words_only: Path, validation: dict[str, object] | None, words: str, kind: str) -> None:
    """Green, red or gray, in words too."""
    path = words_only / "report.yaml"
    report = yaml.safe_load(path.read_text())
    report["validation"] = validation
    path.write_text(yaml.safe_dump(report))
    page = build_page(Results(words_only), Log())
    assert f'<p class="verdict {kind}">{words}' in page


def test_texts_of_the_user_are_no_markup(words_only: Path) -> None:
    """A title with angle brackets is shown, not obeyed."""
    path = words_only / "report.yaml"
    report = yaml.safe_load(path.read_text())
    report["deck"]["title"] = "a < b & <script>alert(1)</script>"
    path.write_text(yaml.safe_dump(report))
    page = build_page(Results(words_only), Log())
    assert "<script" not in page
    assert "a < b & <script>alert(1)</script>" in read(page).text


def test_texts_that_look_like_numbers_stay_texts(words_only: Path) -> None:
    path = words_only / "report.yaml"
    report = yaml.safe_load(path.read_text())
    report["deck"]["title"] = "12345"
    report["version"]["commit"] = "7e55613"
    path.write_text(yaml.safe_dump(report))
    text = read(build_page(Results(words_only), Log())).text
    assert "12345" in text
    assert "7e55613" in text


def test_command_writes_the_page(words_only: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Into the results folder, or where the user says; a missing report is a user's error."""
    assert main(["report", str(words_only)]) == 0
    assert (words_only / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert main(["report", str(words_only), "--output", str(words_only / "page.html")]) == 0
    assert (words_only / "page.html").read_bytes() == (words_only / "report.html").read_bytes()
    (words_only / "report.yaml").unlink()
    assert main(["report", str(words_only)]) == 2
    assert "report.yaml" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed")
@pytest.mark.parametrize("width", [360, 1200])
def test_browser_shows_the_page(page: str, tmp_path: Path, width: int) -> None:
    """On a phone's width and on a screen's: nothing is wider than the window but tables that scroll."""
    probe = "<script>document.title = document.documentElement.scrollWidth - innerWidth</script>"
    file = tmp_path / "probe.html"
    file.write_text(page.replace("</body>", probe + "</body>"))
    browser = [
        "chromium",
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path}/browser",
    ]
    browser += ["--host-resolver-rules=MAP * ~NOTFOUND", f"--window-size={width},900"]
    shown = subprocess.run(
        [*browser, "--dump-dom", file.as_uri()], capture_output=True, text=True, timeout=60, check=True
    ).stdout
    title = re.search("<title>(.*?)</title>", shown)
    assert title
    assert float(title.group(1)) <= 0
