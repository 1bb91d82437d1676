#!/usr/bin/env python3
"""How well `run` foresees its end: `python3 scripts/remaining-time.py target/release/lightbench CONFIG [key=value …]`.

Runs a config in an empty folder and compares every "(about … left)" that it prints with what the run then still took, the
report included. Prints a line for each, and the worst of those after the first tenth. What is off by less than two seconds
counts as right. With processes beside it a run is slower or faster later on, which nothing can foresee.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import time

LEFT = re.compile(r"\(about ([0-9.]+) (s|min|h) left\)")
SECONDS = {"s": 1, "min": 60, "h": 3600}
TOLERATED = 2.0


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory(prefix="remaining-time-") as place:
        arguments = [binary, "run", *sys.argv[2:], "--out", f"{place}/run/measured"]
        start = time.monotonic()
        process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        told = []
        last_job = 0.0
        for line in process.stderr:
            now = time.monotonic() - start
            if line.startswith("["):
                last_job = now
            if found := LEFT.search(line):
                told.append((now, float(found[1]) * SECONDS[found[2]], line.strip()))
        code = process.wait()
        whole = time.monotonic() - start
    if code:
        sys.exit(f"the run ended with {code}")
    worst = (1.0, 0.0, 0.0, "nothing")
    for at, left, line in told:
        true = whole - at
        ratio = max(left / max(true, 1e-3), true / max(left, 1e-3))
        if abs(left - true) <= TOLERATED:
            ratio = 1.0
        print(f"{at:7.1f} s  told {left:7.1f}  took {true:7.1f}  {ratio:5.2f}  {line[:90]}")
        if at >= 0.1 * whole and ratio > worst[0]:
            worst = (ratio, left, true, line)
    print(f"{whole:.1f} s in all, {whole - last_job:.1f} s of them after the last job; {len(told)} lines")
    print(f"worst after the first tenth: a factor of {worst[0]:.2f} ({worst[1]:.0f} s for {worst[2]:.0f} s): {worst[3][:90]}")


if __name__ == "__main__":
    main()
