#!/usr/bin/env python3
"""Times `plan`, `merge` and `report` at many rows: `python3 scripts/many-rows.py target/release/lightbench [ROWS]`.

One job of a large plan is run; all others get copies of its row with numbers of their own, dealt to four shards. Nothing
else is rendered. Prints a row of a table for each verb: seconds, seconds of processor time, and the most memory that was
held. It needs Linux and, for 10⁵ rows, 2 GB in the folder for temporary files.
"""

import json
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time

SCENES = ["arcade-court", "atrium", "cabinet-room", "cornell-curved", "robots", "stairs", "statues", "still-glossy", "still-twigs", "table"]
METHODS = ["IM", "SD", "SD+AS", "VGC", "VGC+AS", "VGC+DGS", "VGC+EGR"]
CONFIG = """
name = "many"
technique = "ambient-occlusion"
size = [32, 18]
scene = [{scenes}]
method = [{methods}]
repeats = {repeats}
sweep = {{ caches = [20, 40, 60, 80, 100] }}
table = [{{ name = "errors", metrics = ["rmse", "flip_ldr", "seconds_total"] }}, {{ name = "swept", kind = "sweep" }}, {{ name = "stages", kind = "stages" }}, {{ name = "change", kind = "change" }}]
figure = [{{ name = "curves", kind = "curves", x = "caches", y = ["rmse"] }}, {{ name = "side", kind = "side-by-side" }}]
claim = [{{ text = "clustering helps", where = "here", expect = "rmse(VGC+DGS) < rmse(IM)" }}]
gate = [{{ text = "bounded", expect = "rmse(VGC+DGS) < 1" }}]
"""
SHARDS = 4


def timed(binary, *arguments, **options):
    """Output of a command, its seconds and its most memory in MiB."""
    before = time.monotonic()
    process = subprocess.Popen([binary, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    out, err = process.communicate()
    seconds = time.monotonic() - before
    if process.returncode:
        sys.exit(f"{arguments[0]} ended with {process.returncode}: {err}")
    return out, seconds


def measured(binary, *arguments, **options):
    """As `timed`, with processor time, in a process of its own, so that the most memory of its children is that of the command."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        out, seconds = timed(binary, *arguments, **options)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        told = [seconds, used.ru_utime, used.ru_stime, used.ru_maxrss / 1024]
        os.write(write, json.dumps(told).encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as file:
        told = file.read()
    os.waitpid(child, 0)
    if not told:
        sys.exit(f"{arguments[0]} failed")
    seconds, user, system, peak = json.loads(told)
    print(f"| `{arguments[0]}` | {seconds:.1f} | {user:.1f} + {system:.1f} | {peak:.0f} |", flush=True)


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    rows = int(sys.argv[2]) if len(sys.argv) > 2 else 100_000
    repeats = max(1, round(rows / (len(SCENES) * len(METHODS) * 5)))
    with tempfile.TemporaryDirectory(prefix="many-rows-") as place:
        place = pathlib.Path(place)
        scenes = ", ".join(f'{{ name = "{name}" }}' for name in SCENES)
        methods = ", ".join(f'{{ id = "{name}" }}' for name in METHODS)
        (place / "many.toml").write_text(CONFIG.format(scenes=scenes, methods=methods, repeats=repeats))
        plan = json.loads(timed(binary, "plan", "many.toml", "--json", cwd=place)[0])
        jobs = plan["jobs"]
        print(f"{len(jobs)} rows\n\n| verb | seconds | processor, program + system | MiB at most |\n|---|---|---|---|", flush=True)
        measured(binary, "plan", "many.toml", "--json", cwd=place)
        timed(binary, "run", "many.toml", "--shard", f"1/{len(jobs)}", "--out", "one/many", cwd=place)
        [template] = [p for p in (place / "one/many/jobs").iterdir() if not p.name.startswith(".")]
        row = json.loads((template / "row.json").read_text())
        shards = []
        random.seed(1)
        for number in range(SHARDS):
            shard = place / f"shards/{number}"
            (shard / "jobs").mkdir(parents=True)
            own = jobs[number::SHARDS]
            (shard / "plan.json").write_text(json.dumps({**plan, "jobs": own}))
            (shard / "config.json").write_text((place / "one/many/config.json").read_text())
            for job in own:
                folder = shard / "jobs" / job["id"]
                folder.mkdir(exist_ok=True)
                error = random.uniform(0.05, 0.1) / job["budget"]["caches"] ** 0.5
                own_row = {**row, "job": job["id"], "rmse": error, "flip_ldr": error, "seed": job["seed"], "scene": job["scene"], "label": job["label"], "method": job["method"]}
                (folder / "row.json").write_text(json.dumps(own_row))
                for name in ["image.exr", "preview.png"]:
                    if not (folder / name).exists():
                        shutil.copyfile(template / name, folder / name)
            shards.append(str(shard))
        measured(binary, "merge", *shards, "--out", "merged/many", cwd=place)
        measured(binary, "report", "merged/many", cwd=place)
        measured(binary, "gate", "merged/many", cwd=place)


if __name__ == "__main__":
    main()
