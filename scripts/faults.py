#!/usr/bin/env python3
"""Breaks runs of lightbench on purpose and looks whether anything was lost: `python3 scripts/faults.py target/release/lightbench`.

Each test works in temporary folders and prints one row of a table. A run is *whole* if its rows (all columns but times and
memory) and the pixels of its images and references are those of a run that nothing disturbed. Exit code 1 if a test failed.
`faults.py BINARY kills full-disk` does only these.
"""

import csv
import itertools
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter

STILL = """
name = "still"
technique = "ambient-occlusion"
size = [64, 48]
caches = 150
repeats = 3
scene = [{ name = "cornell-curved" }]
method = [{ id = "IM" }, { id = "VGC" }, { id = "VGC+DGS" }]
gate = [{ text = "errors are numbers", expect = "rmse(IM) < 10" }]
"""
MOVING = """
name = "moving"
technique = "path-tracing"
size = [32, 24]
samples = 1
parameters = { reference_passes = 8 }
sequence = { path = "by", frames = "0..3", keep = "measured" }
scene = [{ name = "cornell-curved" }]
method = [{ id = "paths" }, { id = "running-mean" }]
path = [{ name = "by", keys = [{ time = 0, view = "main" }, { time = 0.4, view = "near", fov_deg = 50 }] }]
gate = [{ text = "errors are numbers", expect = "rmse(paths) < 10" }]
"""
BOTH = """
name = "both"
include = [{ config = "still.toml" }, { config = "moving.toml" }]
"""
# Parts of column names that differ from run to run.
MEASURED = ("seconds", "serial_share", "bytes_", "machine", "program")
NOBODY = 65534


class Bench:
    """The program, a folder with configs, and what an undisturbed run gives."""

    def __init__(self, binary, place):
        self.binary, self.place = binary, place
        for name, text in [("still", STILL), ("moving", MOVING), ("both", BOTH)]:
            (place / f"{name}.toml").write_text(text)
        start = time.monotonic()
        assert self.run(place / "calm/both")[0] == 0
        self.seconds = time.monotonic() - start
        self.calm = contents(place / "calm/both")
        self.bytes = sum(f.stat().st_size for f in (place / "calm").rglob("*"))

    def command(self, out, verb="run", config="both.toml", more=()):
        if verb != "run":
            return [self.binary, verb, out, *more]
        return [self.binary, "run", self.place / config, "--out", out, "--checkpoint", "0", *more]

    def start(self, out, prefix=(), **options):
        command = [*prefix, *self.command(out, **options)]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=self.place)

    def run(self, out, **options):
        process = self.start(out, **options)
        said = process.communicate(timeout=300)[1]
        return process.returncode, said

    def whole(self, out):
        try:
            return contents(out) == self.calm
        except (ValueError, IndexError):
            return False

    def folder(self):
        return pathlib.Path(tempfile.mkdtemp(dir=self.place))


def contents(out):
    """Rows without what is measured, and pixels, of a suite's folder."""
    found = {}
    for table in [*out.rglob("rows.csv"), *out.rglob("frames.csv")]:
        with table.open() as file:
            rows = [{k: v for k, v in row.items() if not any(m in k for m in MEASURED)} for row in csv.DictReader(file)]
        found[str(table.relative_to(out))] = rows
    for image in [*out.rglob("*.png"), *out.rglob("*.exr")]:
        found[str(image.relative_to(out))] = image.read_bytes() if image.suffix == ".png" else pixels(image.read_bytes())
    return found


def pixels(exr):
    """An EXR file of one part from its first chunk on: the header holds times."""
    if exr[:6] != b"v/1\x01\x02\0":
        return exr  # damaged, then
    at = 8
    while exr[at]:
        for _ in range(2):  # name and type of an attribute
            at = exr.index(0, at) + 1
        at += 4 + int.from_bytes(exr[at : at + 4], "little")
    return exr[int.from_bytes(exr[at + 1 : at + 9], "little") :]


def finished(out):
    """Each finished job with the file that holds its row."""
    return {row: row.stat().st_ino for row in out.rglob("jobs/[!.]*/row.json")}


