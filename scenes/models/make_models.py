#!/usr/bin/env python3
"""Makes the models of this folder (no packages needed): python3 scenes/models/make_models.py

knot.obj       a trefoil tube, 7,920 triangles as 3,960 quads, smooth normals, uv, a spiral of three materials (knot.mtl)
gem.obj        a round brilliant: 110 triangles as 73 flat facets without normals; use it with `crease = 0`
sphereflake.txt  the 7,381 balls of Eric Haines' Standard Procedural Databases ("balls", size factor 4): x y z radius
"""

from math import acos, asin, cos, hypot, pi, sin, sqrt, tan
from pathlib import Path

HERE = Path(__file__).parent


def add(a, b): return tuple(x + y for x, y in zip(a, b))
def sub(a, b): return tuple(x - y for x, y in zip(a, b))
def mul(a, k): return tuple(x * k for x in a)
def dot(a, b): return sum(x * y for x, y in zip(a, b))
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
def unit(a): return mul(a, 1 / sqrt(dot(a, a)))


def text(v, digits):
    return " ".join(f"{x:.{digits}f}".rstrip("0").rstrip(".") or "0" for x in (x if abs(x) >= 10**-digits else 0.0 for x in v))


def knot(along=220, around=18, turns=-5, torus=0.62, minor=0.27, tube=0.145):
    """A (2, 3) torus knot about the y axis, swept with a circle. The grid winds around the tube, a whole number of `turns`
    before it closes, so that stripes along the grid are spirals with smooth edges."""
    def centre(s):
        r = torus + minor * cos(3 * s)
        return (r * cos(2 * s), minor * sin(3 * s) * 1.15, r * sin(2 * s))

    def frame(s):
        d = 1e-5
        tangent = unit(sub(centre(s + d), centre(s - d)))
        # The torus' own normal closes after one turn of the knot, so the seam fits without a correction.
        outward = (cos(3 * s) * cos(2 * s), sin(3 * s), cos(3 * s) * sin(2 * s))
        side = unit(sub(outward, mul(tangent, dot(outward, tangent))))
        return side, cross(side, tangent)

    lines = ["# Trefoil knot, made by make_models.py for glimt (same licence as the program)", "mtllib knot.mtl", "o knot"]
    points, normals, uvs, faces = [], [], [], {"coral": [], "ivory": [], "teal": []}
    for i in range(along):
        s = 2 * pi * i / along
        c, (a, b) = centre(s), frame(s)
        for j in range(around):
            t = 2 * pi * (j / around + turns * i / along)
            n = add(mul(a, cos(t)), mul(b, sin(t)))
            normals.append(n)
            points.append(add(c, mul(n, tube)))
    for i in range(along + 1):
        for j in range(around + 1):
            uvs.append((i / along, j / around))
    for i in range(along):
        for j in range(around):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            quad = []
            for ci, cj in corners:
                p = (ci % along) * around + cj % around + 1
                quad.append(f"{p}/{ci * (around + 1) + cj + 1}/{p}")
            faces["coral" if j < 8 else "ivory" if j < 10 else "teal" if j < 16 else "ivory"].append("f " + " ".join(quad))
    # Counter-clockwise from outside: turn the faces if the first one looks inward.
    p0, p1, p2 = points[0], points[around], points[around + 1]
    if dot(cross(sub(p1, p0), sub(p2, p0)), normals[0]) < 0:
        faces = {m: ["f " + " ".join(reversed(f.split()[1:])) for f in fs] for m, fs in faces.items()}
    lines += ["v " + text(p, 5) for p in points]
    lines += ["vt " + text(p, 4) for p in uvs]
    lines += ["vn " + text(p, 4) for p in normals]
    for material, fs in faces.items():
        lines += [f"usemtl {material}"] + fs
    (HERE / "knot.obj").write_text("\n".join(lines) + "\n")
    (HERE / "knot.mtl").write_text(
        "# Enamel in three colours. illum 2 is Phong; Ks and Ns make the highlight.\n"
        + "".join(
            f"newmtl {name}\nKa {kd}\nKd {kd}\nKs 0.6 0.6 0.6\nNs 90\nillum 2\n\n"
            for name, kd in [("coral", "0.78 0.11 0.06"), ("ivory", "0.86 0.78 0.60"), ("teal", "0.02 0.24 0.27")]
        )
    )


