# SPDX-License-Identifier: BSD-3-Clause
"""The page of an exploration: what the browser shows, and what happens when the user moves something."""

import asyncio
import logging
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
from trame.app import get_server
from trame.ui.html import DivLayout
from trame.widgets import client, html
from trame.widgets import vtk as vtk_widgets

from signorom_post.answer import Parameter
from signorom_post.arrays import NO_UNITS, format_number
from signorom_post.explore.colors import Color, colors_of
from signorom_post.explore.curve_picture import svg_of, text_of
from signorom_post.explore.exploration import (
    Exploration,
    Look,
    outside_text,
    sentence_of,
    unit_of,
    value_of,
)
from signorom_post.explore.outputs import curve_of, numbers_of, outputs_of
from signorom_post.explore.scene import Scene, Shown, vtu
from signorom_post.explore.texts import csv_of, legend_of, picture_text, point_text, rows_of
from signorom_post.plots.captions import magnification

#: number of steps of a slider, at least
N_STEPS = 100
#: [s] time between two looks whether a picture is encoded
ENCODED = 0.01
#: [s] after the last move, the picture is drawn once more with smooth edges
QUIET = 0.5
#: [s] least time between two pictures of a film
FILM_INTERVAL = 0.12
#: number of history steps that a curve may cost
CURVE_BUDGET = 1200


