# SPDX-License-Identifier: BSD-3-Clause
"""`signorom-post explore`: what an exploration says, what VTK draws of it, and its page in Chromium.

A block, 1 m wide, is pressed by P from the time 1 on, and sheared to and fro with friction: by statics the contact
carries P, and the shear. Below a coefficient of 0.25 it slides, and there is no answer.
"""

import asyncio
import csv
import io
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress

import numpy as np
import pytest

from block_meshes import stacked_blocks
from results import table_of

pytest.importorskip("trame")
pytest.importorskip("vtk")

DECK = """title: A block that is pressed and sheared
units: {length: m, force: N, time: h}
mesh: {file: part.msh, model: plane_strain}
parameters: {P: {min: 1, max: 9, unit: Pa}, mu: {min: 0.3, max: 1}}
history:
  tables:
    load: {time: [0, 1, 4], value: [0, P, P]}
    shear: {time: [0, 1, 2, 3, 4], value: [0, 0, "0.25 * P", "-0.25 * P", 0]}
  steps: [{until: 1, increments: 1}, {until: 4, increments: 3}]
materials: {all: {regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}}
boundary_conditions: [{boundary: bottom, displacement: {x: 0, y: 0}}]
loads: [{boundary: top, pressure: load}, {boundary: top, traction: {x: shear}}]
contact: [{first: lower_face, second: upper_face, friction: mu}]
training: {grid: {P: 2, mu: 2}}
test: {sobol: 2, seed: 1}
"""
#: the shear at the times 1, 2, 3 and 4, over P
SHEAR = [0.0, 0.25, -0.25, 0.0]


@pytest.fixture(scope="module")
def models(signorom, tmp_path_factory):
    """Folder with results/part, a model with fields, and results/bare, one without."""
    folder = tmp_path_factory.mktemp("explore")
    stacked_blocks("Q4", 2).write(folder / "part.msh")
    (folder / "bare.yaml").write_text(DECK)
    (folder / "part.yaml").write_text(DECK + "reduction: {fields: true}\n")
    for name in ("part", "bare"):
        signorom("run", f"{name}.yaml", folder=folder)
    return folder


@pytest.fixture(scope="module")
def exploration(post, models):
    from signorom_post.explore.exploration import Exploration

    assert post
    exploration = Exploration(models / "results" / "part" / "model.h5")
    yield exploration
    exploration.close()


@pytest.fixture(scope="module")
def outputs(exploration):
    from signorom_post.explore.outputs import outputs_of

    return outputs_of(exploration.model)


def number(exploration, outputs, look, name):
    from signorom_post.explore.outputs import numbers_of

    return next(each for each in numbers_of(exploration, outputs, look) if each.name == name)


@pytest.mark.parametrize("order", [range(4), (3, 1, 2, 0)])
def test_numbers_are_those_of_statics(exploration, outputs, order):
    """At all times, in their order as in a film, and in any other."""
    for step in order:
        look = exploration.look({"P": 4.0, "mu": 0.6}, step)
        found = number(exploration, outputs, look, "contact_1_force_x").value
        assert abs(found) == pytest.approx(4.0 * abs(SHEAR[step]), abs=1e-9)
        force = number(exploration, outputs, look, "contact_1_force_y")
        assert (abs(force.value), force.unit) == (pytest.approx(4.0), "N/m")
        assert force.is_vouched_for
        assert look.fields is not None


def test_what_speaks_against_an_answer_is_said(exploration, outputs):
    """Outside of the box, numbers are not vouched for; where the block slides, there are none."""
    far = exploration.look({"P": 10.0, "mu": 0.6})
    assert "P (10) lies outside of 1 to 9 Pa" in far.remarks[0].text
    assert not number(exploration, outputs, far, "contact_1_force_y").is_vouched_for
    for step, has_answer in ((0, True), (1, False), (3, False)):
        look = exploration.look({"P": 4.0, "mu": 0.2}, step)
        assert (look.answer is not None) == has_answer
        assert ("slides" in look.refusal) == (not has_answer)
    force = number(exploration, outputs, look, "contact_1_force_y")
    assert (force.value, force.is_vouched_for) == (None, False)


