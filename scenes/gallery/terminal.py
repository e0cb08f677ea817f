#!/usr/bin/env python3
"""Draws a captured terminal screen as a picture.

    tmux capture-pane -e -p -t NAME > screen.txt
    terminal.py screen.txt OUT.png [columns rows]

Text is set in DejaVu Sans Mono; blocks and lines of boxes are drawn as rectangles, so that cells join without gaps.
"""

import re
import sys
import unicodedata

from PIL import Image, ImageDraw, ImageFont

CELL_W, CELL_H, SIZE = 10, 20, 16
INK, PAPER = (208, 212, 220), (18, 20, 24)
BASIC = [(0, 0, 0), (205, 49, 49), (13, 188, 121), (229, 229, 16), (36, 114, 200), (188, 63, 188), (17, 168, 205), (204, 204, 204),
         (118, 118, 118), (241, 76, 76), (35, 209, 139), (245, 245, 67), (59, 142, 234), (214, 112, 214), (41, 184, 219), (242, 242, 242)]


def indexed(n):
    if n < 16:
        return BASIC[n]
    if n < 232:
        n -= 16
        return tuple(0 if v == 0 else 55 + 40 * v for v in (n // 36, n // 6 % 6, n % 6))
    return (8 + 10 * (n - 232),) * 3


def style(codes, state):
    codes = [int(c or 0) for c in re.split("[;:]", codes)] if codes else [0]
    while codes:
        c = codes.pop(0)
        if c == 0:
            state.update(fg=INK, bg=PAPER, bold=False, dim=False, reverse=False)
        elif c in (1, 2, 7):
            state[{1: "bold", 2: "dim", 7: "reverse"}[c]] = True
        elif c == 22:
            state.update(bold=False, dim=False)
        elif c == 27:
            state["reverse"] = False
        elif c in (38, 48):
            kind = codes.pop(0)
            value = indexed(codes.pop(0)) if kind == 5 else tuple(codes.pop(0) for _ in range(3))
            state["fg" if c == 38 else "bg"] = value
        elif 30 <= c <= 37 or 90 <= c <= 97:
            state["fg"] = BASIC[c - 30 if c < 90 else c - 82]
        elif 40 <= c <= 47 or 100 <= c <= 107:
            state["bg"] = BASIC[c - 40 if c < 100 else c - 92]
        elif c == 39:
            state["fg"] = INK
        elif c == 49:
            state["bg"] = PAPER


def fractions(ch):
    """Parts of the cell that a block character covers, as (left, top, right, bottom) in 0..1."""
    n = ord(ch)
    if ch == "▀":
        return [(0, 0, 1, 0.5)]
    if ch == "▐":
        return [(0.5, 0, 1, 1)]
    if ch == "▔":
        return [(0, 0, 1, 0.125)]
    if 0x2581 <= n <= 0x2588:
        return [(0, 1 - (n - 0x2580) / 8, 1, 1)]
    if 0x2589 <= n <= 0x258F:
        return [(0, 0, (0x2590 - n) / 8, 1)]
    quadrants = {"▖": "c", "▗": "d", "▘": "a", "▙": "acd", "▚": "ad", "▛": "abc", "▜": "abd", "▝": "b", "▞": "bc", "▟": "bcd"}
    place = {"a": (0, 0, 0.5, 0.5), "b": (0.5, 0, 1, 0.5), "c": (0, 0.5, 0.5, 1), "d": (0.5, 0.5, 1, 1)}
    return [place[q] for q in quadrants.get(ch, "")]


LINES = {"─": "lr", "│": "tb", "┌": "rb", "┐": "lb", "└": "rt", "┘": "lt", "├": "tbr", "┤": "tbl", "┬": "lrb", "┴": "lrt", "┼": "lrtb",
         "╭": "rb", "╮": "lb", "╰": "rt", "╯": "lt", "━": "LR", "┃": "TB"}


def draw(text, columns, rows):
    image = Image.new("RGB", (columns * CELL_W, rows * CELL_H), PAPER)
    pen = ImageDraw.Draw(image)
    fonts = [ImageFont.truetype(f"DejaVuSansMono{w}.ttf", SIZE) for w in ("", "-Bold")]
    state = {}
    style("", state)
    for row, line in enumerate(text.split("\n")[:rows]):
        column = 0
        for escape, ch in re.findall("\x1b\\[([0-9;:]*)m|([^\x1b])", line):
            if not ch:
                style(escape, state)
                continue
            fg, bg = (state["bg"], state["fg"]) if state["reverse"] else (state["fg"], state["bg"])
            if state["dim"]:
                fg = tuple((3 * f + 2 * b) // 5 for f, b in zip(fg, bg))
            x, y = column * CELL_W, row * CELL_H
            wide = 2 if unicodedata.east_asian_width(ch) in "WF" else 1
            pen.rectangle((x, y, x + wide * CELL_W - 1, y + CELL_H - 1), fill=bg)
            parts, strokes = fractions(ch), LINES.get(ch)
            mx, my = x + CELL_W // 2, y + CELL_H // 2
            if parts:
                for l, t, r, b in parts:
                    pen.rectangle((x + round(l * CELL_W), y + round(t * CELL_H), x + round(r * CELL_W) - 1, y + round(b * CELL_H) - 1), fill=fg)
            elif ch in "░▒▓":
                k = {"░": 1, "▒": 2, "▓": 3}[ch]
                pen.rectangle((x, y, x + CELL_W - 1, y + CELL_H - 1), fill=tuple((k * f + (4 - k) * b) // 4 for f, b in zip(fg, bg)))
            elif strokes:
                for s in strokes:
                    half = 1 if s.isupper() else 0
                    box = {"l": (x, my - half, mx, my + half), "r": (mx, my - half, x + CELL_W - 1, my + half),
                           "t": (mx - half, y, mx + half, my), "b": (mx - half, my, mx + half, y + CELL_H - 1)}[s.lower()]
                    pen.rectangle(box, fill=fg)
            elif ch != " ":
                pen.text((x, y + CELL_H - 5), ch, font=fonts[state["bold"]], fill=fg, anchor="ls")
            column += wide
    return image


if __name__ == "__main__":
    columns, rows = (int(v) for v in sys.argv[3:5]) if len(sys.argv) > 3 else (120, 36)
    picture = draw(open(sys.argv[1], encoding="utf-8").read(), columns, rows)
    picture.quantize(256, method=Image.Quantize.MEDIANCUT, kmeans=2, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
