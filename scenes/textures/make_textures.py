#!/usr/bin/env python3
"""Makes the pictures of this folder, the same bytes every time (fixed seeds).

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install numpy pillow
    /tmp/venv/bin/python scenes/textures/make_textures.py [name ...]

Everything but earth.png (a map of a sphere) and label.png tiles: noise is made in frequency space, which is periodic by
itself, and every pattern closes at its edges. Colours are sRGB codes 0..255.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

HERE = Path(__file__).parent


def noise(shape, seed, slope=2.0, low=1.0, high=1e9, stretch=(1.0, 1.0)):
    """Periodic noise of mean 0 and deviation 1; power falls with frequency^-slope between `low` and `high` cycles.
    `stretch` (y, x): how much longer than usual the features are along each axis."""
    rng = np.random.default_rng(seed)
    fy = np.fft.fftfreq(shape[0], 1 / shape[0])[:, None] * stretch[0]
    fx = np.fft.fftfreq(shape[1], 1 / shape[1])[None, :] * stretch[1]
    f = np.hypot(fy, fx)
    gain = np.where((f >= low) & (f <= high), np.maximum(f, 1e-9) ** (-slope / 2), 0.0)
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * gain).real
    return (field - field.mean()) / field.std()


def ramp(t, stops):
    """Colour at t along [(t, (r, g, b)), ...]."""
    xs = [s[0] for s in stops]
    return np.stack([np.interp(t, xs, [s[1][c] for s in stops]) for c in range(3)], axis=-1)


def smooth(a, b, x):
    t = np.clip((x - a) / (b - a), 0, 1)
    return t * t * (3 - 2 * t)


def bump(height, strength, light=(-0.5, -0.65, 0.58)):
    """Brightness of a periodic height field lit from the upper left: 1 where it is level."""
    gx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * 0.5 * strength
    gy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * 0.5 * strength
    n = np.stack([-gx, -gy, np.ones_like(gx)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    l = np.array(light) / np.linalg.norm(light)
    return np.clip(n @ l, 0, None) / l[2]


def save(name, rgb, colors=None):
    """Writes a PNG; `colors`: with a palette of so many entries, which keeps grainy pictures small."""
    image = Image.fromarray(np.clip(np.rint(rgb), 0, 255).astype(np.uint8), "RGB")
    if colors:
        image = image.quantize(colors, method=Image.Quantize.MEDIANCUT, kmeans=3, dither=Image.Dither.NONE)
    path = HERE / f"{name}.png"
    image.save(path, optimize=True)
    print(f"{path}: {image.width} x {image.height}, {path.stat().st_size // 1000} kB")


def board(width, height, seed, knots, rings=8):
    """Brightness 0..1 of a sawn board, grain along y, periodic in y; `rings`: year rings in its width."""
    rng = np.random.default_rng(seed)
    y = np.arange(height)[:, None] / height
    x = (np.arange(width)[None, :] + 0.5) / width
    # The saw cuts a crooked trunk: the pith wanders below the surface, so the rings show as cathedral arches.
    def wander(amplitude, harmonics):
        out = 0
        for k in range(1, harmonics + 1):
            out = out + amplitude / k * np.sin(2 * np.pi * (k * y + rng.random()))
        return out
    pith = 0.5 + rng.uniform(-0.5, 0.5) + wander(0.22, 3)
    depth = 0.35 + np.abs(wander(0.4, 2))
    aspect = height / width
    ring = np.hypot(x - pith, depth)
    dark = np.zeros((height, width))
    for _ in range(knots):
        kx, ky, size = rng.uniform(0.25, 0.75), rng.random(), rng.uniform(0.07, 0.11)
        dy = ((y - ky + 0.5) % 1.0 - 0.5) * aspect
        d = np.hypot((x - kx), dy * 0.8)
        # Grain flows around a knot, and the knot has rings of its own.
        ring = ring + 0.16 * np.exp(-((x - kx) / 0.28) ** 2 - (dy / 0.55) ** 2) * np.tanh((x - kx) / size)
        dark = np.maximum(dark, smooth(size * 1.25, size * 0.6, d) * (0.75 + 0.25 * np.sin(d / size * 16)))
    fibre = noise((height, width), seed + 1, slope=1.6, low=4, stretch=(14.0, 1.0))
    phase = ring * rings + 0.07 * fibre + 0.25 * noise((height, width), seed + 2, slope=3, low=1, high=6, stretch=(3.0, 1.0))
    saw = phase - np.floor(phase)
    late = np.where(saw < 0.8, saw / 0.8, (1 - saw) / 0.2) ** 2.2  # slow darkening, sudden early wood
    pores = smooth(1.3, 2.6, noise((height, width), seed + 3, slope=0.4, low=12, stretch=(22.0, 1.0)))
    value = 0.70 - 0.30 * late + 0.055 * fibre - 0.16 * pores
    return np.clip(value * (1 - 0.72 * dark), 0, 1)


def fence():
    size = 512
    rng = np.random.default_rng(11)
    widths = np.array([90, 80, 88, 82, 92, 80])  # 512 in all, gaps included
    gap = 9
    rgb = np.zeros((size, size, 3))
    # Behind the gaps it is dark, and two rails are seen dimly.
    y = np.arange(size)[:, None] / size
    rails = np.exp(-(((y - 0.22) / 0.07) ** 6)) + np.exp(-(((y - 0.78) / 0.07) ** 6))
    rgb[:] = (np.array([20, 15, 12]) + rails[..., None] * np.array([34, 24, 15]))
    x0 = 0
    for i, w in enumerate(widths):
        bw = w - gap
        value = board(bw, size, 100 * (i + 1), knots=[1, 0, 2, 1, 0, 1][i])
        tint = rng.uniform(-1, 1)
        color = ramp(value, [(0.0, (44, 25, 12)), (0.35, (112, 68, 33)), (0.62, (172, 116, 63)), (0.85, (206, 154, 96)), (1.0, (226, 182, 126))])
        color *= 1 + 0.09 * tint
        color[..., 2] *= 1 - 0.06 * rng.uniform(-1, 1)
        weather = noise((size, bw), 100 * (i + 1) + 7, slope=2.4, low=1, high=30, stretch=(3.0, 1.0))
        grey = color.mean(-1, keepdims=True) * np.array([1.0, 0.98, 0.93])
        mix = (0.10 + 0.10 * np.clip(weather, 0, 2))[..., None]
        color = color * (1 - mix) + grey * mix
        # Edges: worn, a lit bevel on the left, a shaded one on the right; a waver so that no edge is ruled.
        waver = 1.2 * noise((size, 1), 100 * (i + 1) + 9, slope=2.5, low=2, high=40)[:, :1]
        x = np.arange(bw)[None, :] + 0.5
        left, right = x - (1.2 + 0.5 * waver), (bw - 1.2 + 0.5 * np.roll(waver, 131, 0)) - x
        light = 1 + 0.22 * np.exp(-((left - 2.0) / 1.6) ** 2) - 0.50 * np.exp(-np.clip(right, 0, None) / 2.2) - 0.35 * np.exp(-np.clip(left, 0, None) / 0.9)
        light *= 1 + 0.05 * np.sin(np.pi * (x / bw)) # slightly cupped
        color *= light[..., None]
        cover = (smooth(-0.6, 0.6, left) * smooth(-0.6, 0.6, right))[..., None]
        # Two nails on each rail, with the run of rust below them.
        yy = np.arange(size)[:, None] + 0.5
        for rail in (0.22, 0.78):
            for side in (0.27, 0.73):
                nx, ny = side * bw + rng.uniform(-3, 3), rail * size + rng.uniform(-5, 5)
                below = yy - ny
                rust = np.exp(-((x - nx) / (1.6 + 0.012 * np.clip(below, 0, None))) ** 2) * smooth(0, 5, below) * np.exp(-np.clip(below, 0, None) / 26)
                color = color * (1 - 0.42 * rust[..., None] * np.array([0.7, 0.95, 1.1]))
                d = np.hypot(x - nx, yy - ny)
                color *= (1 - 0.55 * smooth(7.0, 3.4, np.hypot(x - nx - 1.2, yy - ny - 1.6)))[..., None]
                shine = np.exp(-(np.hypot(x - nx + 1.2, yy - ny + 1.4) / 1.5) ** 2)
                metal = np.array([82, 80, 80]) + 120 * shine[..., None] - 14 * smooth(2, 4, d)[..., None]
                head = smooth(4.4, 3.4, d)[..., None]
                color = color * (1 - head) + metal * head
        strip = rgb[:, x0 : x0 + bw]
        rgb[:, x0 : x0 + bw] = strip * (1 - cover) + color * cover
        x0 += w
    save("fence", rgb, colors=112)


def stone():
    """Coursed rubble: rows of stones with rounded, chipped edges in pale mortar."""
    size = 512
    rng = np.random.default_rng(23)
    rows = np.array([78, 60, 92, 66, 84, 58, 74])
    height = np.zeros((size, size))
    albedo = np.zeros((size, size, 3))
    wx = 3.2 * noise((size, size), 31, slope=3.0, low=2, high=24) + 0.9 * noise((size, size), 32, slope=2.0, low=16, high=90)
    wy = 3.2 * noise((size, size), 33, slope=3.0, low=2, high=24) + 0.9 * noise((size, size), 34, slope=2.0, low=16, high=90)
    px, py = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    px, py = px + wx, py + wy
    rough = noise((size, size), 35, slope=2.3, low=3)
    pits = noise((size, size), 36, slope=1.2, low=30, high=160)
    strata = noise((size, size), 37, slope=2.2, low=3, stretch=(0.5, 2.2))
    mortar = np.array([187, 178, 160]) + 9 * noise((size, size), 38, slope=1.2, low=20)[..., None] + 5 * rough[..., None]
    palette = np.array([(134, 128, 120), (154, 142, 124), (118, 116, 114), (164, 150, 126), (128, 120, 108), (146, 140, 134), (142, 122, 100), (112, 114, 120)])
    top, last = 0, -1
    mask = np.zeros((size, size))
    for row, h in enumerate(rows):
        widths = []
        while sum(widths) < size - 60:
            widths.append(rng.uniform(0.85, 1.9) * h + 18)
        widths = np.array(widths) * size / sum(widths)
        x = rng.uniform(0, size)
        for w in widths:
            cx, cy = x + w / 2, top + h / 2
            x += w
            shrink = 3.1 + rng.uniform(-0.5, 0.9)
            hw, hh = w / 2 - shrink, h / 2 - shrink
            r = min(hw, hh) * rng.uniform(0.38, 0.6)
            dx = (px - cx + size / 2) % size - size / 2
            dy = (py - cy + size / 2) % size - size / 2
            turn = rng.uniform(-0.035, 0.035)
            dx, dy = dx + turn * dy, dy - turn * dx
            qx, qy = np.abs(dx) - (hw - r), np.abs(dy) - (hh - r)
            d = r - np.hypot(np.maximum(qx, 0), np.maximum(qy, 0)) - np.minimum(np.maximum(qx, qy), 0)  # inward distance
            inside = smooth(-0.7, 0.7, d)
            dome = 9.0 * (1 - np.exp(-np.clip(d, 0, None) / 5.0)) + 3.2 * np.clip(d / r, 0, 1) ** 0.7
            tilt = rng.uniform(-0.05, 0.05) * dx + rng.uniform(-0.05, 0.05) * dy
            relief = dome + tilt + (1.5 * rough + 0.45 * pits + 0.8 * strata) * smooth(0, 6, d)
            height = np.maximum(height, relief * inside)
            pick = rng.integers(len(palette))
            pick = pick if pick != last else (pick + 3) % len(palette)
            last = pick
            tone = palette[pick] * rng.uniform(0.92, 1.1)
            warm = np.clip(noise((size, size), int(rng.integers(1 << 30)), slope=2.6, low=2, high=40), -2, 2)[..., None]
            color = tone * (1 + 0.055 * rough[..., None] + 0.05 * strata[..., None] + 0.03 * pits[..., None]) + warm * np.array([7, 4, 0])
            albedo = albedo * (1 - inside[..., None]) + color * inside[..., None]
            mask = np.maximum(mask, inside)
        top += h
    lichen = smooth(1.55, 2.3, noise((size, size), 41, slope=2.2, low=5, high=60) + 0.3 * pits) * mask
    albedo = albedo * (1 - 0.55 * lichen[..., None]) + np.array([166, 164, 112]) * 0.55 * lichen[..., None]
    rgb = albedo * mask[..., None] + mortar * (1 - mask[..., None])
    bed = height + (1 - mask) * (1.2 + 0.25 * pits)
    # Joints lie deep: what is lower than its surroundings gets less light from the sky.
    around = sum(np.roll(np.roll(bed, i, 0), j, 1) for i in range(-6, 7, 3) for j in range(-6, 7, 3)) / 25
    occlusion = np.clip(1 - 0.055 * np.clip(around - bed, 0, 9), 0.45, 1)
    rgb = rgb * (0.42 + 0.58 * bump(bed, 0.42))[..., None] * occlusion[..., None]
    save("stone", rgb, colors=96)


def planks():
    """A floor of oiled planks lying along x."""
    size, rows = 512, 4
    rng = np.random.default_rng(51)
    rgb = np.zeros((size, size, 3))
    h = size // rows
    for row in range(rows):
        cut = int(rng.uniform(0.1, 0.9) * size)
        value = np.roll(board(h, size, 900 + 10 * row, knots=[1, 0, 0, 1][row], rings=9).T, cut, 1)
        color = ramp(value, [(0.0, (38, 20, 10)), (0.35, (92, 52, 27)), (0.62, (140, 87, 48)), (0.85, (170, 114, 68)), (1.0, (190, 136, 88))])
        color *= 1 + 0.10 * rng.uniform(-1, 1)
        y = np.arange(h)[:, None] + 0.5
        groove = 1 - 0.68 * np.exp(-((np.minimum(y, h - y)) / 1.3) ** 2)
        x = np.arange(size)[None, :] + 0.5
        end = 1 - 0.68 * np.exp(-(np.abs(x - cut) / 1.3) ** 2)
        rgb[row * h : (row + 1) * h] = color * groove[..., None] * end[..., None]
    save("planks", rgb, colors=128)


def marble():
    size = 384
    y, x = np.mgrid[0:size, 0:size] / size
    warp = noise((size, size), 61, slope=4.6, low=1, high=64)
    warp2 = noise((size, size), 62, slope=4.2, low=2, high=90)
    # Whole numbers of waves across both sides, so it tiles.
    vein = np.abs(np.sin(np.pi * (2 * x + 2 * y) + 1.0 * warp + 0.3 * warp2))
    fine = np.abs(np.sin(np.pi * (2 * x - 4 * y) + 1.5 * warp2 + 0.8 * warp))
    cloud = noise((size, size), 63, slope=2.8, low=2)
    t = np.clip(0.74 * (1 - np.exp(-vein / (0.13 + 0.07 * np.clip(warp2, -1, 1)))) + 0.26 * (1 - np.exp(-fine / 0.10)) + 0.05 * cloud, 0, 1)
    rgb = ramp(t, [(0.0, (84, 88, 94)), (0.45, (158, 160, 162)), (0.8, (222, 221, 218)), (1.0, (246, 244, 240))])
    save("marble", rgb, colors=96)


def solid_noise(p, seed, octaves, gain=0.5):
    """Sum of octaves of value noise at points p (.., 3): for a sphere, where tiling noise will not do."""
    rng = np.random.default_rng(seed)
    lattice = rng.standard_normal((32, 32, 32))
    out = np.zeros(p.shape[:-1])
    for o in range(octaves):
        q = p * 2.0**o + 17.3 * o
        i = np.floor(q).astype(int)
        f = q - i
        f = f * f * f * (f * (f * 6 - 15) + 10)
        total = 0
        for c in range(8):
            b = [(c >> k) & 1 for k in range(3)]
            w = np.prod([f[..., k] if b[k] else 1 - f[..., k] for k in range(3)], axis=0)
            total = total + w * lattice[(i[..., 0] + b[0]) % 32, (i[..., 1] + b[1]) % 32, (i[..., 2] + b[2]) % 32]
        out += gain**o * total
    return out


def earth():
    """A planet of our own, as a map: u runs once around, v from pole to pole."""
    w, h = 768, 384
    lat = (0.5 - (np.arange(h) + 0.5) / h) * np.pi
    lon = ((np.arange(w) + 0.5) / w - 0.5) * 2 * np.pi
    lon, lat = np.meshgrid(lon, lat)
    p = np.stack([np.cos(lat) * np.sin(lon), np.sin(lat), np.cos(lat) * np.cos(lon)], -1)
    bend = np.stack([solid_noise(p * 2.0, s, 4) for s in (71, 72, 73)], -1)
    land = solid_noise(p * 1.45 + 0.30 * bend, 74, 8, 0.55) - 0.12
    detail = solid_noise(p * 9, 75, 5)
    sea = ramp(np.clip(-land * 1.1, 0, 1), [(0.0, (76, 160, 176)), (0.10, (38, 106, 150)), (0.4, (18, 62, 112)), (1.0, (9, 34, 74))])
    warmth = np.cos(lat) ** 1.3 - 0.42 * np.clip(land, 0, 2) + 0.09 * detail
    dry = solid_noise(p * 2.2, 76, 5) + 1.1 * np.exp(-((np.abs(lat) - 0.42) / 0.2) ** 2) - 0.5
    green = ramp(np.clip(warmth, 0, 1), [(0.0, (228, 230, 232)), (0.22, (132, 130, 108)), (0.45, (84, 108, 58)), (0.75, (58, 104, 44)), (1.0, (36, 92, 40))])
    sand = ramp(np.clip(warmth, 0, 1), [(0.0, (228, 226, 222)), (0.3, (158, 140, 108)), (0.7, (204, 172, 116)), (1.0, (214, 178, 112))])
    k = smooth(-0.2, 0.7, dry)[..., None]
    ground = (green * (1 - k) + sand * k) * (1 + 0.06 * detail[..., None])
    ground *= (1 - 0.25 * smooth(0.5, 1.4, land))[..., None]
    coast = smooth(-0.012, 0.02, land)[..., None]
    rgb = sea * (1 - coast) + ground * coast
    ice = smooth(1.22, 1.34, np.abs(lat) + 0.09 * solid_noise(p * 5, 77, 5))[..., None]
    rgb = rgb * (1 - ice) + np.array([238, 243, 247]) * ice
    clouds = solid_noise(p * np.array([2.4, 5.0, 2.4]) + 0.55 * bend, 78, 7, 0.58)
    c = (0.85 * smooth(0.45, 1.7, clouds))[..., None]
    rgb = rgb * (1 - c) + np.array([250, 250, 250]) * c
    save("earth", rgb, colors=192)


def label():
    """A picture with an up, a left and four different edges: shows mirroring and wrapping at a glance."""
    size = 256
    big = size * 4
    image = Image.new("RGB", (big, big), (250, 243, 224))
    draw = ImageDraw.Draw(image)
    t = big // 16
    draw.polygon([(0, 0), (big, 0), (big - t, t), (t, t)], fill=(38, 84, 124))  # top: blue
    draw.polygon([(0, big), (big, big), (big - t, big - t), (t, big - t)], fill=(196, 62, 48))  # bottom: red
    draw.polygon([(0, 0), (t, t), (t, big - t), (0, big)], fill=(232, 170, 44))  # left: yellow
    draw.polygon([(big, 0), (big - t, t), (big - t, big - t), (big, big)], fill=(64, 132, 84))  # right: green
    # A sun high on the right, hills low: no symmetry anywhere.
    cx, cy, r = big * 0.70, big * 0.30, big * 0.10
    for k in range(12):
        a = k * np.pi / 6
        draw.line([(cx + np.cos(a) * r * 1.3, cy + np.sin(a) * r * 1.3), (cx + np.cos(a) * r * 1.75, cy + np.sin(a) * r * 1.75)], fill=(232, 140, 40), width=big // 56)
    draw.ellipse([cx - r, cy - r, cx + r, cy + r], fill=(238, 158, 48))
    s = np.linspace(t, big - t, 200)
    for base, amp, ph, col in [(0.66, 0.07, 0.4, (120, 168, 128)), (0.76, 0.06, 2.4, (64, 124, 104)), (0.86, 0.03, 4.3, (30, 82, 92))]:
        pts = [(x, big * (base + amp * np.sin(2 * np.pi * x / big * 1.15 + ph))) for x in s]
        draw.polygon(pts + [(big - t, big - t), (t, big - t)], fill=col)
    font = ImageFont.truetype("DejaVuSans-Bold.ttf", int(big * 0.24))
    draw.text((big * 0.10, big * 0.40), "glimt", font=font, fill=(28, 40, 64))
    save("label", np.asarray(image.resize((size, size), Image.Resampling.LANCZOS)), colors=128)


PICTURES = {f.__name__: f for f in (fence, stone, planks, marble, earth, label)}

if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        PICTURES[name]()