class Page:
    """A page on one exploration. All browsers that open it see, and move, the same state."""

    def __init__(self, exploration: Exploration) -> None:
        """Asks the model in the middle of its box, and builds the page. It is served by `serve`."""
        self._exploration = exploration
        self._outputs = outputs_of(exploration.model)
        self.server = get_server(f"explore-{id(self)}", client_type="vue3")
        self.state = self.server.state
        self._kept: Look | None = None
        self._limits: tuple[str, tuple[float, float]] | None = None
        self._moved = asyncio.Event()
        self._played = asyncio.Event()
        self._drawn = asyncio.Event()
        self._look = exploration.look(exploration.middle())
        self._scene: Scene | None = None
        if exploration.cells is not None:
            self._scene = Scene(exploration.cells, exploration.model.nodes[1])
            self._scene.interactor.AddObserver("EndInteractionEvent", lambda *_: self._drawn.set())
        self._view: Any = None
        self._set_up_state()
        self._build()
        self.update()
        self._show_curve()
        names = [f"value_{i}" for i in range(len(exploration.parameters))]
        self.state.change(*names, "step", "color", "scale", "hold", "output", "over")(self._note_move)
        self.state.change("playing")(self._note_play)
        for name in ("to_middle", "compare", "look_from", "zoom", "turn", "csv", "png", "vtu"):
            self.server.controller.trigger(name)(getattr(self, f"_{name}"))

    def _set_up_state(self) -> None:
        exploration, model, state = self._exploration, self._exploration.model, self.state
        state.trame__title = f"{exploration.model.title} - Signorom"
        state.title = exploration.model.title
        state.summary = f"{exploration.path}: {model.kind}, {model.contact_areas.size} contact rows"
        state.stem = exploration.path.absolute().parent.name
        state.verdict = exploration.verdict
        state.verdict_kind = {True: "good", False: "bad", None: "doubt"}[exploration.is_accepted]
        state.verdict_short = {True: "accepted", False: "NOT accepted", None: "not validated"}[
            exploration.is_accepted
        ]
        for i, value in enumerate(self._look.point.values()):
            state[f"value_{i}"] = f"{value:.6g}"
            state[f"message_{i}"] = state[f"message_{i}_kind"] = ""
        state.n_times, state.step = len(exploration.times), self._look.step or 0
        state.playing = state.comparing = state.hold = False
        state.copied = state.scale_message = state.kept_point = ""
        state.has_fields, state.no_fields = self._scene is not None, exploration.no_fields
        state.is_solid = self._scene is not None and self._scene.is_solid
        state.outputs = [{"name": each.name, "title": each.label} for each in self._outputs]
        state.output = self._outputs[0].name
        state.varied = [parameter.name for parameter in exploration.parameters]
        if exploration.times:
            state.varied = [*state.varied, "time"]
        state.over = state.varied[-1] if exploration.times else state.varied[0]
        state.colors, state.color, state.scale = [], "von_mises", "1"
        state.legend = {"title": "", "states": [], "ticks": [], "gradient": ""}
        if self._look.fields is not None:
            state.colors = [{"name": each.name, "title": each.title} for each in colors_of(self._look.fields)]
            size = float(np.ptp(exploration.model.nodes[1], axis=0).max())
            state.scale = f"{magnification(np.nan_to_num(self._look.fields.displacement), size):g}"

    def _build(self) -> None:
        folder = files("signorom_post.explore")
        one = (folder / "parameter.html").read_text(encoding="utf-8")
        fields = "".join(
            _filled(one, i, parameter) for i, parameter in enumerate(self._exploration.parameters)
        )
        page = (folder / "page.html").read_text(encoding="utf-8").replace("<!-- parameters -->", fields)
        with DivLayout(self.server) as layout:
            client.Style((folder / "page.css").read_text(encoding="utf-8"))
            if self._scene is not None:
                self._view = vtk_widgets.VtkRemoteView(
                    self._scene.window, ref="view", interactive_quality=70, style="height: 100%"
                )
                layout.root.children.remove(self._view)
                page = page.replace("<!-- view -->", self._view.html)
            html.Div(page)

    def _note_move(self, **_: Any) -> None:
        self.state.copied = ""
        self._moved.set()

    def _note_play(self, **_: Any) -> None:
        if self.state.playing:
            self._played.set()

    def hasten(self) -> None:
        """Makes a picture come as soon as it is encoded, which VTK does beside; trame looks every half a second."""
        delivery = self.server.protocol.getRPCMethod("viewport.image.push")
        if delivery:
            delivery[0].delta_stale_time_before_render = ENCODED

    async def follow(self) -> None:
        """Answers whatever is moved, for ever. Of moves that come while an answer is made, the last one counts."""
        while True:
            await self._moved.wait()
            self._moved.clear()
            with self.state:
                self.update()
            # the picture leaves, and what the browser sent meanwhile is read, before the curve is asked for
            await asyncio.sleep(1.5 * ENCODED)
            if not self._moved.is_set():
                with self.state:
                    self._show_curve()

    async def polish(self) -> None:
        """Draws the picture with smooth edges whenever nothing has moved for a while."""
        while True:
            await self._drawn.wait()
            self._drawn.clear()
            await asyncio.sleep(QUIET)
            if self._scene is None or self._drawn.is_set() or self._moved.is_set():
                continue
            self._scene.smooth_edges(True)
            self._view.update()
            self._scene.smooth_edges(False)

    def _draw(self) -> None:
        """Sends the picture to all browsers."""
        if self._view is not None and self.server.protocol:
            self._view.update()
            self._drawn.set()

    async def film(self) -> None:
        """Plays the history while the user wants it, from the start if the time is at its end."""
        while True:
            await self._played.wait()
            self._played.clear()
            if self.state.step >= self.state.n_times - 1:
                self.state.step = -1
            while self.state.playing and self.state.step < self.state.n_times - 1:
                with self.state:
                    self.state.step += 1
                await asyncio.sleep(FILM_INTERVAL)
            with self.state:
                self.state.playing = False

    def update(self) -> None:
        """Asks the model where the user stands, and shows what it says."""
        point, problems = self._point()
        step = int(self.state.step) if self._exploration.times else None
        if problems:
            self._look = Look(point, step, None, None, None, (), "; ".join(problems))
        elif point != self._look.point or step != self._look.step or self._look.answer is None:
            self._look = self._exploration.look(point, 0 if step is None else step)
        self._show_texts(is_valid=not problems)
        self._show_picture()

    def _point(self) -> tuple[dict[str, float], list[str]]:
        """Returns the values that the user gave, and what is wrong with them; says so beside each."""
        point, problems = {}, []
        for i, parameter in enumerate(self._exploration.parameters):
            text, message, kind = str(self.state[f"value_{i}"]), "", ""
            try:
                point[parameter.name] = value_of(text)
                message = outside_text(parameter, point[parameter.name])
                kind = "outside" if message else ""
            except ValueError as error:
                message, kind = f"{error}; give one, such as {parameter.minimum:g}", "wrong"
                problems.append(f"{parameter.name}: {error}")
            self.state[f"message_{i}"], self.state[f"message_{i}_kind"] = message, kind
        return point, problems

    def _show_texts(self, is_valid: bool) -> None:
        look, state, exploration = self._look, self.state, self._exploration
        if look.answer is None:
            state.status, state.status_kind = f"No answer. {look.refusal}", "bad"
        elif look.remarks:
            state.status, state.status_kind = sentence_of(look.remarks), "doubt"
        else:
            state.status, state.status_kind = "An answer inside of all trained ranges.", "good"
        state.errors = [
            {"name": error.name, "text": error.text, "kind": "good" if error.is_known else "doubt"}
            for error in exploration.errors(look)
        ]
        if look.step is not None:
            unit = exploration.model.parameters[exploration.model.n_given].unit
            state.time_text = f"{exploration.times[look.step]:.6g} {'' if unit in NO_UNITS else unit}"
        state.command = exploration.command(look) if is_valid else ""
        state.python = exploration.python(look) if is_valid else ""
        numbers = numbers_of(exploration, self._outputs, look)
        kept = None if self._kept is None else numbers_of(exploration, self._outputs, self._kept)
        state.rows = rows_of(numbers, kept)
        state.has_doubt = any("doubt" in (row["a_kind"], row["b_kind"]) for row in state.rows)
        state.fields_here = look.fields is not None

    def _show_picture(self) -> None:
        if self._scene is None:
            return
        scale = self._scale()
        looks = [self._look] if self._kept is None else [self._look, self._kept]
        color = next(
            (
                each
                for look in looks
                if look.fields is not None
                for each in colors_of(look.fields)
                if each.name == self.state.color
            ),
            None,
        )
        limits = self._limits_of(color, looks)
        for side, look in enumerate(looks):
            self._scene.show(side, Shown(look.fields, color, scale, limits))
        self.state.legend = legend_of(color, limits, looks)
        self.state.picture_text = picture_text(color, limits, looks, scale)
        self._draw()

    def _scale(self) -> float:
        try:
            scale = value_of(str(self.state.scale))
        except ValueError as error:
            self.state.scale_message = f"{error}; drawn without displacement"
            return 0.0
        self.state.scale_message = ""
        return scale

    def _limits_of(self, color: Color | None, looks: list[Look]) -> tuple[float, float]:
        """Returns the scale of colors: that of all values that are shown, or the one that the user holds."""
        if color is None:
            return 0.0, 1.0
        if self.state.hold and self._limits is not None and self._limits[0] == color.name:
            return self._limits[1]
        found = [color.of(look.fields) for look in looks if look.fields is not None]
        values = np.concatenate([each[np.isfinite(each)] for each in found if each is not None])
        low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
        if high - low <= 1e-9 * max(abs(low), abs(high)):
            high = low + (1e-3 * abs(low) or 1.0)
        self._limits = color.name, (low, high)
        return low, high

    def _show_curve(self) -> None:
        state = self.state
        if len(self._look.point) < len(self._exploration.parameters):
            state.curve, state.curve_text, state.slope_text = "", "no curve: a value is missing", ""
            return
        output = next(each for each in self._outputs if each.name == state.output)
        n_points = min(61, max(9, CURVE_BUDGET // max(1, len(self._exploration.times))))
        try:
            curve, *others = [
                curve_of(self._exploration, output, state.over, look, n_points)
                for look in ([self._look] if self._kept is None else [self._look, self._kept])
            ]
        except ValueError as error:
            state.curve, state.curve_text, state.slope_text = "", f"no curve: {error}", str(error)
            return
        state.curve = svg_of(curve, others[0] if others else None)
        state.curve_text = text_of(curve)
        state.slope_text = ""
        if curve.slope is not None:
            state.slope_text = f"derivative here: {format_number(curve.slope)}"

    def _to_middle(self) -> None:
        for i, value in enumerate(self._exploration.middle().values()):
            self.state[f"value_{i}"] = f"{value:.6g}"

    def _compare(self) -> None:
        """Keeps the answer as B, or forgets it."""
        has_two = self._kept is None and self._look.answer is not None
        self._kept = self._look if has_two else None
        self.state.comparing = has_two
        self.state.kept_point = point_text(self._exploration, self._kept) if self._kept else ""
        if self._scene is not None:
            self._scene.compare(has_two)
        self._moved.set()

    def _look_from(self, name: str) -> None:
        if self._scene is not None:
            self._scene.look_from(name)
            self._draw()

    def _zoom(self, factor: float) -> None:
        if self._scene is not None:
            self._scene.zoom(factor)
            self._draw()

    def _turn(self, azimuth: float, elevation: float) -> None:
        if self._scene is not None:
            self._scene.turn(azimuth, elevation)
            self._draw()

    def _csv(self) -> str:
        """Returns the answer as a table: name, value, unit, and what speaks against the value."""
        return csv_of(self._exploration, self._outputs, self._look)

    def _png(self) -> Any:
        """Returns the picture with captions, of two sides if there are two."""
        assert self._scene is not None
        looks = [self._look] if self._kept is None else [self._look, self._kept]
        captions = tuple(
            f"{point_text(self._exploration, look)}\n{look.refusal or sentence_of(look.remarks)}".strip()
            for look in looks
        )
        has_scale = not self.state.legend["states"] and bool(self.state.legend["title"])
        return self.server.protocol.addAttachment(
            self._scene.png(captions, self.state.legend["title"], has_scale)
        )

    def _vtu(self) -> Any:
        """Returns the fields of the answer as a file for ParaView."""
        cells, fields = self._exploration.cells, self._look.fields
        assert cells is not None
        assert fields is not None
        return self.server.protocol.addAttachment(vtu(cells, self._exploration.model.nodes[1], fields))


def _filled(template: str, i: int, parameter: Parameter) -> str:
    """Returns the controls of one parameter as HTML; the slider has round steps and both ends of the range."""
    width = parameter.maximum - parameter.minimum
    step = _round_step(width / N_STEPS) if width > 0 else 1.0
    told = {
        "i": i,
        "name": escape(parameter.name),
        "unit": escape(unit_of(parameter)),
        "low": repr(parameter.minimum),
        "high": repr(parameter.maximum),
        "low_text": f"{parameter.minimum:.6g}",
        "high_text": f"{parameter.maximum:.6g}",
        "step": repr(step),
        "n": int(np.ceil(width / step - 1e-9)),
    }
    for name, value in told.items():
        template = template.replace(f"@{name}@", str(value))
    return template


def _round_step(width: float) -> float:
    """Returns the largest 1, 2 or 5 times a power of ten that is not above `width`."""
    power = 10.0 ** np.floor(np.log10(width))
    return float(max(factor for factor in (1.0, 2.0, 5.0) if factor * power <= width * (1 + 1e-9)) * power)


async def serve(page: Page, token: str, port: int, announce: Any) -> None:
    """Serves the page on the loopback interface until the task is cancelled; `announce` gets its address.

    Only clients that know the token get more than the empty page. OSError if the port is taken.
    """
    # trame and wslink log what a browser that leaves interrupts
    logging.getLogger("wslink").setLevel(logging.CRITICAL)
    server = page.server
    server.cli.set_defaults(authKey=token)
    running = asyncio.ensure_future(
        server.start(
            exec_mode="coroutine",
            host="127.0.0.1",
            port=port,
            open_browser=False,
            show_connection_info=False,
            disable_logging=True,
            thread=True,
            timeout=0,
        )
    )
    await asyncio.wait([running, asyncio.ensure_future(server.ready)], return_when=asyncio.FIRST_COMPLETED)
    if running.done():
        await running
    page.hasten()
    announce(f"http://127.0.0.1:{server.port}/index.html?secret={token}")
    await asyncio.gather(running, page.follow(), page.film(), page.polish())