def error_lines(said):
    return [line for line in said.splitlines() if "error" in line or "failed:" in line][:2]


def codes(seen):
    return ", ".join(f"{count} × {code}" for code, count in sorted(Counter(seen).items(), key=str))


def interrupted(bench, out, number, latest, begun=False):
    """Starts a run and sends it a signal at a random moment, once a folder is there if `begun`. Exit code and messages."""
    process = bench.start(out)
    if begun:
        while process.poll() is None and not list(out.rglob("jobs")):
            time.sleep(0.001)
    time.sleep(random.uniform(0, latest))
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    return process.returncode, said


def stopped(bench, signals, latest, right, begun=False):
    """A run that each of the signals stops at a random moment, then the same command again; `right` judges exit code and
    messages of the first. How many were right, and the exit codes of both; runs that ended by themselves do not count."""
    good, first, again = 0, [], []
    for number in signals:
        for _ in range(4):
            out = bench.folder() / "both"
            code, said = interrupted(bench, out, number, latest, begun)
            if code != 0:
                break
            shutil.rmtree(out.parent)
        kept = finished(out)
        first.append(code)
        again.append(bench.run(out)[0])
        whole = again[-1] == 0 and bench.whole(out) and kept.items() <= finished(out).items()
        good += whole and right(code, said)
        shutil.rmtree(out.parent)
    return good, first, again


def kills(bench):
    """killed (SIGKILL) at a random moment, then run again"""
    killed = lambda code, _: code == -signal.SIGKILL
    good, _, again = stopped(bench, [signal.SIGKILL] * 50, bench.seconds, killed)
    return good, 50, "again: " + codes(again)


def signals(bench):
    """SIGINT or SIGTERM at a random moment (exit code 130 and a message), then run again"""

    def right(code, said):
        return code == 130 and "finished jobs are kept" in said and "same command" in said

    both = [signal.SIGINT, signal.SIGTERM] * 5
    good, first, _ = stopped(bench, both, bench.seconds / 2, right, begun=True)
    return good, 10, codes(first)


def killed_often(bench):
    """killed five times in a row, then run to its end"""
    good, seen = 0, []
    for _ in range(16):
        out = bench.folder() / "both"
        for _ in range(5):
            interrupted(bench, out, signal.SIGKILL, bench.seconds / 3)
        code, _ = bench.run(out)
        seen.append(code)
        good += code == 0 and bench.whole(out)
        shutil.rmtree(out.parent)
    return good, 16, "at last: " + codes(seen)


def one_folder(bench):
    """two programs on one results folder: the second is refused, the first goes on"""
    good, seen = 0, []
    for _ in range(10):
        out = bench.folder() / "both"
        first = bench.start(out)
        while not list(out.rglob("plan.json")):
            time.sleep(0.001)
        code, said = bench.run(out)
        first.communicate()
        seen += [first.returncode, code]
        told = str(out) in said and "--out" in said
        good += first.returncode == 0 and code == 2 and told and bench.whole(out)
        shutil.rmtree(out.parent)
    return good, 10, codes(seen)


def one_store(bench):
    """two programs with folders of their own on one store of references"""
    good, seen = 0, []
    for _ in range(10):
        place = bench.folder()
        outs = [place / "a", place / "b"]
        both = [bench.start(out, config="moving.toml") for out in outs]
        for process in both:
            process.communicate()
        seen += [process.returncode for process in both]
        a, b = (contents(out) for out in outs)
        calm = {k.removeprefix("moving/"): v for k, v in bench.calm.items() if k.startswith("moving/")}
        left = [f for f in place.rglob("*") if f.suffix in (".tmp", ".lock")]
        good += all(process.returncode == 0 for process in both) and a == b == calm and not left
        shutil.rmtree(place)
    return good, 10, codes(seen)