@pytest.mark.parametrize(
    ("text", "sentence"), [("abc", "is not a number"), ("", "missing"), ("inf", "finite")]
)
def test_what_is_no_number_is_refused(post, text, sentence):
    from signorom_post.explore.exploration import value_of

    assert post
    with pytest.raises(ValueError, match=sentence):
        value_of(text)


def test_curve_and_its_tangent(exploration, outputs):
    """The contact force is P, so that its derivative is 1; over the time it is P at each of the times."""
    from signorom_post.explore.curve_picture import svg_of, text_of
    from signorom_post.explore.outputs import curve_of

    look = exploration.look({"P": 12.0, "mu": 0.6})
    force = next(each for each in outputs if each.name == "contact_force")
    curve = curve_of(exploration, force, "P", look, n_points=12)
    np.testing.assert_allclose(curve.values, curve.at)
    assert curve.slope == pytest.approx(1.0)
    assert curve.here == (12.0, pytest.approx(12.0))
    np.testing.assert_array_equal(curve.is_inside, curve.at <= 9.0)
    assert 'class="tangent"' in svg_of(curve)
    assert "derivative 1" in text_of(curve)
    np.testing.assert_allclose(curve_of(exploration, force, "time", look).values, 12.0)
    area = next(each for each in outputs if each.name == "contact_1_area")
    assert 'class="tangent"' not in svg_of(curve_of(exploration, area, "P", look, n_points=3))


def test_same_answer_elsewhere(signorom, models, exploration, library, outputs):
    """By the command and by the program in Python that the page copies, and in its table."""
    from signorom_post.explore.texts import csv_of

    look = exploration.look({"P": 4.0, "mu": 0.6}, 1)
    program, *words = exploration.command(look).split()
    assert program == "signorom"
    table = table_of(signorom(*words, folder=models))
    text = exploration.python(look) + "print(answer.contact_force)\n"
    done = subprocess.run(
        [sys.executable, "-c", text],
        env=os.environ | {"SIGNOROM_LIBRARY": str(library)},
        capture_output=True,
        text=True,
        check=True,
    )
    rows = {row["name"]: row for row in csv.DictReader(io.StringIO(csv_of(exploration, outputs, look)))}
    assert rows["P"] == {"name": "P", "value": "4.0", "unit": "Pa", "remark": ""}
    for value in (table["contact_force"][1], done.stdout, rows["contact_force"]["value"]):
        assert float(value) == pytest.approx(4.0)


def test_elements_keep_their_shapes(post):
    """In VTK's elements, the middle of each edge stands between the edge's ends: gmsh's order became VTK's."""
    import vtk
    from signorom_post.answer import Cells
    from signorom_post.convert.elements import KINDS
    from signorom_post.explore.scene import grid_of

    assert post
    none = np.zeros(0, dtype=np.int64)
    rng = np.random.default_rng(1)
    for kind in KINDS:
        if kind.n_dim < 2:
            continue
        corners = rng.random((kind.n_corners, 3)) * (1.0, 1.0, kind.n_dim - 2.0)
        places = np.array([corners[[int(i) for i in name]].mean(axis=0) for name in kind.nodes])
        cells = Cells(np.array([0, kind.n_nodes]), np.arange(kind.n_nodes), none, [], none, none, none)
        cell = grid_of(cells, places).GetCell(0)
        assert cell.GetCellDimension() == kind.n_dim, kind.name
        for i in range(cell.GetNumberOfEdges() if kind.n_dim == 3 else 0):
            points = cell.GetEdge(i).GetPoints()
            ends = np.array([points.GetPoint(0), points.GetPoint(1)])
            if points.GetNumberOfPoints() == 3:
                np.testing.assert_allclose(points.GetPoint(2), ends.mean(axis=0), err_msg=kind.name)
        if kind.n_dim == 2:
            tags = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
            assert tags == list(range(len(tags))), kind.name
        assert isinstance(cell, vtk.vtkCell)


