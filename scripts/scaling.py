#!/usr/bin/env python3
"""How stages scale with threads: `python3 scripts/scaling.py target/release/lightbench 1,2,4 CONFIG [argument …] [+ CONFIG …]`.

Runs each config with each number of threads in an empty folder, references shared, and compares the rows. Prints what each stage
took on the first number of threads (all jobs together), its efficiency on the others (wall seconds of the first, times its
threads, over the same of the others), how many times the processor seconds it takes on the last, and its serial share there. *Copies* is
the efficiency of as many copies of the program at once as the last number of threads, each on the first number: what the machine
itself allows. Stages below a tenth of a second are left out. Ends with 1 where a metric differs in a single bit.
"""

import csv
import pathlib
import subprocess
import sys
import tempfile

METRICS = ["rays", "rmse", "relmse", "psnr", "ssim", "flip_ldr", "flicker", "non_finite"]
LEAST_SECONDS = 0.1


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    threads = [int(number) for number in sys.argv[2].split(",")]
    differing = 0
    for arguments in runs(sys.argv[3:]):
        with tempfile.TemporaryDirectory(prefix="scaling-") as place:
            # The most threads first: they render the references.
            rows = [measure(binary, place, arguments, number)[0] for number in reversed(threads)][::-1]
            copies = measure(binary, place, arguments, threads[0], threads[-1] // threads[0])
        differing += compare(rows, threads)
        report(" ".join(arguments), rows, threads, copies)
    sys.exit(1 if differing else 0)


def runs(arguments):
    """The arguments of each run: `+` is between them."""
    found = [[]]
    for argument in arguments:
        if argument == "+":
            found.append([])
        else:
            found[-1].append(argument)
    return found


def measure(binary, place, arguments, threads, copies=1):
    """The rows of each of some runs at once; their references lie beside their folders, for those that follow."""
    names = [f"{place}/run/{copies}x{threads}-{copy}" for copy in range(copies)]
    command = [binary, "run", *arguments, "--threads", str(threads), "--quiet", "--out"]
    started = [subprocess.Popen([*command, name], stdout=subprocess.DEVNULL) for name in names]
    # 10: a claim does not hold.
    if any(process.wait() not in (0, 10) for process in started):
        sys.exit(f"failed: {' '.join(command)}")
    rows = []
    for name in names:
        with open(f"{name}/rows.csv", newline="") as file:
            rows.append(list(csv.DictReader(file)))
    return rows


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


def report(title, rows, threads, copies):
    print(f"### `run {title}`\n")
    others = " | ".join(f"× {number}" for number in threads[1:])
    print(f"| stage | wall s | CPU s | {others} | copies | CPU, × {threads[-1]} | serial share |")
    print("|---|" + "---|" * (len(threads) + 4))
    first, last = rows[0], rows[-1]
    for column in first[0]:
        if not column.startswith("seconds_"):
            continue
        wall = [total(of, column) for of in rows]
        if wall[0] < LEAST_SECONDS:
            continue
        stage = column.removeprefix("seconds_")
        cpu, share = f"cpu_{column}", f"serial_share_{stage}"
        alone = sum(float(row.get(share) or 0.0) * float(row.get(cpu) or 0.0) for row in last)
        # The share of the total is not told.
        share = f"{alone / total(last, cpu):.1%}" if share in last[0] else ""
        cells = [f"{wall[0] * threads[0] / (seconds * number):.2f}" for number, seconds in zip(threads[1:], wall[1:])]
        at_once = wall[0] * len(copies) / sum(total(copy, column) for copy in copies)
        more = total(last, cpu) / total(first, cpu)
        print(
            f"| {stage.replace('_', ' ')} | {wall[0]:.2f} | {total(first, cpu):.2f} | {' | '.join(cells)} | {at_once:.2f} "
            f"| {more:.2f} | {share} |"
        )
    print(flush=True)


main()