def full_disk(bench):
    """a full disk (from nothing to almost enough), then space again"""
    good, seen, silent = 0, [], 0
    place = bench.folder()
    is_root = os.geteuid() == 0
    for number in range(42):
        room = bench.bytes * (number + 1) // 44
        if is_root and number == 0:
            mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "faults", place], stderr=subprocess.DEVNULL)
            is_root = mount.returncode == 0
        out = place / f"{number}/both"
        if is_root:
            subprocess.run(["mount", "-o", f"remount,size={room}", place], check=True)
            code, said = bench.run(out)
            subprocess.run(["mount", "-o", "remount,size=64m", place], check=True)
        else:
            # Without mounts: no file may be longer than so many bytes.
            limit = 200 * (number + 1)
            process = subprocess.Popen(
                bench.command(out), cwd=bench.place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                restore_signals=False, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
            )  # fmt: skip
            said = process.communicate()[1]
            code = process.returncode
        seen.append(code)
        told = code == 0 or str(out) in said or str(out.parent / "references") in said
        again, _ = bench.run(out)
        right = code in (0, 2, 4) and told and again == 0 and bench.whole(out)
        if not right:
            print(f"{room} bytes: exit codes {code}, {again}; {'; '.join(error_lines(said))}", file=sys.stderr)
        good += right
        shutil.rmtree(out.parent)
    if is_root:
        subprocess.run(["umount", place], check=True)
    return good, 42, codes(seen) + ("" if is_root else " (bounded files)")


def read_only(bench):
    """a folder that cannot be written: a new run, a finished one, one at work; `gate` reads it"""
    if os.geteuid() == 0:
        prefix = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
        if not shutil.which("setpriv"):
            return 0, 0, "skipped: needs setpriv"
    else:
        prefix = []
    place = bench.folder()
    place.chmod(0o755)
    bench.place.chmod(0o755)
    shutil.copytree(bench.place / "calm", place / "done")
    shutil.copytree(bench.place / "calm", place / "half")
    for job in list((place / "half/both/still/jobs").iterdir())[:4]:
        shutil.rmtree(job)
    before = {name: contents(place / name) for name in ("done", "half")}
    everything = [place, *place.rglob("*")]
    for path in everything:
        path.chmod(0o555 if path.is_dir() else 0o444)
    seen, good = [], 0
    for out in [place / "new/both", place / "done/both", place / "half/both"]:
        code, said = bench.run(out, prefix=prefix)
        good += code == 2 and str(out) in said
        seen.append(code)
    code, _ = bench.run(place / "done/both/still", prefix=prefix, verb="gate")
    seen.append(code)
    good += code == 0 and before == {name: contents(place / name) for name in ("done", "half")}
    for path in everything:
        path.chmod(0o755 if path.is_dir() else 0o644)
    code, _ = bench.run(place / "half/both")
    good += code == 0 and bench.whole(place / "half/both")
    return good, 5, codes(seen) + f", then writable: {code}"


def older_store(bench):
    """folder and references of a version with other keys: rendered anew, nothing removed"""
    place = bench.folder()
    out = place / "both"
    shutil.copytree(bench.place / "calm/both", out)
    olds = []
    for path in [*out.rglob("jobs/*/row.json"), *out.rglob("references/*.exr")]:
        path = path if path.suffix == ".exr" else path.parent
        old = path.with_name(path.name[::-1] if path.is_dir() else path.stem[::-1] + ".exr")
        path.rename(old)
        olds += [old] if old.is_file() else [file for file in old.rglob("*") if file.is_file()]
    before = {old: old.read_bytes() for old in olds}
    code, _ = bench.run(out)
    kept = all(old.is_file() and old.read_bytes() == data for old, data in before.items())
    for old in olds:
        old.unlink()
    good = code == 0 and kept and bench.whole(out)
    return int(good), 1, codes([code])


def flipped(data):
    middle = len(data) // 2
    return data[:middle] + bytes([data[middle] ^ 85]) + data[middle + 1 :]


def cut(share):
    return lambda data: data[: int(len(data) * share)]


DAMAGES = [cut(0), cut(0.01), cut(0.3), cut(0.9), lambda data: bytes(len(data)), flipped]


