"""Draws docs/images/streams.svg: how far a stream's motion is planned ahead of what is travelled.

    FRONT=front.csv ARCLINE_MOVES=10000 cargo bench -p arcline-benchmarks --bench streams -- raster
    python3 docs/images/streams.py front.csv docs/images/streams.svg

front.csv has a row for each plan of the last run (10,000 moves, S-curve): time, travelled, planned; seconds.
"""
import sys

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 760, 380, 62, 52, 30, 20
SHOWN = 2.0  # seconds


def main(source, target):
    rows = [tuple(map(float, line.split(","))) for line in open(source)]
    rows = [row for row in rows if row[0] <= SHOWN + 0.5]
    most = 3.0
    x = lambda t: LEFT + t / SHOWN * (WIDTH - LEFT - RIGHT)
    y = lambda s: HEIGHT - BOTTOM - s / most * (HEIGHT - BOTTOM - TOP)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="DejaVu Sans, sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    out.append(f'<clipPath id="c"><rect x="{LEFT}" y="{TOP}" width="{WIDTH - LEFT - RIGHT}" height="{HEIGHT - TOP - BOTTOM}"/></clipPath>')
    for k in range(5):
        t, s = SHOWN * k / 4, most * k / 4
        out.append(f'<path d="M{x(t):.1f} {TOP}V{HEIGHT - BOTTOM}M{LEFT} {y(s):.1f}H{WIDTH - RIGHT}" stroke="#ddd" fill="none"/>')
        out.append(f'<text x="{x(t):.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{t:.1f}</text>')
        out.append(f'<text x="{LEFT - 8}" y="{y(s) + 4:.1f}" text-anchor="end">{s:.2f}</text>')
    steps, last = [], 0.0
    for time, _, planned in rows:
        steps += [(time, last), (time, planned)]
        last = planned
    travelled = [(time, way) for time, way, _ in rows]
    line = lambda points: "M" + "L".join(f"{x(t):.1f} {y(s):.1f}" for t, s in points)
    out.append(f'<path d="{line(steps)}" stroke="#c2410c" stroke-width="1.8" fill="none" clip-path="url(#c)"/>')
    out.append(f'<path d="{line(travelled)}" stroke="#1d4ed8" stroke-width="1.8" fill="none" clip-path="url(#c)"/>')
    out.append(f'<text x="{LEFT + 14}" y="{TOP + 18}" fill="#c2410c">planned: motion that is in force, with a stop at its end</text>')
    out.append(f'<text x="{LEFT + 14}" y="{TOP + 36}" fill="#1d4ed8">travelled</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 12}" text-anchor="middle">time since the first move was sent, s</text>')
    out.append(f'<text x="16" y="{(TOP + HEIGHT - BOTTOM) / 2}" text-anchor="middle" transform="rotate(-90 16 {(TOP + HEIGHT - BOTTOM) / 2})">motion, s</text>')
    out.append("</svg>")
    with open(target, "w") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
