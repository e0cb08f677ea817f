"""Makes the large parts of the five scenes in a directory: the same numbers for glimt and for POV-Ray."""

import math
import random
import shutil
from pathlib import Path

import png

HERE = Path(__file__).resolve().parent
SCENES = HERE.parent.parent / "scenes"


def generate(work):
    """Writes all files that the scenes of `work` need, unless they are there already."""
    stamp, version = work / "generated-by.py", Path(__file__).read_bytes()
    for scene in ["terrain", "mesh"]:
        shutil.copy(HERE / f"{scene}.toml", work)
    if not stamp.exists() or stamp.read_bytes() != version:
        textures(work)
        flake = [list(map(float, line.split(","))) for line in (SCENES / "models/sphereflake.txt").open()]
        balls(work, "sphereflake", flake)
        terrain(work)
        ring(work)
        stamp.write_bytes(version)
    glass(work)


def balls(work, name, data):
    rows = [",".join(f"{number:.10g}" for number in row) for row in data]
    (work / f"{name}.txt").write_text("\n".join(rows) + "\n")
    (work / f"{name}.inc").write_text("".join(f"Ball({row})\n" for row in rows))


def mesh(work, name, points, normals, faces):
    """As OBJ and as the body of a mesh2."""
    points = ["%.7g %.7g %.7g" % p for p in points]
    normals = ["%.5f %.5f %.5f" % n for n in normals]
    with (work / f"{name}.obj").open("w") as obj:
        obj.writelines(f"v {p}\n" for p in points)
        obj.writelines(f"vn {n}\n" for n in normals)
        obj.writelines("f %d//%d %d//%d %d//%d\n" % (a + 1, a + 1, b + 1, b + 1, c + 1, c + 1) for a, b, c in faces)
    with (work / f"{name}-mesh.inc").open("w") as inc:
        for what, rows in [("vertex_vectors", points), ("normal_vectors", normals)]:
            inc.write(f"{what} {{ {len(rows)},\n")
            inc.write(",\n".join("<" + row.replace(" ", ",") + ">" for row in rows))
            inc.write("\n}\n")
        inc.write(f"face_indices {{ {len(faces)},\n" + ",\n".join("<%d,%d,%d>" % f for f in faces) + "\n}\n")


def unit(v):
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return v[0] / length, v[1] / length, v[2] / length


def terrain(work):
    """A square of 256 x 256 cells, 110 units wide, and 14 balls that float above it."""
    cells, width = 256, 110.0
    waves = [(0.06, 0.045, 0.3, 3.2), (-0.11, 0.09, 1.7, 1.8), (0.23, -0.17, 4.1, 0.9), (0.41, 0.52, 2.2, 0.4), (-0.9, 1.1, 0.6, 0.13)]

    def height(x, z):
        return sum(a * math.sin(p * x + q * z + phase) for p, q, phase, a in waves)

    points, normals = [], []
    for j in range(cells + 1):
        for i in range(cells + 1):
            x, z = (i / cells - 0.5) * width, (j / cells - 0.5) * width
            slope = [0.0, 0.0]
            for p, q, phase, a in waves:
                c = a * math.cos(p * x + q * z + phase)
                slope[0] += p * c
                slope[1] += q * c
            points.append((x, height(x, z), z))
            normals.append(unit((-slope[0], 1.0, -slope[1])))
    faces = []
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i
            b, c, d = a + 1, a + cells + 1, a + cells + 2
            faces += [(a, c, d), (a, d, b)]
    mesh(work, "terrain", points, normals, faces)
    rng = random.Random(1)
    data = []
    while len(data) < 14:
        r, x, z = rng.uniform(2.5, 5), rng.uniform(-30, 30), rng.uniform(-30, 35)
        if all(math.hypot(x - b[0], z - b[2]) > r + b[3] + 0.5 for b in data):
            data.append((x, height(x, z) + r + 3, z, r))
    balls(work, "terrain-balls", data)


def ring(work):
    """A ring with ripples that lie around it like the strands of a rope, tilted: 1000 x 500 cells."""
    around, along = 500, 1000
    major, minor, ripple, strands, turns = 28.0, 9.0, 0.6, 12, 8
    tilt = (math.cos(math.radians(12)), math.sin(math.radians(12)))

    def turned(v):
        x, y, z = v
        return x, tilt[0] * y - tilt[1] * z, tilt[1] * y + tilt[0] * z

    points, normals = [], []
    for i in range(along):
        u = 2 * math.pi * i / along
        cu, su = math.cos(u), math.sin(u)
        for j in range(around):
            v = 2 * math.pi * j / around
            cv, sv = math.cos(v), math.sin(v)
            phase = strands * v + turns * u
            r = minor + ripple * math.sin(phase)
            rv, ru = ripple * strands * math.cos(phase), ripple * turns * math.cos(phase)
            out = major + r * cv
            points.append(turned((out * cu, r * sv, out * su)))
            # The cross product of the two derivatives.
            pu = (ru * cv * cu - out * su, ru * sv, ru * cv * su + out * cu)
            k = rv * cv - r * sv
            pv = (k * cu, rv * sv + r * cv, k * su)
            n = (pv[1] * pu[2] - pv[2] * pu[1], pv[2] * pu[0] - pv[0] * pu[2], pv[0] * pu[1] - pv[1] * pu[0])
            normals.append(turned(unit(n)))
    faces = []
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = (i + 1) % along * around + j, (i + 1) % along * around + (j + 1) % around
            faces += [(a, b, d), (a, d, c)]
    mesh(work, "mesh", points, normals, faces)


def glass(work):
    """24 x 16 places 9 units apart, balls and boxes in turn, a little above the floor."""
    rng = random.Random(2)
    round_ones, toml, inc = [], [], []
    for j in range(16):
        for i in range(24):
            x, z, lift = (i - 11.5) * 9, (j - 9.5) * 9, rng.uniform(0.3, 2)
            if (i + j) % 2 == 0:
                r = rng.uniform(2.5, 4)
                round_ones.append((x, lift + r, z, r))
            else:
                size, turn = [rng.uniform(3, 5.5) for _ in range(3)], rng.uniform(0, 90)
                place = (x, lift + size[1] / 2, z)
                numbers = ["%.9g, %.9g, %.9g" % tuple(size), "%.9g" % turn, "%.9g, %.9g, %.9g" % place]
                toml.append(
                    '\n[[object]]\nshape = "cuboid"\nmaterial = "glass"\n'
                    "size = [{}]\nrotate = [0, {}, 0]\ntranslate = [{}]\n".format(*numbers)
                )
                inc.append("Cuboid(<{}>, {}, <{}>)\n".format(*numbers))
    balls(work, "glass-balls", round_ones)
    (work / "glass.toml").write_text((HERE / "glass.toml").read_text() + "".join(toml))
    (work / "glass-boxes.inc").write_text("".join(inc))


def textures(work):
    """The demo's pictures; the stone three times side by side, since POV-Ray repeats a picture around a cone only once."""
    shutil.copy(SCENES / "textures/fence.png", work)
    width, height, rgb = png.read(SCENES / "textures/stone.png")
    rows = [rgb[3 * width * y : 3 * width * (y + 1)] * 3 for y in range(height)]
    png.write(work / "stone3.png", 3 * width, height, b"".join(rows))