def test_picture_has_the_colors_of_the_field(exploration):
    """Two limits of one scale: the part is yellow where its values are high for the scale, violet where they are low."""
    from matplotlib.image import imread
    from signorom_post.explore.colors import colors_of
    from signorom_post.explore.scene import Scene, Shown

    look = exploration.look({"P": 4.0, "mu": 0.6}, 1)
    colors = {color.name: color for color in colors_of(look.fields)}
    assert {"von_mises", "displacement", "contact_pressure", "gap", "slip", "status"} <= set(colors)
    assert colors["status"].title == "stick or slip"
    scene = Scene(exploration.cells, exploration.model.nodes[1])

    def middle_of(limits):
        scene.show(0, Shown(look.fields, colors["displacement"], 0.0, limits))
        data = scene.png(("",), "", has_scale=False)
        pixels = 255 * imread(io.BytesIO(data), format="png")
        return pixels[2 * len(pixels) // 3, len(pixels[0]) // 2, :3]

    # the ends of viridis
    np.testing.assert_allclose(middle_of((-2.0, -1.0)), [253, 231, 37], atol=3)
    np.testing.assert_allclose(middle_of((1.0, 2.0)), [68, 1, 84], atol=3)


@contextmanager
def serving(results, library):
    """Process of the command and the address of its page; it must end by Ctrl-C."""
    process = subprocess.Popen(
        [sys.executable, "-m", "signorom_post", "explore", str(results)],
        env=os.environ | {"SIGNOROM_LIBRARY": str(library)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process, process.stdout.readline().strip()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        assert process.returncode == 130, said
        assert "Traceback" not in said
    finally:
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def browser():
    if shutil.which("chromium") is None:
        pytest.skip("chromium is not installed")
    pytest.importorskip("websocket")
    from browser import chromium

    with chromium() as running:
        yield running


FORCE = "document.querySelector('#contact_force')?.innerText"
PICTURE = "document.querySelector('#picture img')?.src"
#: elements that a user can change and that have no name
NAMELESS = """[...document.querySelectorAll('input, select, button, textarea')].filter(e =>
  !(e.labels?.length || e.getAttribute('aria-label') || e.innerText?.trim())).map(e => e.outerHTML)"""
#: texts whose contrast is below 4.5, by the formula of WCAG 2.2
PALE = """(() => {
  const light = c => { const v = c.map(x => (x /= 255) <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]; };
  const rgb = text => text.match(/[\\d.]+/g).map(Number);
  const ground = e => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor);
    if (c.length < 4 || c[3] > 0) return c; } return [255, 255, 255]; };
  return [...document.querySelectorAll('.page *')].filter(e => e.offsetParent && !e.disabled
    && [...e.childNodes].some(n => n.nodeType == 3 && n.textContent.trim())).filter(e => {
      const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
      return (a + 0.05) / (b + 0.05) < 4.5; }).map(e => e.outerHTML); })()"""


def test_page(browser, models, library, tmp_path):
    """Loads, slider and keyboard change number and picture, bad values say so, two tabs, a closed one ends nothing."""
    with serving(models / "results" / "part", library) as (process, address):
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/index\.html\?secret=[\w-]{32}", address)
        tab = browser.new_tab(address)
        assert tab.wait_for(FORCE) == "5"  # the middle of the box
        tab.wait_for(PICTURE)
        assert "accepted" in tab.text("#verdict")
        assert tab.evaluate("[document.body.scrollWidth, document.body.scrollHeight]") == [1280, 720]
        assert tab.evaluate(NAMELESS) == []
        assert tab.evaluate(PALE) == []

        before = tab.evaluate(PICTURE)
        tab.set("#slider-0", 1000)
        tab.wait_for(f"{FORCE} == '9'")
        tab.wait_for(f"{PICTURE} != '{before}'")
        assert tab.evaluate("document.querySelector('#value-0').value") == "9"
        tab.evaluate("document.querySelector('#slider-0').focus()")
        tab.press("ArrowLeft")
        tab.wait_for(f"{FORCE} == '8.95'")
        assert "P=8.95" in tab.evaluate("document.querySelector('#command').value")

        tab.set("#value-0", "abc")
        tab.wait_for(f"{FORCE} == 'none'")
        assert "'abc' is not a number" in tab.text("#message-0")
        assert tab.evaluate("document.querySelector('#value-0').getAttribute('aria-invalid')") == "true"
        tab.set("#value-0", "20")
        tab.wait_for(f"{FORCE} == '20 ?'")
        assert "outside of the trained range" in tab.text("#message-0")
        assert "extrapolates" in tab.text("#status")
        tab.set("#value-0", "4")
        tab.set("#value-1", "0.2")
        tab.wait_for("document.querySelector('#status').innerText.includes('slides')")
        assert tab.evaluate(FORCE) == "none"
        tab.set("#value-1", "0.6")
        tab.wait_for(f"{FORCE} == '4'")

        tab.click("#compare")
        tab.set("#value-0", "2")
        tab.wait_for("document.querySelector('#contact_force + td').innerText == '4'")
        tab.wait_for(f"{FORCE} == '2'")
        tab.click("#compare")
        tab.set("#time", 0)
        tab.wait_for("document.querySelector('label[for=time] + span').innerText == '1 h'")
        tab.click("#play")
        tab.wait_for("document.querySelector('label[for=time] + span').innerText == '4 h'")

        tab.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        for kind, start in (("csv", b"name,value"), ("png", b"\x89PNG"), ("vtu", b"<?xml")):
            tab.click(f"#{kind}")
            assert wait_for_file(tab, tmp_path / f"part.{kind}").startswith(start)

        other = browser.new_tab(address)
        other.wait_for(f"{FORCE} == '2'")
        other.set("#value-0", "7")
        tab.wait_for(f"{FORCE} == '7'")
        other.close()
        tab.set("#value-0", "6")
        tab.wait_for(f"{FORCE} == '6'")

        stranger = browser.new_tab(re.sub("secret=.*", "secret=guess", address))
        stranger.wait_for("document.readyState == 'complete'")
        host = address.split("/")[2]
        assert all(
            request.split("/")[2] == host for request in tab.requests if not request.startswith("blob:")
        )
        assert tab.errors == []
        assert process.poll() is None
        tab.wait_for(f"{FORCE} == '6'")
        assert stranger.evaluate(FORCE) is None
        for each in (stranger, tab):
            each.close()


def wait_for_file(tab, path):
    """Content of a file that a download writes."""
    for _ in range(600):
        if path.exists():
            return path.read_bytes()
        tab.evaluate("new Promise(done => setTimeout(done, 50))")
    raise AssertionError(f"{path.name} did not come")


@contextmanager
def serving_here(path):
    """Address of a page that this process serves, which saves the time to import everything once more."""
    from signorom_post.explore.exploration import Exploration
    from signorom_post.explore.page import Page, serve

    exploration = Exploration(path)
    told = queue.Queue()

    async def until_cancelled():
        told.put((asyncio.get_running_loop(), asyncio.current_task()))
        with suppress(asyncio.CancelledError):
            await serve(Page(exploration), "word", 0, told.put)

    thread = threading.Thread(target=asyncio.run, args=(until_cancelled(),))
    thread.start()
    loop, task = told.get(timeout=60)
    try:
        yield told.get(timeout=60)
    finally:
        loop.call_soon_threadsafe(task.cancel)
        thread.join()
        exploration.close()


def test_page_without_fields(post, browser, models):
    """Shows numbers and curves, and says why there is no picture."""
    assert post
    with serving_here(models / "results" / "bare" / "model.h5") as address:
        tab = browser.new_tab(address)
        tab.wait_for(f"{FORCE} == '5'")
        tab.set("#value-0", "3")
        tab.wait_for(f"{FORCE} == '3'")
        assert tab.evaluate("document.querySelectorAll('#picture, #png, #vtu').length") == 0
        assert "reduction.fields: true" in tab.text(".no-fields")
        label = tab.evaluate("document.querySelector('#curve').getAttribute('aria-label')")
        assert "sum of normal contact forces" in label
        tab.close()


def test_refusals(post, models, tmp_path, capsys):
    """A folder without a model, and a port that is taken."""
    import socket

    from signorom_post.cli import main

    assert post
    assert main(["explore", str(tmp_path)]) == 2
    assert f"{tmp_path / 'model.h5'}: error: " in capsys.readouterr().err
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["explore", str(models / "results" / "bare"), "--port", str(port)]) == 2
    assert f"port {port} cannot be used" in capsys.readouterr().err
