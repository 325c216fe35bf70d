"""Panels of curves or bars on one page, as SVG: legible without colour, since series differ in dashes and shade."""

from dataclasses import dataclass

import numpy as np

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 440, 250, 74, 14, 30, 48
COLOURS = ("#222222", "#c05a10", "#1f4e79")
DASHES = ("", "7 3", "2 3")
SHADES = ("#222222", "#e0a878", "#6f93b5")


@dataclass
class Panel:
    """Series are (name, x, y); series i has the style number `first` + i of the whole page."""

    title: str
    x: str
    y: str
    series: list
    bars: bool = False
    first: int = 0

    def svg(self, left, top):
        values = np.concatenate([y for _, _, y in self.series])
        low, high = (min(0.0, values.min()) if self.bars else values.min()), values.max()
        room = 0.06 * (high - low)
        low, high = (low if self.bars else low - room), high + room
        xs = self.series[0][1]
        ends = (xs[0] - 0.7, xs[-1] + 0.7) if self.bars else (0.0, 1.0)
        across = lambda v: left + LEFT + (v - ends[0]) / (ends[1] - ends[0]) * (WIDTH - LEFT - RIGHT)
        up = lambda v: top + HEIGHT - BOTTOM - (v - low) / (high - low) * (HEIGHT - TOP - BOTTOM)
        parts = [f'<text x="{left + LEFT}" y="{top + TOP - 9}" font-weight="bold">{self.title}</text>']
        for tick in ticks(low, high):
            y = up(tick)
            parts.append(f'<path d="M{left + LEFT} {y:.1f}H{left + WIDTH - RIGHT}" stroke="#dddddd"/>')
            parts.append(f'<text x="{left + LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
        for tick in xs[::3] if self.bars else np.linspace(0, 1, 6):
            parts.append(f'<text x="{across(tick):.1f}" y="{top + HEIGHT - BOTTOM + 16}" text-anchor="middle">{tick:g}</text>')
        parts.append(f'<text x="{left + (LEFT + WIDTH - RIGHT) / 2}" y="{top + HEIGHT - 12}" text-anchor="middle">{self.x}</text>')
        middle = top + (TOP + HEIGHT - BOTTOM) / 2
        parts.append(f'<text transform="translate({left + 14} {middle}) rotate(-90)" text-anchor="middle">{self.y}</text>')
        count = len(self.series)
        for i, (_, x, y) in enumerate(self.series):
            look = self.first + i
            if self.bars:
                width = 0.8 / count
                for a, b in zip(x, y):
                    corner, height = across(a - 0.4 + i * width), up(0.0) - up(b)
                    step = across(width) - across(0.0)
                    parts.append(f'<rect x="{corner:.2f}" y="{up(b):.2f}" width="{step:.2f}" height="{height:.2f}" fill="{SHADES[look]}" stroke="#222222" stroke-width="0.4"/>')
            else:
                points = "L".join(f"{across(a):.1f} {up(b):.1f}" for a, b in zip(x, y))
                dash = f' stroke-dasharray="{DASHES[look]}"' if DASHES[look] else ""
                parts.append(f'<path d="M{points}" fill="none" stroke="{COLOURS[look]}" stroke-width="1.8"{dash}/>')
        frame = f'x="{left + LEFT}" y="{top + TOP}" width="{WIDTH - LEFT - RIGHT}" height="{HEIGHT - TOP - BOTTOM}"'
        return parts + [f'<rect {frame} fill="none" stroke="#222222"/>']


def ticks(low, high):
    """Round numbers between low and high, some five of them."""
    raw = (high - low) / 5
    unit = 10.0 ** np.floor(np.log10(raw))
    step = unit * next(factor for factor in (1, 2, 5, 10) if unit * factor >= raw)
    return np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0


def page(title, panels):
    """The panels in two columns below a legend."""
    legend = 34
    rows = (len(panels) + 1) // 2
    width, height = 2 * WIDTH, legend + rows * HEIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'role="img" font-family="sans-serif" font-size="12" fill="#222222">',
        f"<title>{title}</title>",
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for i, name in enumerate(name for name, _, _ in panels[0].series):
        x = LEFT + 230 * i
        dash = f' stroke-dasharray="{DASHES[i]}"' if DASHES[i] else ""
        parts.append(f'<rect x="{x}" y="12" width="12" height="12" fill="{SHADES[i]}" stroke="#222222" stroke-width="0.4"/>')
        parts.append(f'<path d="M{x + 18} 18h36" stroke="{COLOURS[i]}" stroke-width="1.8"{dash}/>')
        parts.append(f'<text x="{x + 62}" y="22">{name}</text>')
    for i, panel in enumerate(panels):
        parts += panel.svg((i % 2) * WIDTH, legend + (i // 2) * HEIGHT)
    return "\n".join(parts + ["</svg>"]) + "\n"
