"""Draws a trace of `arcline-server simulate … --trace`: the path in the plane of two axes, and position, velocity and
acceleration over time. Standard library only.

    python3 docs/images/draw.py TRACE.csv OUT.svg [X Y]
"""

import csv
import math
import sys

COLOURS = {"path": "#1f5fa8", 0: "#1f5fa8", 1: "#c2541b", "sum": "#333333"}
INK, GRID = "#333333", "#dddddd"


def read(file, axes):
    with open(file, newline="") as text:
        rows = list(csv.DictReader(text))
    columns = {"t": [float(row["time_s"]) for row in rows]}
    for axis in axes:
        for name in ("CommandPosition", "CommandVelocity", "CommandAcceleration"):
            columns[axis, name] = [float(row[f"{axis}.{name}"]) for row in rows]
    return columns


def nice_step(span, count):
    raw = span / count
    power = 10 ** math.floor(math.log10(raw))
    return next(power * m for m in (1, 2, 5, 10) if power * m >= raw)


def ticks(low, high, count):
    step = nice_step(high - low, count)
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [i * step for i in range(first, last + 1)]


class Panel:
    """One diagram: a rectangle on the page and the range of values it shows."""

    def __init__(self, left, top, width, height, x_range, y_range):
        self.box = left, top, width, height
        self.x_range, self.y_range = x_range, y_range
        self.parts = []

    def point(self, x, y):
        left, top, width, height = self.box
        (x0, x1), (y0, y1) = self.x_range, self.y_range
        return left + (x - x0) / (x1 - x0) * width, top + height - (y - y0) / (y1 - y0) * height

    def grid(self, x_label, y_label, x_numbers=True, counts=(6, 4)):
        left, top, width, height = self.box
        for x in ticks(*self.x_range, counts[0]):
            px, _ = self.point(x, 0)
            self.parts.append(f'<path d="M{px:.1f} {top}v{height}" stroke="{GRID}"/>')
            if x_numbers:
                self.text(px, top + height + 15, f"{x:g}", "middle")
        for y in ticks(*self.y_range, counts[1]):
            _, py = self.point(0, y)
            self.parts.append(f'<path d="M{left} {py:.1f}h{width}" stroke="{GRID}"/>')
            self.text(left - 6, py + 4, f"{y:g}", "end")
        self.parts.append(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#999999"/>')
        if x_label:
            self.text(left + width / 2, top + height + 32, x_label, "middle")
        self.text(left, top - 7, y_label, "start")

    def text(self, x, y, text, anchor, colour=INK):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def curve(self, xs, ys, colour, width=1.8, dash=""):
        # A pen's width is all that can be seen: points nearer than that to the last one are left out.
        kept = [self.point(xs[0], ys[0])]
        for here in map(self.point, xs, ys):
            if math.dist(here, kept[-1]) >= 0.8:
                kept.append(here)
        kept.append(self.point(xs[-1], ys[-1]))
        points = " ".join("%.1f,%.1f" % here for here in kept)
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{width}"{dash}/>')


def spread(*curves):
    low, high = min(min(c) for c in curves), max(max(c) for c in curves)
    margin = 0.08 * (high - low or 1.0)
    return low - margin, high + margin


def draw(file, axes):
    data = read(file, axes)
    t = data["t"]
    x, y = (data[axis, "CommandPosition"] for axis in axes)
    (x0, x1), (y0, y1) = spread(x), spread(y)
    # The same scale in both directions.
    width, height = 380, 380
    scale = max((x1 - x0) / width, (y1 - y0) / height)
    xm, ym = (x0 + x1) / 2, (y0 + y1) / 2
    plane = Panel(60, 40, width, height, (xm - scale * width / 2, xm + scale * width / 2),
                  (ym - scale * height / 2, ym + scale * height / 2))
    plane.grid(f"{axes[0]} / mm", f"{axes[1]} / mm: the path, one dot every 20 ms", counts=(6, 6))
    plane.curve(x, y, COLOURS["path"], 1.2)
    step = max(1, round(0.02 / (t[1] - t[0])))
    for i in range(0, len(t), step):
        px, py = plane.point(x[i], y[i])
        plane.parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="2.2" fill="{COLOURS["path"]}"/>')
    parts = plane.parts
    rows = [("CommandPosition", "position / mm"), ("CommandVelocity", "velocity / mm/s"),
            ("CommandAcceleration", "acceleration / mm/s²")]
    for i, (name, label) in enumerate(rows):
        curves = [data[axis, name] for axis in axes]
        last = i == len(rows) - 1
        panel = Panel(520, 40 + i * 135, 420, 110, (t[0], t[-1]), spread(*curves))
        panel.grid("time / s" if last else "", label, x_numbers=last)
        for k, curve in enumerate(curves):
            panel.curve(t, curve, COLOURS[k])
        if i == 0:
            for k, axis in enumerate(axes):
                panel.text(930 - 24 * (len(axes) - 1 - k), 33, axis, "end", COLOURS[k])
        parts = parts + panel.parts
    return ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 470" width="960" height="470" '
            'font-family="sans-serif" font-size="12"><rect width="960" height="470" fill="#ffffff"/>\n'
            + "\n".join(parts) + "\n</svg>\n")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 5):
        sys.exit(__doc__)
    chosen = sys.argv[3:] or ["X", "Y"]
    with open(sys.argv[2], "w") as out:
        out.write(draw(sys.argv[1], chosen))
