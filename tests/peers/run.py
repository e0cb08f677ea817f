#!/usr/bin/env python3
"""Whole frames by glimt and by POV-Ray 3.7: rendering seconds, their ratios, and how far the pictures differ.

    python3 tests/peers/run.py target/release/glimt [--work DIR] [--repeats 5] [--only demo] ...
"""

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import tempfile
import time
from collections import Counter
from pathlib import Path

import png
from generate import HERE, SCENES, generate

# Name and reflections and refractions along a path.
DEPTHS = {"demo": 5, "sphereflake": 5, "terrain": 8, "glass": 8, "mesh": 5}
# What glimt waited for its processor, of its wall time, when that is more than reading, writing and starting take. Its
# seconds are wall time, so they are too long then; POV-Ray counts processor time.
QUIET = 0.1


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("glimt", type=Path, help="a release binary")
    arguments.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "glimt-peers", help="for scenes and pictures")
    arguments.add_argument("--repeats", type=int, default=5)
    arguments.add_argument("--only", action="append", choices=DEPTHS, help="only this scene; may be given more than once")
    arguments.add_argument("--cpu", type=int, default=max(os.sched_getaffinity(0)), help="the processor that both run on")
    arguments.add_argument("--realtime", action="store_true", help="let nothing else on that processor meanwhile (as root)")
    arguments.add_argument("--error", type=float, metavar="CODES", help="instead: the time to this error against each program's own converged picture, POV-Ray's with its best antialiasing settings")
    arguments.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=(1280, 720), metavar="WxH")
    arguments.add_argument("--pov-option", action="append", default=[], metavar="OPTION", help="for POV-Ray, such as +BM2 or Declare=Bailout=0.0039")
    options = arguments.parse_args()
    options.glimt, options.work = options.glimt.resolve(), options.work.resolve()
    options.work.mkdir(parents=True, exist_ok=True)
    generate(options.work)
    # Both programs inherit these.
    os.sched_setaffinity(0, {options.cpu})
    if options.realtime:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))

    if options.error:
        for scene in options.only or DEPTHS:
            to_error(options, scene)
        return
    print("             rendering seconds         POV-Ray/glimt   difference, fast        difference, robust")
    print("scene        POV-Ray    fast  robust    fast  robust   median  RMSE     > 1    median  RMSE     > 1   waited")
    agree = True
    for scene in options.only or DEPTHS:
        times, waited = {"pov": [], "fast": [], "robust": []}, 0.0
        for _ in range(options.repeats):
            for who, seconds in times.items():
                if who == "pov":
                    seconds.append(pov(options, scene))
                    continue
                busy, share = glimt(options, scene, who)
                seconds.append(busy)
                waited = max(waited, share)
        seconds = {who: statistics.median(runs) for who, runs in times.items()}
        ratios = [seconds["pov"] / seconds[numerics] for numerics in ("fast", "robust")]
        reference = png.read(picture(options, scene, "pov"))
        differences = [difference(options, scene, reference, numerics) for numerics in ("fast", "robust")]
        print(
            "{:12} {:7.3f} {:7.3f} {:7.3f} {:7.2f} {:7.2f}".format(scene, *seconds.values(), *ratios)
            + "".join("   {:6d} {:5.2f} {:7.3%}".format(*d) for d in differences)
            + f"   {waited:6.0%}"
            + (" (not quiet)" if waited > QUIET else ""),
            flush=True,
        )
        agree = agree and all(median <= 1 for median, _, _ in differences)
    if not agree:
        raise SystemExit("the pictures do not agree: a median above 1")


def picture(options, scene, who):
    return options.work / f"{scene}-{who}.png"


def run(command, **more):
    """Standard output and errors, and the share of the wall time that the processor was not there."""
    start, before = time.monotonic(), os.times()
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", **more)
    wall, after = time.monotonic() - start, os.times()
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}\nfailed:\n{done.stdout[-2000:]}{done.stderr[-4000:]}")
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return done, max(0.0, 1 - used / wall)


def pov(options, scene, antialiasing=("-A",), name="pov"):
    """CPU-seconds of POV-Ray's own count, without parsing and bounding."""
    width, height = options.size
    command = ["povray", f"+I{HERE / scene}.pov", f"+O{picture(options, scene, name)}", f"+L{options.work}", f"+L{HERE}"]
    command += [f"+W{width}", f"+H{height}", "+WT1", *antialiasing, "-D", "-V", "+FN8", "File_Gamma=sRGB", "Dither=off"]
    command += [f"Declare=Depth={DEPTHS[scene]}", *options.pov_option]
    done, _ = run(command, cwd=options.work)
    found = re.search(r"Trace Time:.*?with\s+([0-9.]+) CPU-seconds total", done.stderr, re.S)
    if found is None:
        raise SystemExit(f"POV-Ray told no time:\n{done.stderr[-4000:]}")
    return float(found.group(1))


