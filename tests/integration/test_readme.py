# SPDX-License-Identifier: BSD-3-Clause
"""Commands of the READMEs in their order: each file that one names is in the repository, or an earlier one made it."""

import re

import yaml

from program import ROOT

#: a path from the root of the clone, up to what ends a word of the shell or of Python
PATH = re.compile(r"(?<![\w/$.])((?:tools|input|meshes|tests|include|build|results)/[\w./-]+)")
#: what the commands make that no deck tells
MADE_BY = {
    "tools/demo.sh": ["build/release/signorom", "build/venv/bin/signorom-post", "build/venv/bin/python"],
    "tools/test.sh": ["build/ci/verification"],
    "signorom check part.yaml": ["results/part"],
    "signorom-post paper": ["results/paper"],
    "cmake -B build/online": ["build/online"],
    "cmake --install build/online --prefix": ["build/opt/lib/pkgconfig", "build/opt/lib"],
}


#: in the order in which a user reads them
PAGES = ("README.md", "include/README.md", "input/compare/README.md")


def text_of_pages():
    """All of them, one after the other."""
    return "\n".join((ROOT / page).read_text() for page in PAGES)


def commands():
    """Indented lines of the pages, without their comments."""
    text = text_of_pages()
    return [line[4:].split("   #")[0].strip() for line in text.splitlines() if line.startswith("    ")]


def results_of(deck):
    """Folder that a deck's results go to."""
    content = yaml.safe_load((ROOT / deck).read_text())
    return content.get("output", {}).get("directory", f"results/{(ROOT / deck).stem}")


def made_by(line):
    """What a command makes: folders and files."""
    made = [path for words, paths in MADE_BY.items() if words in line for path in paths]
    if "tools/demo.sh" in line:
        line = "run " + re.search(r"^deck=(\S+)$", (ROOT / "tools" / "demo.sh").read_text(), re.MULTILINE)[1]
    made += [results_of(deck) for deck in re.findall(r"(?:run|solve) (input/\S+\.yaml)", line)]
    made += [results_of(deck) for deck in re.findall(r"check (input/\S+\.yaml) --fields", line)]
    made += re.findall(r"(?: -o | --output )(\S+)", line)
    return made


def test_paths_exist_when_a_command_names_them():
    known = []
    n_paths = 0
    for line in commands():
        new = made_by(line)
        for path in PATH.findall(line):
            n_paths += 1
            is_there = (ROOT / path).exists() and not path.startswith(("build", "results"))
            is_made = any(path == made or path.startswith(f"{made}/") for made in known + new)
            is_folder_of_it = any(made.startswith(f"{path}/") for made in known)
            assert is_there or is_made or is_folder_of_it, f"{path} does not exist yet in: {line}"
        known += new
    assert n_paths > 15


def test_model_of_the_examples_has_their_parameters():
    """The C program and the Python binding ask for a value of each parameter of the deck whose model they open."""
    text = text_of_pages()
    (deck, values) = re.search(r"ask_model results/(\w+)/model.h5 (.*)", text).groups()
    parameters = yaml.safe_load((ROOT / "input" / f"{deck}.yaml").read_text())["parameters"]
    assert len(values.split()) == len(parameters)
    (deck, names) = re.search(r'Model\("results/(\w+)/model.h5"\).query\((.*)\)', text).groups()
    parameters = yaml.safe_load((ROOT / "input" / f"{deck}.yaml").read_text())["parameters"]
    assert re.findall(r"(\w+)=", names) == list(parameters)


def test_links_lead_somewhere():
    """Each link of each page in the repository, but for the web."""
    for page in ROOT.glob("**/*.md"):
        if "build" in page.parts or ".git" in page.parts:
            continue
        for link in re.findall(r"\]\(([^)#\s]+)", page.read_text()):
            if not link.startswith("http"):
                assert (page.parent / link).exists(), f"{page.relative_to(ROOT)}: {link}"


def test_recipes_name_what_is_there():
    """Those of CONTRIBUTING: paths from the root or from src, or names of files somewhere there."""
    names = {path.name for folder in ("src", "tests") for path in (ROOT / folder).rglob("*.*")}
    recipes = (ROOT / "CONTRIBUTING.md").read_text().split("## Recipes")[1]
    named = re.findall(r"`(\w+(?:/[\w.]+)+|\w+\.(?:[fF]90|pf|py|txt|yaml))`", recipes)
    for name in named:
        is_there = (ROOT / name).exists() or (ROOT / "src" / name).exists()
        assert is_there or name in names, f"CONTRIBUTING.md names {name}, which is not there"
    assert len(named) > 50


def test_each_benchmark_runs_as_a_test():
    """Each script that can be called has a test at its smallest size."""
    folder = ROOT / "tests" / "benchmark"
    scripts = {path.stem for path in folder.glob("*.py") if "__main__" in path.read_text()} - {"run_small"}
    tested = set(
        re.findall(r"(?m)^ *sig_add_benchmark_script\((\w+) ", (folder / "CMakeLists.txt").read_text())
    )
    assert scripts == tested


def test_front_page_is_short():
    """What does not fit belongs to the page that it is about."""
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 150
    assert max(map(len, lines)) <= 132


def test_messages_are_those_of_the_program():
    """Each line of the page on messages quotes words that the program says."""
    page = (ROOT / "input" / "TROUBLESHOOTING.md").read_text().split("## What to do about a message")[1]
    sources = "".join(path.read_text() for path in (ROOT / "src").glob("**/*.[fF]90"))
    quoted = re.findall(r"(?m)^- \*([^*]+)\*: ", page)
    assert len(quoted) > 10
    for words in quoted:
        assert words in sources, words