def damaged(bench, patterns, right):
    """A suite with files that are damaged in each of the ways, run again; `right` judges the files and messages."""
    good, seen = 0, []
    for pattern, damage in itertools.product(patterns, DAMAGES):
        out = bench.folder() / "both"
        shutil.copytree(bench.place / "calm", out.parent, dirs_exist_ok=True)
        paths = list(out.glob(pattern))
        for path in paths:
            path.write_bytes(damage(path.read_bytes()))
        if pattern.startswith("references"):
            for job in out.rglob("jobs/[!.]*"):  # finished jobs need no reference
                shutil.rmtree(job)
        code, said = bench.run(out)
        fine = paths and code == 0 and bench.whole(out) and right(paths, said)
        if not fine:
            print(f"{pattern}: exit code {code}; {'; '.join(error_lines(said))}", file=sys.stderr)
        seen.append(code)
        good += bool(fine)
        shutil.rmtree(out.parent)
    return good, len(seen), codes(seen)


def damaged_files(bench):
    """damaged rows and plans (cut, emptied, zeros, a flipped byte): made anew"""
    return damaged(bench, ["still/jobs/*/row.json", "still/plan.json"], lambda *_: True)


def damaged_references(bench):
    """damaged references (the same): told with their paths, set aside and made anew"""

    def right(paths, said):
        return all(str(path) in said and path.with_name(path.name + ".damaged").is_file() for path in paths)

    return damaged(bench, ["references/*.exr"], right)


def flipped_bits(bench):
    """one bit of a reference flipped: `ref status` refuses the file, or nothing that it says has changed"""
    place, good, seen = bench.folder() / "references", 0, []
    place.mkdir()
    sources = sorted((bench.place / "calm/both/references").glob("*.exr"))[:3]

    def status(reference):
        command = [bench.binary, "ref", "status", place]
        told = subprocess.run(command, capture_output=True, text=True)
        same = [bench.binary, "compare", reference, place / reference.name, "--json"]
        same = subprocess.run(same, capture_output=True, text=True) if told.returncode == 0 else None
        return told.returncode, told.stdout, same and json.loads(same.stdout)["rmse"]

    for source in sources:
        data = source.read_bytes()
        (place / source.name).write_bytes(data)
        sound = status(source)
        for _ in range(120):
            bit = random.randrange(8 * len(data))
            damaged_data = bytearray(data)
            damaged_data[bit // 8] ^= 1 << bit % 8
            (place / source.name).write_bytes(damaged_data)
            code, said, rmse = status(source)
            seen.append(code)
            good += (code == 2 and "damaged" in said) or (code, said, rmse) == sound
        (place / source.name).unlink()
    return good, len(seen), codes(seen)


def damaged_reports(bench):
    """a damaged reference of finished jobs: `report` names it, `ref extend` renders it again"""
    out = bench.folder() / "both"
    shutil.copytree(bench.place / "calm", out.parent, dirs_exist_ok=True)
    paths = list(out.glob("references/*.exr"))
    for path in paths:
        path.write_bytes(flipped(path.read_bytes()))
    seen, good = [], 0
    for verb, more in [("report", ()), ("ref", ("extend",)), ("report", ())]:
        told, code = "", 0
        for experiment in ["still", "moving"]:
            command = [bench.binary, verb, *more, out / experiment]
            process = subprocess.run(command, capture_output=True, text=True, cwd=bench.place)
            told, code = told + process.stdout + process.stderr, max(code, process.returncode)
        seen.append(code)
        named = any(path.name in told for path in paths)
        good += code == 0 and named == (len(seen) < 3)
    return good, 3, codes(seen)


TESTS = {
    "kills": kills,
    "signals": signals,
    "killed-often": killed_often,
    "one-folder": one_folder,
    "one-store": one_store,
    "full-disk": full_disk,
    "read-only": read_only,
    "older-store": older_store,
    "damaged-files": damaged_files,
    "damaged-references": damaged_references,
    "flipped-bits": flipped_bits,
    "damaged-reports": damaged_reports,
}


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    chosen = sys.argv[2:] or TESTS
    failed = False
    with tempfile.TemporaryDirectory(prefix="faults-") as place:
        bench = Bench(binary, pathlib.Path(place))
        print("| test | right | exit codes |\n|---|---|---|")
        for name in chosen:
            random.seed(21)
            good, wanted, seen = TESTS[name](bench)
            failed |= good < wanted
            print(f"| {TESTS[name].__doc__} | {good} of {wanted} | {seen} |", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
