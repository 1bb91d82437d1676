// Tables sort by the column whose heading is clicked, block by block; a second click turns the order round.
document.querySelectorAll("table.numbers").forEach(function (table) {
  const heads = [...table.tHead.rows[table.tHead.rows.length - 1].cells];
  // What stands for a number: `0.0840 ± 0.0012` is 0.084, `1.2M` a million more.
  const powers = { k: 1e3, M: 1e6, G: 1e9, "%": 0.01 };
  function sortKey(cell) {
    const text = (cell.dataset.value || cell.textContent).trim().replace("−", "-");
    const found = text.match(/^[<>≈]?\s*([+-]?[\d,]*\.?\d+(?:e[+-]?\d+)?)\s*([kMG%])?/);
    return found ? Number(found[1].replace(/,/g, "")) * (powers[found[2]] || 1) : text === "—" ? null : text;
  }
  // Ascending; numbers before texts; what is missing last, whichever way.
  function compare(a, b, way) {
    if (a === null || b === null) return (a === null) - (b === null);
    if (typeof a !== typeof b) return way * (typeof a === "number" ? -1 : 1);
    return way * (typeof a === "number" ? a - b : a.localeCompare(b));
  }
  heads.forEach(function (head, column) {
    if (!head.textContent.trim()) return;
    head.tabIndex = 0;
    head.title = "sort";
    function sort() {
      const way = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      heads.forEach((h) => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", way === 1 ? "ascending" : "descending");
      for (const body of table.tBodies) {
        const lines = [...body.rows].filter((row) => !row.classList.contains("block"));
        const keyed = lines.map((row) => [sortKey(row.cells[column]), row]);
        keyed.sort((a, b) => compare(a[0], b[0], way));
        body.append(...keyed.map((pair) => pair[1]));
      }
    }
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => { if (event.key === "Enter") sort(); });
  });
});

// Commands are shown and copied with a click.
document.querySelectorAll("button.command").forEach(function (button) {
  button.addEventListener("click", function () {
    const shown = document.querySelector("pre.chosen"), command = button.dataset.command;
    shown.textContent = command;
    shown.hidden = false;
    if (navigator.clipboard) navigator.clipboard.writeText(command).catch(() => {});
  });
});

window.addEventListener("beforeprint", function () {
  document.querySelectorAll("details:not(.jobs)").forEach((d) => { d.open = true; });
});