def gem():
    """A round brilliant of girdle radius 1 about y = 0: 8-fold table, crown 34.5, pavilion 40.75 degrees; every kite is
    planar, because its side corners are laid on the line between its tip and its foot."""
    table, half_girdle, crown, pavilion = 0.55, 0.02, 34.5, 40.75
    top = half_girdle + (1 - table) * tan(crown * pi / 180)
    culet = -half_girdle - tan(pavilion * pi / 180)
    points = []

    def ring(n, radius, y, turn=0.0):
        first = len(points) + 1
        points.extend((radius * sin((k + turn) * 2 * pi / n), y, radius * cos((k + turn) * 2 * pi / n)) for k in range(n))
        return lambda k: first + k % n

    def between(r0, y0, r1, y1, t):
        return (r0 + t * (r1 - r0)) / cos(pi / 8), y0 + t * (y1 - y0)

    a = ring(8, table, top)
    b = ring(8, *between(table, top, 1, half_girdle, 0.52), turn=0.5)
    g = ring(16, 1, half_girdle)
    h = ring(16, 1, -half_girdle)
    low = ring(8, *between(1, -half_girdle, 0, culet, 0.76), turn=0.5)
    points.append((0, culet, 0))
    tip = len(points)
    faces = [[a(k) for k in range(8)]]
    for k in range(8):
        faces += [[a(k), b(k), a(k + 1)], [a(k), b(k - 1), g(2 * k), b(k)]]
        faces += [[b(k), g(2 * k), g(2 * k + 1)], [b(k), g(2 * k + 1), g(2 * k + 2)]]
        faces += [[low(k), h(2 * k + 1), h(2 * k)], [low(k), h(2 * k + 2), h(2 * k + 1)], [h(2 * k), low(k - 1), tip, low(k)]]
    faces += [[g(k), h(k), h(k + 1), g(k + 1)] for k in range(16)]
    for f in faces:  # counter-clockwise from outside: the body is convex about (0, y, 0)
        p = [points[i - 1] for i in f]
        n = cross(sub(p[1], p[0]), sub(p[2], p[0]))
        if dot(n, sub(p[0], (0, 0.0, 0))) < 0:
            f.reverse()
    lines = ["# Round brilliant, made by make_models.py for glimt (same licence as the program)", "o gem"]
    lines += ["v " + text(p, 7) for p in points] + ["f " + " ".join(map(str, f)) for f in faces]
    (HERE / "gem.obj").write_text("\n".join(lines) + "\n")


def sphereflake(size_factor=4):
    """As balls.c of the SPD describes it: nine children of a third of the radius on every ball, three rows of three,
    turned from +z to the direction in which the parent grew. z is up."""
    def turned(v, axis, angle):
        c, s = cos(angle), sin(angle)
        return add(add(mul(v, c), mul(cross(axis, v), s)), mul(axis, dot(axis, v) * (1 - c)))

    d = 1 / sqrt(2)
    tilt = asin(2 / sqrt(6))
    trio = [turned(v, (d, -d, 0.0), tilt) for v in ((d, d, 0.0), (d, 0.0, -d), (0.0, d, -d))]
    nine = [turned(v, (0.0, 0.0, 1.0), k * 2 * pi / 3) for k in range(3) for v in trio]
    balls = []

    def grow(depth, centre, radius, direction):
        balls.append((*centre, radius))
        if depth == 0:
            return
        if direction[2] >= 1:
            children = nine
        elif direction[2] <= -1:
            children = [turned(v, (0.0, 1.0, 0.0), pi) for v in nine]
        else:
            axis = unit(cross((0.0, 0.0, 1.0), direction))
            children = [turned(v, axis, acos(direction[2])) for v in nine]
        for child in children:
            grow(depth - 1, add(centre, mul(child, radius * 4 / 3)), radius / 3, unit(child))

    grow(size_factor, (0.0, 0.0, 0.0), 0.5, (0.0, 0.0, 1.0))
    # The radii are 1/2 and its thirds: written with all their digits.
    (HERE / "sphereflake.txt").write_text(
        "".join(f"{text(b[:3], 8).replace(' ', ',')},{b[3]:.10g}\n" for b in balls)
    )
    assert len(balls) == 7381


knot()
gem()
sphereflake()
for path in sorted(HERE.glob("*.*")):
    print(f"{path}: {path.stat().st_size // 1000} kB")
