# SPDX-License-Identifier: BSD-3-Clause
"""A curve of an exploration as SVG, and in words. matplotlib would take longer than all else of an update."""

from html import escape

import numpy as np
from matplotlib.ticker import MaxNLocator

from signorom_post.arrays import FloatArray, format_number, with_unit
from signorom_post.explore.outputs import Curve
from signorom_post.palette import BLUE, INK, VERMILLION

#: [px] size of the picture, and of its frame: left, top, right, bottom
WIDTH, HEIGHT = 620.0, 190.0
LEFT, TOP, RIGHT, BOTTOM = 74.0, 12.0, 606.0, 148.0
#: half of the length of a tangent over that of the axis
TANGENT = 0.12
#: share of the height that stays free above and below the curves
FREE = 0.08


class _Frame:
    """Where values stand in the picture."""

    def __init__(self, curves: list[Curve]) -> None:
        at = np.concatenate([curve.at for curve in curves])
        values = np.concatenate([curve.values for curve in curves])
        values = values[np.isfinite(values)]
        self.x_range = _widened(at, 0.0)
        self.y_range = _widened(values, FREE)

    def x(self, at: FloatArray) -> FloatArray:
        """Returns how far to the right, in px."""
        low, high = self.x_range
        return LEFT + (RIGHT - LEFT) * (np.asarray(at) - low) / (high - low)

    def y(self, values: FloatArray) -> FloatArray:
        """Returns how far down, in px."""
        low, high = self.y_range
        return BOTTOM - (BOTTOM - TOP) * (np.asarray(values) - low) / (high - low)


def _widened(values: FloatArray, share: float) -> tuple[float, float]:
    """Returns the range of the values, wider by a share of its length; of a single value, a range around it."""
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    # what differs by rounding is one value
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        pad = 0.5 * abs(high) or 0.5
        return low - pad, high + pad
    return low - share * (high - low), high + share * (high - low)


def svg_of(curve: Curve, other: Curve | None = None) -> str:
    """Returns the picture; `other` is the curve of the answer B, to compare with."""
    frame = _Frame([curve] if other is None else [curve, other])
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" font-size="12" fill="{INK}">',
        f'<clipPath id="frame"><rect x="{LEFT}" y="{TOP - 6}" width="{RIGHT - LEFT}" '
        f'height="{BOTTOM - TOP + 12}"/></clipPath>',
        *_axes(frame),
        _text(0.5 * (LEFT + RIGHT), HEIGHT - 8, "middle", with_unit(curve.name, curve.unit)),
        '<g clip-path="url(#frame)" fill="none">',
    ]
    if other is not None:
        parts += _curve(frame, other, VERMILLION)
    parts += [*_curve(frame, curve, BLUE), "</g>"]
    for each, color, name in ((other, VERMILLION, "B"), (curve, BLUE, "A" if other is not None else "")):
        if each is not None and each.here is not None:
            x, y = float(frame.x(np.array(each.here[0]))), float(frame.y(np.array(each.here[1])))
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{color}"/>')
            parts.append(_text(x + 7, y - 7, "start", name, f'fill="{color}" font-weight="bold"'))
    return "".join([*parts, "</svg>"])


def _axes(frame: _Frame) -> list[str]:
    """Returns grid, numbers and frame."""
    parts = []
    for tick in _ticks(frame.x_range, 7):
        x = float(frame.x(tick))
        parts.append(f'<path d="M{x:.1f} {TOP}V{BOTTOM}" stroke="#e6e6e6"/>')
        parts.append(_text(x, BOTTOM + 16, "middle", f"{tick:.6g}"))
    for tick in _ticks(frame.y_range, 4):
        y = float(frame.y(tick))
        parts.append(f'<path d="M{LEFT} {y:.1f}H{RIGHT}" stroke="#e6e6e6"/>')
        parts.append(_text(LEFT - 6, y + 4, "end", f"{tick:.6g}"))
    parts.append(f'<path d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}" stroke="{INK}" fill="none"/>')
    return parts


def _ticks(limits: tuple[float, float], n: int) -> FloatArray:
    """Returns round numbers inside a range, without rounding errors around zero."""
    low, high = limits
    ticks = MaxNLocator(n).tick_values(low, high)
    ticks = np.where(np.abs(ticks) < 1e-9 * (high - low), 0.0, ticks)
    return ticks[(ticks >= low) & (ticks <= high)]


def _text(x: float, y: float, anchor: str, text: str, style: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {style}>{escape(text)}</text>'


def _curve(frame: _Frame, curve: Curve, color: str) -> list[str]:
    """Returns a curve, dotted outside of the trained box, with the tangent where the exploration stands."""
    inside = np.where(curve.is_inside, curve.values, np.nan)
    parts = [
        f'<path d="{_path(frame, curve.at, curve.values)}" stroke="{color}" stroke-dasharray="2 4"/>',
        f'<path d="{_path(frame, curve.at, inside)}" stroke="{color}" stroke-width="2"/>',
    ]
    if curve.here is not None and curve.slope is not None:
        x, y = curve.here
        reach = TANGENT * float(np.ptp(curve.at)) * np.array([-1.0, 1.0])
        parts.append(
            f'<path class="tangent" d="{_path(frame, x + reach, y + curve.slope * reach)}" stroke="{INK}" '
            'stroke-width="1.4"/>'
        )
    return parts


def _path(frame: _Frame, at: FloatArray, values: FloatArray) -> str:
    """Returns lines between points, with gaps where a value is missing."""
    path, is_down = [], False
    for x, y in zip(frame.x(at), frame.y(values), strict=True):
        if not np.isfinite(y):
            is_down = False
            continue
        path.append(f"{'L' if is_down else 'M'}{x:.1f} {y:.1f}")
        is_down = True
    return "".join(path)


def text_of(curve: Curve) -> str:
    """Returns the curve in words, for people who do not see it."""
    finite = np.isfinite(curve.values)
    if not finite.any():
        return f"{curve.output.label} over {curve.name}: no answers"
    ends = [
        f"{format_number(curve.values[i])} at {format_number(curve.at[i])}"
        for i in (int(finite.argmax()), len(finite) - 1 - int(finite[::-1].argmax()))
    ]
    text = f"{with_unit(curve.output.label, curve.output.unit)} over {with_unit(curve.name, curve.unit)}: "
    text += f"from {ends[0]} to {ends[1]}"
    if curve.here is not None:
        text += f"; here {format_number(curve.here[1])}"
    if curve.slope is not None:
        text += f", derivative {format_number(curve.slope)}"
    return text
