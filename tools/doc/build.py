# SPDX-License-Identifier: BSD-3-Clause
"""Builds the documentation site: `build.py FOLDER` writes FOLDER/html/index.html. `--check` needs no packages.

The Markdown files stay where they are: copies of them, in the same folders, become the site's pages. Doxygen reads
the C header, fortran_pages.py the Fortran modules, Sphinx imports the Python package. A link that leads nowhere, also
one of the finished pages, a warning of any of them, or a page that would load something from the network is an error.
`--check`, which is a part of lint, only sees that links lead to files, that the source files which the pages name are
there, and that the Fortran modules have what they offer.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from urllib.parse import unquote, urlsplit

from fortran_reader import read_modules

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCES = {".f90", ".F90", ".pf", ".c", ".h"}
FOLDERS = ("include", "input", "meshes", "src", "tests", "tools/signorom_post")
LINK = re.compile(r"\]\(([^)#]+)(#[^)]*)?\)")
SOURCE = re.compile(r"`([\w./]+\.(?:f90|F90|pf|c|h))`")
LANGUAGES = {".py": "python", ".c": "c", ".cff": "yaml"}
#: what a browser would load by itself
LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed|object)\b[^>]*?\b(?:src|data)\s*=\s*["']?(?:https?:)?//[^>]*>"""
    r"""|<link\b[^>]*?\bhref\s*=\s*["']?(?:https?:)?//[^>]*>"""
    r"""|@import\s*(?:url\()?\s*["']?(?:https?:)?//[^;]*|url\(\s*["']?(?:https?:)?//[^)]*\)""",
    re.IGNORECASE,
)
#: where a link of a page leads, and where links may lead
ADDRESS = re.compile(r'<a\b[^>]*?\bhref="([^"]*)"')
ANCHOR = re.compile(r'<[^>]*?\bid="([^"]*)"')


def markdown_files() -> Iterator[Path]:
    """Yields the paths, from the root on, of the Markdown files of the root and of FOLDERS, hidden folders left out."""
    yield from (path.relative_to(ROOT) for path in ROOT.glob("*.md"))
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*.md"):
            if not any(part.startswith(".") for part in path.relative_to(ROOT).parts):
                yield path.relative_to(ROOT)


def write(path: Path, text: str) -> None:
    """Writes a file, unless it has this text already: then it keeps its date, so that Sphinx does not read it again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


class Pages:
    """The folder of pages that Sphinx reads."""

    def __init__(self, folder: Path) -> None:
        """Takes the folder; pages of an earlier run stay until `remove_others`."""
        self.folder = folder
        self._written: set[Path] = set()
        sources = (path for name in FOLDERS for path in (ROOT / name).rglob("*") if path.suffix in SOURCES)
        self._source_names = {path.name for path in sources}

    def write(self, name: str, text: str) -> None:
        """Writes the page `name`, a path from the folder on."""
        write(self.folder / name, text)
        self._written.add(self.folder / name)

    def copy(self, path: Path) -> None:
        """Copies a picture; `path` counts from the root of the project, and from the folder of the pages."""
        (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / path, self.folder / path)
        self._written.add(self.folder / path)

    def add_markdown(self, path: Path) -> None:
        """Writes the page of a Markdown file, and pages of the other files that it links to.

        Ends the program with a message if a link leads to no file, or a source file that the page names is not there.
        """
        text = (ROOT / path).read_text(encoding="utf-8")
        for i, line in enumerate(text.splitlines(), start=1):
            self._check_sources(path, i, line)
        text = LINK.sub(lambda link: self._mended(path, link), text)
        if path.as_posix() == "README.md":
            self.write("index.md", text + (HERE / "pages/contents.md").read_text(encoding="utf-8"))
        else:
            self.write(path.as_posix(), text)

    def _check_sources(self, page: Path, i_line: int, line: str) -> None:
        """Ends the program if a source file that a line names is not there.

        Names count from the root, from src, from the folder of the page, or from the folder of the last name with a
        folder in the line. A name without a folder may be that of any source file; but in a row of a table, after a
        name with a folder, it may not.
        """
        folder: Path | None = None
        for name in SOURCE.findall(line):
            bases = [ROOT, ROOT / "src", ROOT / page.parent, *([folder] if folder else [])]
            found = next((base / name for base in bases if (base / name).is_file()), None)
            is_free = "/" not in name and not (folder and line.startswith("|"))
            if not found and not (is_free and name in self._source_names):
                sys.exit(f"{page}:{i_line}: there is no source file {name}")
            if found and "/" in name:
                folder = found.parent

    def _mended(self, page: Path, link: re.Match[str]) -> str:
        """Returns a link as it must be on the site, and writes or copies the file that it leads to.

        Pages of Markdown files and links with a colon stay as they are. Ends the program if there is no such file.
        """
        target = link[1]
        if ":" in target:
            return link[0]
        file = Path(os.path.normpath(page.parent / target))
        if not (ROOT / file).is_file():
            sys.exit(f"{page}: the link {target} leads to no file")
        if file.suffix == ".png":
            self.copy(file)
        elif file.as_posix() == "include/signorom.h":
            return f"]({os.path.relpath('interfaces/c.rst', page.parent)})"
        elif file.suffix != ".md":
            self._add_shown(file)
            return f"]({target}.md)"
        return link[0]

    def _add_shown(self, file: Path) -> None:
        """Writes a page that shows the text of a file."""
        text = (ROOT / file).read_text(encoding="utf-8")
        orphan = "" if file.name == "LICENSE" else "---\norphan: true\n---\n"
        shown = (
            f"{orphan}# {file.name}\n\n~~~~{{code-block}} {LANGUAGES.get(file.suffix, 'text')}\n{text}~~~~\n"
        )
        self.write(f"{file}.md", shown)

    def remove_others(self) -> None:
        """Deletes what an earlier run wrote and this one did not."""
        for path in self.folder.rglob("*"):
            if path.is_file() and path not in self._written:
                path.unlink()


def layers() -> list[tuple[str, str]]:
    """Returns the folders of `src` and what they are, in the order of the picture in src/README.md.

    Ends the program if the picture does not have exactly these folders.
    """
    picture = (ROOT / "src/README.md").read_text(encoding="utf-8").split("```")[1]
    rows = [line.split(maxsplit=1) for line in picture.strip().splitlines()]
    named = {name for name, _ in rows}
    folders = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    if named != folders:
        sys.exit(
            f"src/README.md: the picture of the layers and the folders differ: {sorted(named ^ folders)}"
        )
    return [(name, what) for name, what in rows]


def add_fortran(pages: Pages) -> None:
    """Writes a page per layer and per module, and the list of layers."""
    index = "# Fortran modules\n\nThe layers, the highest one first; a layer uses those below it only.\n\n"
    names = []
    for name, what in layers():
        index += f"- [{name}]({name}.md): {what}\n"
        names.append(name)
        pages.write(f"fortran/{name}.md", f"# Layer {name}\n\n{what}\n\n```{{fortran-layer}} {name}\n```\n")
    toctree = "\n".join(names)
    pages.write("fortran/index.md", f"{index}\n```{{toctree}}\n:hidden:\n\n{toctree}\n```\n")
    for module in read_modules(ROOT / "src"):
        text = f"---\norphan: true\n---\n# {module.name}\n\n```{{fortran-module}} {module.name}\n```\n"
        pages.write(f"fortran/{module.path.with_suffix('.md')}", text)


def gather(folder: Path) -> None:
    """Writes all pages that Sphinx reads into the folder, and deletes others."""
    pages = Pages(folder)
    for path in markdown_files():
        pages.add_markdown(path)
    for name in ("c", "python"):
        pages.write(f"interfaces/{name}.rst", (HERE / f"pages/{name}.rst").read_text(encoding="utf-8"))
    add_fortran(pages)
    pages.remove_others()


def run_doxygen(folder: Path) -> None:
    """Writes what Doxygen reads from the C header into the folder, as XML; ends the program if Doxygen is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    settings = (HERE / "Doxyfile").read_text(encoding="utf-8")
    settings += f'INPUT = "{ROOT}/include/signorom.h"\nOUTPUT_DIRECTORY = "{folder}"\n'
    try:
        subprocess.run(["doxygen", "-"], input=settings, text=True, check=True)
    except FileNotFoundError:
        sys.exit("doxygen is missing; run: tools/install_dependencies.sh --doc")


