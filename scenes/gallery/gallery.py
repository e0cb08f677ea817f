#!/usr/bin/env python3
"""Makes rendered pictures small enough for the README.

    gallery.py small IN.png OUT.png         as it is; above 200 kB with a palette of 256 colours
    gallery.py sheet OUT.png IN.png ...     a contact sheet, 960 wide, each picture with the name of its file
"""

import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont


def write_small(image, path, limit=200_000):
    image = image.convert("RGB")
    image.save(path, optimize=True)
    if Path(path).stat().st_size > limit:
        palette = image.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=2)
        image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
    print(f"{path}: {image.width} x {image.height}, {Path(path).stat().st_size // 1000} kB")


def sheet(paths, columns=4, width=960, gap=6, caption=18):
    cell = (width - gap * (columns + 1)) // columns
    height = cell * 9 // 16
    rows = -(-len(paths) // columns)
    page = Image.new("RGB", (width, gap + rows * (height + caption + gap)), (24, 26, 31))
    draw = ImageDraw.Draw(page)
    font = ImageFont.truetype("DejaVuSans.ttf", 12)
    for i, path in enumerate(paths):
        x = gap + i % columns * (cell + gap)
        y = gap + i // columns * (height + caption + gap)
        page.paste(Image.open(path).convert("RGB").resize((cell, height), Image.Resampling.LANCZOS), (x, y))
        draw.text((x + cell / 2, y + height + caption / 2), Path(path).stem, font=font, fill=(200, 204, 212), anchor="mm")
    return page


if __name__ == "__main__":
    if sys.argv[1] == "small":
        write_small(Image.open(sys.argv[2]), sys.argv[3])
    else:
        write_small(sheet(sys.argv[3:]), sys.argv[2])
