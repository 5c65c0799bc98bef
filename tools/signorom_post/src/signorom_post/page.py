# SPDX-License-Identifier: BSD-3-Clause
"""Makes one HTML page of a run, with its pictures inside.

The page needs no other files: it has no scripts, and pictures are inside of it. It fits a phone, and has dark colors if
the browser asks for them.
"""

import base64
from collections.abc import Iterable, Iterator
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from signorom_post.arrays import NO_UNITS
from signorom_post.check import follow_pictures
from signorom_post.figures import FigureOptions, follow_figures
from signorom_post.log import Log
from signorom_post.readers.check import read_check
from signorom_post.results import Results
from signorom_post.summary import STATISTICS, duration, entries, error_text, is_undefined, mapping, value_text

STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #ffffff; --line: #d8d8d8; --soft: #f4f4f4; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e6e6; --paper: #16181c; --line: #3a3f47; --soft: #22262c; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); }
.verdict { padding: .8rem 1rem; border-radius: .4rem; font-weight: 600; color: #ffffff; }
.accepted { background: #00664b; } .rejected { background: #a83200; } .unknown { background: #555b66; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .5rem 0; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; vertical-align: top; border-bottom: 1px solid var(--line); }
td:first-child { min-width: 8.5rem; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
figure { margin: 1rem 0; } figcaption { font-size: .9rem; }
img { max-width: 100%; height: auto; background: #ffffff; padding: .5rem; border-radius: .3rem; }
pre { overflow-x: auto; background: var(--soft); padding: .8rem; font-size: .85rem; }
li { overflow-wrap: anywhere; }
"""
#: error in the report -> its name in the table
ERRORS = {
    "e_u": "displacement",
    "e_lambda_rid": "contact forces in the reduced integration domain",
    "e_lambda_all": "contact forces of all contacts",
    "e_pressure": "contact pressure, of the largest one of the point",
    "e_u_energy": "displacement in the norm of the stiffness [in the units of the deck]",
    "e_u_energy_relative": "displacement in the norm of the stiffness, relative",
    "e_von_mises_largest": "largest von Mises stress",
    "e_von_mises": "von Mises stress of any cell or node, of the largest one of the point",
    "e_lambda_raw": "contact forces of all contacts before their correction",
    "e_plastic_strain": "equivalent plastic strain at any integration point, of the largest one of the history",
    "e_creep_strain": "equivalent creep strain at any integration point, of the largest one of the history",
    "e_energy": "energy [in the units of the deck]",
    "e_energy_rid": "energy in the reduced integration domain [in the units of the deck]",
    "e_energy_relative": "energy, relative",
    "e_energy_rid_relative": "energy in the reduced integration domain, relative",
    "error_bound": "bound of the error of the contact forces, relative (certificate)",
    "displacement_bound": "bound of the error of the displacement in the norm of the stiffness, relative (certificate)",
}
CAPTIONS = {
    "check_bodies": "Supports, loads and boundaries",
    "check_contact": "Contact: gaps, normals, who faces whom",
    "initial_and_deformed": "The bodies at rest and displaced",
    "reduced_domain": "The reduced integration domain",
    "multipliers": "Contact forces",
    "histories": "Tables, contact forces and areas over the time; with friction, slip and its work",
    "hysteresis": "Friction over the history",
    "stick_slip": "Where contacts stick and slip over the time",
    "errors_over_time": "Errors of the contact forces over the time, beside what the answers estimate",
    "errors": "Errors over the parameters",
    "clusters": "Which local model answers where",
    "singular_values": "Singular values of the snapshots",
    "enrichment": "Condition number while hat functions join the basis",
}


def build_page(results: Results, log: Log) -> str:
    """Returns the page as HTML. `log` shows the progress of the pictures.

    Figures that cannot be drawn are left out without a message. InputError if report.yaml is missing or damaged, or if
    there is a check.h5 that cannot be used.
    """
    report = results.report
    title = _word(mapping(report.get("deck")).get("title"))
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
            f"<h1>{escape(title)}</h1>",
            _verdict(report),
            *_remarks(report),
            *_parameters(report),
            *_section("Sizes", _pairs(report.get("sizes"), "sizes")),
            *_section("Model", _pairs(_model(report), "reduction")),
            *_errors(report),
            *_section("Errors of whole histories", _pairs(report.get("histories"), "histories")),
            *_contacts(report),
            *_pictures(results, log),
            *_section("Times", _pairs(report.get("times"), "times", duration)),
            *_deck(report),
            *_provenance(report),
            "</body></html>\n",
        ]
    )


def _verdict(report: dict[str, Any]) -> str:
    validation = mapping(report.get("validation"))
    if "verdict" not in validation:
        return (
            '<p class="verdict unknown">There is no verdict: no model was compared with the full order.</p>'
        )
    kind = "accepted" if validation.get("accepted") is True else "rejected"
    # a report of an older version has no sentence for each
    sentences = [
        f"{name} {validation[name]}" for name in ("forces", "fields", "strains") if name in validation
    ]
    text = "<br>".join(escape(value_text(line)) for line in sentences or [validation["verdict"]])
    return f'<p class="verdict {kind}">{text}</p>'


def _remarks(report: dict[str, Any]) -> Iterator[str]:
    """Yields lines of HTML: the warnings of all sections of the report, then the notes."""
    for heading, keys in {"Warnings": ("warning", "warnings"), "Notes": ("notes",)}.items():
        found: list[str] = []
        for section in map(mapping, report.values()):
            for key in keys:
                said = section.get(key)
                found += said if isinstance(said, list) else [said] if said else []
        if found:
            yield f"<h2>{heading}</h2><ul>"
            yield from (f"<li>{escape(value_text(text))}</li>" for text in found)
            yield "</ul>"


def _parameters(report: dict[str, Any]) -> Iterator[str]:
    parameters = mapping(mapping(report.get("deck")).get("parameters"))
    rows = [
        [
            name,
            value_text(mapping(told).get("min")),
            value_text(mapping(told).get("max")),
            "" if str(told.get("unit", "")) in NO_UNITS else told["unit"],
        ]
        for name, told in parameters.items()
        if isinstance(told, dict)
    ]
    if rows:
        yield "<h2>Parameters</h2>"
        yield _table(["name", "from", "to", "unit"], rows)


def _has_domain(report: dict[str, Any]) -> bool:
    """Returns whether the model is hyper-reduced and so has a RID; true also if the report does not say its kind."""
    return mapping(report.get("reduction")).get("kind", "hhr") == "hhr"


def _model(report: dict[str, Any]) -> dict[str, Any]:
    """Returns the section `reduction` of the report without clusters, and without `dirichlet` if there is no RID."""
    left_out = {"clusters"} if _has_domain(report) else {"clusters", "dirichlet"}
    return {key: value for key, value in mapping(report.get("reduction")).items() if key not in left_out}


def _pairs(section: Any, path: str, show: Any = value_text) -> list[list[str]]:
    return [[name, text] for name, text in entries(mapping(section), path, show) if name]


def _section(heading: str, rows: list[list[str]]) -> Iterator[str]:
    if rows:
        yield f"<h2>{heading}</h2>"
        yield _table([], rows)


def _errors(report: dict[str, Any]) -> Iterator[str]:
    section = mapping(report.get("errors"))
    rows, worst = [], []
    for key, meaning in ERRORS.items():
        statistics = mapping(section.get(key))
        worst += statistics.get("largest_at") or []
        if statistics and not is_undefined(statistics) and (_has_domain(report) or "_rid" not in key):
            rows.append([f"{meaning} ({key})", *(error_text(statistics.get(name)) for name in STATISTICS)])
    if rows:
        yield f"<h2>Errors at {value_text(section.get('n_points'))} points</h2>"
        yield _table(["", "least", "median", "95 %", "largest"], rows)
    if worst:
        yield "<h3>The points with the worst contact forces, and their errors</h3><ul>"
        yield from (f"<li>{escape(value_text(place))}</li>" for place in worst)
        yield "</ul>"


def _contacts(report: dict[str, Any]) -> Iterator[str]:
    """Yields a heading and a table with one row for each contact of each full-order point; nothing without rows."""
    units = mapping(report.get("units"))
    rows = []
    for point in map(mapping, mapping(report.get("points")).values()):
        for contact in map(mapping, mapping(point.get("contacts")).values()):
            told = [contact.get(key) for key in ("surfaces", "area", "force", "moment")]
            rows.append([value_text(point.get("point")), *map(value_text, told)])
    if rows:
        force, moment = value_text(units.get("force")), value_text(units.get("moment"))
        yield "<h2>Contacts</h2>"
        area = value_text(units.get("contact_area"))
        yield _table(["point", "surfaces", f"area [{area}]", f"force [{force}]", f"moment [{moment}]"], rows)


def _pictures(results: Results, log: Log) -> Iterator[str]:
    """Yields, as HTML, the pictures for which the folder has the files, first those of check.h5.

    InputError if there is a check.h5 that cannot be used.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        paths: list[Path] = []
        set_up = results.folder / "check.h5"
        if set_up.exists():
            paths += follow_pictures(log, read_check(set_up), folder, "png")
        outcomes = follow_figures(log, results, folder, "png", FigureOptions())
        paths += [outcome.path for outcome in outcomes if outcome.path]
        if paths:
            yield "<h2>Pictures</h2>"
        for path in paths:
            picture = base64.b64encode(path.read_bytes()).decode("ascii")
            caption = escape(_caption(path.stem))
            yield f'<figure><img alt="{caption}" src="data:image/png;base64,{picture}">'
            yield f"<figcaption>{caption}</figcaption></figure>"


def _caption(stem: str) -> str:
    """Returns the caption of the picture <stem>.png: the text of CAPTIONS and the number of a contact or cluster."""
    for name, caption in CAPTIONS.items():
        if stem == name or stem.startswith(f"{name}_"):
            return " ".join([caption, stem[len(name) :].replace("_", " ").strip()]).strip()
    return stem


def _deck(report: dict[str, Any]) -> Iterator[str]:
    deck = mapping(report.get("deck"))
    if deck:
        text = yaml.safe_dump(deck, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
        yield "<h2>Deck</h2><details><summary>with all defaults</summary>"
        yield f"<pre>{escape(text)}</pre></details>"


def _provenance(report: dict[str, Any]) -> Iterator[str]:
    rows = _pairs(report.get("run"), "run", _word) + _pairs(report.get("version"), "version", _word)
    rows.append(["deck and mesh", _word(report.get("provenance"))])
    yield from _section("Where this comes from", rows)


def _word(value: Any) -> str:
    """Returns a text as it stands, also one that looks like a number: a title, a commit."""
    return value if isinstance(value, str) else value_text(value)


def _table(titles: list[str], rows: Iterable[list[str]]) -> str:
    """Returns a table in HTML; the columns after the first one are set as numbers. Without `titles` it has no head."""
    head = "".join(f"<th>{escape(title)}</th>" for title in titles)
    lines = [f"<tr>{head}</tr>"] if titles else []
    for first, *others in rows:
        cells = "".join(f'<td class="number">{escape(str(cell))}</td>' for cell in others)
        lines.append(f"<tr><td>{escape(str(first))}</td>{cells}</tr>")
    return f'<div class="wide"><table>{"".join(lines)}</table></div>'
