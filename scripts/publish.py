#!/usr/bin/env python3
"""Writes what a run found into results/published: a title, its command, the verdicts on claims, and its tables.

    lightbench run CONFIG … > RUN.log
    scripts/publish.py RESULTS RUN.log NAME "Title" "the command, as it was given"

RESULTS is the folder of the run and RUN.log what it printed. NAME.md is written; add it to the list of
docs/results.md, which a test compares with the folder.
"""

import re
import sys
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


def main() -> None:
    results, log, name, title, command = sys.argv[1:6]
    page = [f"# {title}", "", f"`lightbench {command}`", ""]
    verdicts = claims(Path(log).read_text())
    if verdicts:
        page += ["## Claims", "", *verdicts, ""]
    printed = Path(log).read_text()
    tables = list(Path(results, "tables").glob("*.md"))
    # In the order in which they were printed, by their titles.
    text = {path: path.read_text().rstrip("\n") for path in tables}
    title_of = {path: body.partition("\n")[0].lstrip("# ") for path, body in text.items()}
    for path in sorted(tables, key=lambda path: printed.find("\n" + title_of[path] + "\n")):
        page += ["#" + text[path], ""]
    target = Path(__file__).parent.parent / "results" / "published" / f"{name}.md"
    target.write_text("\n".join(page).rstrip("\n") + "\n")
    print(target)


if __name__ == "__main__":
    main()