def run_sphinx(folder: Path) -> None:
    """Makes folder/html from folder/pages and folder/doxygen; ends the program after all warnings, if there are any."""
    environment = {**os.environ, "SIGNOROM_DOC_DOXYGEN": str(folder / "doxygen/xml")}
    command = [sys.executable, "-m", "sphinx", "-q", "-j", "auto", "-W", "--keep-going"]
    command += ["-c", str(HERE), "-d", str(folder / "state"), str(folder / "pages"), str(folder / "html")]
    if subprocess.run(command, env=environment, check=False).returncode:
        shutil.rmtree(folder / "state")  # the next run says them again
        sys.exit("the site has warnings (above)")


def check_offline(folder: Path) -> None:
    """Ends the program if a page of the folder names something on the network that a browser would load by itself."""
    found = [
        f"{path.relative_to(folder)}: {match[0][:100]}"
        for path in sorted(folder.rglob("*"))
        if path.suffix in {".html", ".css"}
        for match in LOADED.finditer(path.read_text(encoding="utf-8"))
    ]
    if found:
        sys.exit("the site would load from the network:\n" + "\n".join(found))


def check_links(folder: Path) -> None:
    """Ends the program if a link of a page in the folder leads to a file or an anchor that is not there."""
    pages = {path: path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.html"))}
    anchors = {path: {unescape(name) for name in ANCHOR.findall(text)} for path, text in pages.items()}
    found = []
    for page, text in pages.items():
        for address in sorted(set(ADDRESS.findall(text))):
            parts = urlsplit(unescape(address))
            if parts.scheme or parts.netloc:
                continue
            target = Path(os.path.normpath(page.parent / unquote(parts.path))) if parts.path else page
            anchor = unquote(parts.fragment)
            if not target.is_file() or (anchor and anchor not in anchors.get(target, {anchor})):
                found.append(f"{page.relative_to(folder)}: {address}")
    if found:
        sys.exit("links of the site that lead nowhere:\n" + "\n".join(found))


def main() -> None:
    """Builds or checks the site, as the command line says."""
    parser = argparse.ArgumentParser(description="Builds the documentation site.")
    parser.add_argument("folder", type=Path, nargs="?", help="where it goes: FOLDER/html/index.html")
    parser.add_argument("--check", action="store_true", help="only check links and names")
    arguments = parser.parse_args()
    if arguments.check:
        with tempfile.TemporaryDirectory() as folder:
            gather(Path(folder))
        return
    if arguments.folder is None:
        parser.error("which folder?")
    folder = arguments.folder.resolve()
    gather(folder / "pages")
    run_doxygen(folder / "doxygen")
    run_sphinx(folder)
    check_offline(folder / "html")
    check_links(folder / "html")
    print(f"{folder}/html/index.html")


if __name__ == "__main__":
    main()
