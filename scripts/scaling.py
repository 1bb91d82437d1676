#!/usr/bin/env python3
"""How the stages of experiments scale with threads: `python3 scripts/scaling.py target/release/lightbench 1,2,4 CONFIG [key=value …] …`.

Runs each config with each number of threads in an empty folder, references shared, and compares its rows. Prints what each stage
took on the first number of threads (jobs of a technique together), its efficiency on the others (wall seconds of the first,
times its threads, over the same of the others), and its serial share on the last. Stages below a tenth of a second are left out.
Ends with 1 where a metric differs in a single bit.
"""

import csv
import pathlib
import subprocess
import sys
import tempfile
import time

METRICS = ["rays", "rmse", "relmse", "psnr", "ssim", "flip_ldr", "flicker", "non_finite"]
LEAST_SECONDS = 0.1


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    threads = [int(number) for number in sys.argv[2].split(",")]
    runs = []
    for argument in sys.argv[3:]:
        if "=" in argument or argument.startswith("-"):
            runs[-1].append(argument)
        else:
            runs.append([argument])
    differing = 0
    for arguments in runs:
        with tempfile.TemporaryDirectory(prefix="scaling-") as place:
            # The most threads first: they render the references.
            rows = [measure(binary, place, arguments, number) for number in reversed(threads)][::-1]
        differing += compare(rows, threads)
        report(" ".join(arguments), rows, threads)
    sys.exit(1 if differing else 0)


def measure(binary, place, arguments, threads):
    """The rows of a run; references lie beside its folder, for those that follow."""
    name = f"{place}/run/{threads}"
    command = [binary, "run", *arguments, "--out", name, "--threads", str(threads), "--quiet"]
    start = time.monotonic()
    # 10: a claim does not hold.
    if subprocess.run(command, stdout=subprocess.DEVNULL).returncode not in (0, 10):
        sys.exit(f"failed: {' '.join(command)}")
    print(f"{threads} threads: {time.monotonic() - start:.1f} s", file=sys.stderr)
    with open(f"{name}/rows.csv", newline="") as file:
        return list(csv.DictReader(file))


def compare(rows, threads):
    """How many metrics differ from those of the first number of threads."""
    differing = 0
    for number, others in zip(threads[1:], rows[1:]):
        for row, other in zip(rows[0], others, strict=True):
            for metric in METRICS:
                if row.get(metric) != other.get(metric):
                    differing += 1
                    print(f"{row['job']}: {metric} {row[metric]}, on {number} threads {other[metric]}")
    return differing


def total(rows, column):
    return sum(float(row.get(column) or 0.0) for row in rows)


def report(title, rows, threads):
    print(f"### `run {title}`\n")
    others = " | ".join(f"× {number}" for number in threads[1:])
    print(f"| stage | wall s | CPU s | {others} | serial share |")
    print("|---|" + "---|" * (len(threads) + 2))
    for column in rows[0][0]:
        if not column.startswith("seconds_"):
            continue
        wall = [total(of, column) for of in rows]
        if wall[0] < LEAST_SECONDS:
            continue
        # Where the share is not told, as of the total, there is nothing to show.
        last, cpu = rows[-1], f"cpu_{column}"
        alone = sum(
            float(row.get(f"serial_share_{column[8:]}") or 0.0) * float(row.get(cpu) or 0.0) for row in last
        )
        share = f"{alone / total(last, cpu):.1%}" if f"serial_share_{column[8:]}" in last[0] else ""
        cells = [f"{wall[0] * threads[0] / (seconds * number):.2f}" for number, seconds in zip(threads[1:], wall[1:])]
        name = column[8:].replace("_", " ")
        print(f"| {name} | {wall[0]:.2f} | {total(rows[0], cpu):.2f} | {' | '.join(cells)} | {share} |")
    print()


main()
