#!/usr/bin/env python3
"""Writes what a run found into results/published: a title, its command, the verdicts on claims, and its tables.

    lightbench run CONFIG … > RUN.log
    scripts/publish.py RESULTS RUN.log NAME "Title" "the command, as it was given" [--together]
        [--frames 1-6 "a lamp swings"] … [--errors flip_ldr,ssim]

RESULTS is the folder of the run, of a suite with a folder for each of its members, and RUN.log what it printed. NAME.md
is written; add it to the list of docs/results.md, which a test compares with the folder. With `--together`, for runs of
many scenes, tables keep the columns over all scenes, and those without any are left out. With `--frames`, for a sequence
of one method, a table of the means over these frames is added: rays, and processor seconds by stage. With `--errors` too it is
of any number of methods, and of these errors of the measured frames among them, in the mean of seeds, scenes and viewers.
"""

import argparse
import csv
import re
import statistics
from pathlib import Path


def claims(printed: str) -> list[str]:
    """The verdicts as nested lists, as Markdown lines."""
    _, found, text = printed.partition("\nClaims\n")
    lines = []
    part = re.compile(r"^  (holds|does not hold|inconclusive|no data)\s+(.*)$")
    for line in text.splitlines() if found else []:
        verdict = part.match(line)
        if verdict:
            lines.append(f"- **{verdict[1]}**: {verdict[2]}")
        elif line.startswith("    ") and line.strip():
            lines.append(f"  - {line.strip()}")
        else:
            break
    return lines


def cells(line: str) -> list[str]:
    """The cells of a line of a Markdown table."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def together(table: list[str]) -> list[str]:
    """The names and the columns over all scenes of a table's lines; nothing of a table without such columns."""
    kept = [i for i, name in enumerate(cells(table[0])) if name.startswith(("Mean of all scenes", "Mean rank"))]
    if not kept:
        return []
    names, rule, *rows = ([cells(line)[i] for i in [0, *kept]] for line in table)
    written = ["| " + " | ".join(row) + " |" for row in [names, *rows]]
    written.insert(1, "|" + "|".join(rule) + "|")
    return written


def trimmed(body: str) -> str:
    """A file of tables, each cut to what is over all scenes."""
    blocks = []
    for block in body.split("\n\n"):
        if block.startswith("|"):
            block = "\n".join(together(block.split("\n")))
        blocks += [block] if block else []
    return "\n\n".join(blocks)


def members(printed: str) -> dict[str, str]:
    """What was printed of each member of a suite, by the names of their folders; nothing of a single experiment."""
    *parts, last = re.split(r"^results: (.*)$", printed, flags=re.MULTILINE)
    if "\nsuite: " not in last:
        return {}
    return {Path(folder).name: part for part, folder in zip(parts[::2], parts[1::2])}


# Of Student's t distribution, by the number of seeds: half of a 95 % interval in standard errors.
T95 = {2: 12.71, 3: 4.303, 4: 3.182, 5: 2.776, 6: 2.571, 7: 2.447, 8: 2.365, 9: 2.306, 10: 2.262}


def over_seeds(values: list[float]) -> str:
    """The mean, with its 95 % interval where there are several."""
    mean = statistics.mean(values)
    if len(values) == 1:
        return f"{mean:.2f}"
    half = T95[len(values)] * statistics.stdev(values) / len(values) ** 0.5
    return f"{mean:.2f} ± {half:.2f}"


