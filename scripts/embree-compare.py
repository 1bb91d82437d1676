#!/usr/bin/env python3
"""Compares lightbench's ray kernels with Embree on the rays of `cargo bench --bench rays`.

    pip install embreex            (any package that brings libembree4 will do, or libembree-dev)
    scripts/embree-compare.py [--rounds 2] [--avx2] [--library PATH] [terrain] [kitchen]

Runs the bench with --export, then scripts/embree-rays.c, which casts the same rays one by one
(rtcIntersect1, rtcOccluded1) against the same triangles, and does so in turns `--rounds` times; the
best of each counts. With --avx2 our kernels have eight lanes even where the processor has AVX-512. Prints a Markdown table: Mrays per CPU-second of one thread, ratios to Embree, and by how
many hits the two differ. The library is that of --library, of the Python package embreex, or the
system's; without one, or without a C compiler, it says so and exits with code 3.
"""

import argparse
import ctypes.util
import glob
import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HERE = Path(__file__).resolve().parent


def find_library(given):
    """Path or name of Embree 4's library, or None."""
    if given:
        return given
    package = importlib.util.find_spec("embreex")
    if package and package.origin:
        beside = Path(package.origin).parent.parent / "embreex.libs"
        found = sorted(glob.glob(str(beside / "libembree4*.so*")))
        if found:
            return found[0]
    return ctypes.util.find_library("embree4")


def compile_caster(library, directory):
    """Compiles embree-rays.c against the library; returns the program or None."""
    program = Path(directory) / "embree-rays"
    command = [os.environ.get("CC", "cc"), "-O2", "-std=c99", str(HERE / "embree-rays.c"), "-o", str(program)]
    if os.sep in library:
        folder = str(Path(library).parent)
        command += [library, f"-Wl,-rpath,{folder}", "-Wl,--allow-shlib-undefined"]
    else:
        command += [f"-l:{library}"]
    try:
        subprocess.run(command, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"embree-rays.c cannot be compiled: {error}", file=sys.stderr)
        return None
    return program


def run_bench(directory, scenes, options):
    """One round of our kernels: {scene: {set: row of sets.tsv}}."""
    for scene in scenes:
        command = ["cargo", "bench", "--quiet", "--bench", "rays", "--", scene, "--quick", "--export", directory]
        command += options
        subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    rows = {}
    for scene in scenes:
        table = Path(directory) / scene / "sets.tsv"
        if table.exists():
            lines = [line.split("\t") for line in table.read_text().splitlines()]
            rows[scene] = {line[0]: line for line in lines}
    return rows


def run_embree(program, directory, scene):
    """One round of Embree: {set: (hits, Mrays per CPU-second)}."""
    output = subprocess.run([str(program), str(Path(directory) / scene)], check=True, capture_output=True, text=True)
    lines = [line.split("\t") for line in output.stdout.splitlines()]
    return {line[0]: (int(line[1]), float(line[2])) for line in lines if line[0] != "build"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["terrain", "kitchen"])
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--avx2", action="store_true")
    parser.add_argument("--library")
    arguments = parser.parse_args()
    library = find_library(arguments.library)
    if library is None:
        print("Embree 4 is absent: neither the Python package embreex nor a system library was found", file=sys.stderr)
        return 3
    with tempfile.TemporaryDirectory() as directory:
        program = compile_caster(library, directory)
        if program is None:
            return 3
        options = ["--avx2"] if arguments.avx2 else []
        best = {}
        for _ in range(arguments.rounds):
            for scene, rows in run_bench(directory, arguments.scenes, options).items():
                embree = run_embree(program, directory, scene)
                for index, row in rows.items():
                    rates = [float(rate) for rate in row[4:7]] + [embree[index][1]]
                    old = best.get((scene, index), (rates,))[0]
                    # A rate that does not apply is NaN, and stays so.
                    rates = [max(a, b) for a, b in zip(rates, old)]
                    best[scene, index] = (rates, row[7], int(row[2]), embree[index][0] - int(row[3]))
    for scene in arguments.scenes:
        lines = [row for (name, _), row in best.items() if name == scene]
        if not lines:
            print(f"{scene}: skipped, not found through LIGHTBENCH_SCENES\n")
            continue
        print(f"{scene}\n\n| Mrays per CPU-second (× Embree) | Embree | single | bundle | hits that differ |")
        print("|---|--:|--:|--:|--:|")
        for (_, single, bundle, embree), name, rays, difference in lines:
            ratio = [f"{rate:.2f} ({rate / embree:.2f} ×)" if rate == rate else "–" for rate in (single, bundle)]
            print(f"| {name} | {embree:.2f} | {ratio[0]} | {ratio[1]} | {difference} of {rays} |")
        print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