def glimt(options, scene, numerics):
    """Seconds that the one worker was busy, without loading and building."""
    here = SCENES if scene in ("demo", "sphereflake") else options.work
    command = [options.glimt, "render", here / f"{scene}.toml", "-o", picture(options, scene, numerics), "--json"]
    command += ["--size", "{}x{}".format(*options.size), "--threads", "1", "--samples", "1"]
    command += ["--max-depth", str(DEPTHS[scene]), "--numerics", numerics]
    done, waited = run(command)
    return sum(worker["busy_seconds"] for worker in json.loads(done.stdout)["workers"]), waited


# Converged: 144 rays a pixel in a grid; 256 samples of a sequence.
POV_REFERENCE = ("+A0.0", "+AM1", "+R12", "-J")
POV_SETTINGS = [
    (f"+A{threshold}", f"+AM{method}", f"+R{depth}", "-J")
    for method, depths in ((1, (2, 3, 4)), (2, (1, 2, 3)))
    for depth in depths
    for threshold in (0.3, 0.1, 0.03, 0.01)
]
ERRORS = (4, 3, 2.5, 2, 1.7, 1.4, 1)


def to_error(options, scene):
    """How long each takes to the error; CPU-seconds without reading the scene, glimt's with writing the picture."""
    pov(options, scene, POV_REFERENCE, "pov-reference")
    adaptive(options, scene, ["--samples", "256"], "reference")
    reading = min(adaptive(options, scene, ["--samples", "1"], "small", (8, 8)) for _ in range(3))
    rows = []
    for who, settings in (("POV-Ray", POV_SETTINGS), ("glimt", [("--error", str(error)) for error in ERRORS])):
        reference = png.read(picture(options, scene, "pov-reference" if who == "POV-Ray" else "reference"))
        for setting in settings:
            runs = []
            for _ in range(options.repeats):
                runs.append(pov(options, scene, setting, "to") if who == "POV-Ray" else adaptive(options, scene, setting, "to") - reading)
            _, rmse, _ = difference(options, scene, reference, "to")
            rows.append((who, min(runs), rmse, " ".join(setting)))
            print(f"{scene:12} {who:8} {min(runs):8.3f} s  RMSE {rmse:6.3f}  {' '.join(setting)}", flush=True)
    best = {who: min((row for row in rows if row[0] == who and row[2] <= options.error), default=None, key=lambda row: row[1]) for who in ("POV-Ray", "glimt")}
    if None in best.values():
        print(f"{scene}: not both come to {options.error}")
        return
    for who, (_, seconds, rmse, setting) in best.items():
        print(f"{scene:12} {who}: {seconds:.3f} s to an RMSE of {rmse:.3f} with {setting}")
    print(f"{scene:12} POV-Ray/glimt to an RMSE of {options.error:g}: {best['POV-Ray'][1] / best['glimt'][1]:.1f}", flush=True)


def adaptive(options, scene, setting, name, size=None):
    """CPU-seconds of glimt, all in all."""
    here = SCENES if scene in ("demo", "sphereflake") else options.work
    command = [options.glimt, "render", here / f"{scene}.toml", "-o", picture(options, scene, name), "--json", "--threads", "1"]
    command += ["--size", "{}x{}".format(*size or options.size), "--max-depth", str(DEPTHS[scene]), *setting]
    before = os.times()
    run(command)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def difference(options, scene, reference, numerics):
    """Of the differences of all 8-bit codes: median, root of the mean square, and the share of those above 1."""
    one, other = reference, png.read(picture(options, scene, numerics))
    assert one[:2] == other[:2] == options.size
    counts = Counter(abs(a - b) for a, b in zip(one[2], other[2]))
    total, seen = sum(counts.values()), 0
    rmse = math.sqrt(sum(d * d * n for d, n in counts.items()) / total)
    apart = sum(n for d, n in counts.items() if d > 1) / total
    for median in sorted(counts):
        seen += counts[median]
        if 2 * seen >= total:
            return median, rmse, apart


if __name__ == "__main__":
    main()