def of_frames(results: str, asked: list[list[str]]) -> list[str]:
    """A table of the rays and processor seconds of frames of the only method there is, in the mean of its seeds."""
    with open(Path(results, "rows.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    if len({(row["scene"], row["view"], row["label"], row["sweep"]) for row in rows}) != 1:
        raise SystemExit("--frames: expected seeds of one case; give --errors for several")
    seeds = []
    for row in rows:
        with open(Path(results, "jobs", row["job"], "frames.csv"), newline="") as file:
            seeds.append(list(csv.DictReader(file)))
    prefix = "cpu_seconds_"
    final = seeds[0][-1]
    stages = [key[len(prefix):] for key in final if key.startswith(prefix) and final[key]]
    stages = [stage for stage in stages if stage != "total"] + ["total"]
    lines = [
        "| Frames | rays, 10⁶ | " + " | ".join(f"CPU {stage}, s" for stage in stages) + " |",
        "|:--|" + "--:|" * (1 + len(stages)),
    ]
    for span, text in asked:
        first, _, last = span.partition("-")
        wanted = range(int(first), int(last or first) + 1)

        def means(keys: list[str], unit: float = 1.0) -> str:
            chosen = [[row for row in frames if int(row["frame"]) in wanted] for frames in seeds]
            sums = [[sum(float(row[key] or 0) for key in keys) / unit for row in rows] for rows in chosen]
            return over_seeds([statistics.mean(values) for values in sums])

        seconds = " | ".join(means([prefix + stage]) for stage in stages)
        lines.append(f"| {span}: {text} | {means(['rays', 'shadow_rays'], 1e6)} | {seconds} |")
    told = f", with 95 % intervals over {len(seeds)} seeds" if len(seeds) > 1 else ""
    return ["## Rays and processor seconds of single frames", "", *lines, "", f"Means of `frames.csv`{told}.", ""]


def errors_of_frames(results: str, asked: list[list[str]], metrics: list[str]) -> list[str]:
    """A table of each metric: a line of frames, a column a method."""
    frames = {}
    with open(Path(results, "rows.csv"), newline="") as file:
        for row in csv.DictReader(file):
            with open(Path(results, "jobs", row["job"], "frames.csv"), newline="") as of_job:
                frames.setdefault(row["label"] or row["method"], []).extend(csv.DictReader(of_job))
    lines = []
    for metric in metrics:
        lines += [f"## {metric} of some frames", "", "| Frames | " + " | ".join(frames) + " |"]
        lines.append("|:--|" + "--:|" * len(frames))
        for span, text in asked:
            first, _, last = span.partition("-")
            wanted = range(int(first), int(last or first) + 1)
            means = []
            for all_frames in frames.values():
                values = [float(f[metric]) for f in all_frames if f[metric] and int(f["frame"]) in wanted]
                means.append(f"{sum(values) / len(values):.3f}" if values else "—")
            lines.append(f"| {span}: {text} | " + " | ".join(means) + " |")
        lines += ["", "Means of the measured frames of `frames.csv`.", ""]
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ["results", "log", "name", "title", "command"]:
        parser.add_argument(name)
    parser.add_argument("--together", action="store_true", help="keep of tables the columns over all scenes")
    parser.add_argument("--frames", nargs=2, action="append", default=[], metavar=("FIRST-LAST", "TEXT"))
    parser.add_argument("--errors", metavar="METRIC,…", help="of the frames told apart by --frames")
    asked = parser.parse_args()
    said = "; of its tables here are the columns over all scenes together." if asked.together else ""
    page = [f"# {asked.title}", "", f"`lightbench {asked.command}`{said}", ""]
    printed = Path(asked.log).read_text()
    parts = members(printed) or {"": printed}
    verdicts = {name: claims(part) for name, part in parts.items()}
    if any(verdicts.values()):
        page += ["## Claims", ""]
    for name, lines in verdicts.items():
        page += [f"### {name}", ""] if name and lines else []
        page += [*lines, ""] if lines else []
    if not any(Path(asked.results, name, "tables").is_dir() for name in parts):
        raise SystemExit(f"{asked.results}: no tables; of a suite RUN.log is needed with its lines `results: …` (run it without -q)")
    for name, part in parts.items():
        # In the order in which they were printed, by their titles.
        tables = [path.read_text().rstrip("\n") for path in Path(asked.results, name, "tables").glob("*.md")]
        title_of = {text: text.partition("\n")[0].lstrip("# ") for text in tables}
        for text in sorted(tables, key=lambda text: part.find("\n" + title_of[text] + "\n")):
            body = trimmed(text) if asked.together else text
            rest = body.partition("\n")[2]
            heading = f"{name}: {title_of[text]}" if name else title_of[text]
            page += [f"## {heading}\n{rest}", ""]
    if asked.frames and asked.errors:
        page += errors_of_frames(asked.results, asked.frames, asked.errors.split(","))
    elif asked.frames:
        page += of_frames(asked.results, asked.frames)
    target = Path(__file__).parent.parent / "results" / "published" / f"{asked.name}.md"
    target.write_text("\n".join(page).rstrip("\n") + "\n")
    print(target)


if __name__ == "__main__":
    main()
