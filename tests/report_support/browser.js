// What a person does with the page; each finding is a line of the page's last element.
(async function () {
  const told = [];
  try { await use(told); } catch (error) { told.push("ERROR " + error); }
  const result = document.createElement("pre");
  result.id = "self-test";
  result.textContent = told.concat("end").join("\n");
  document.body.append(result);
})();

async function use(told) {
  window.addEventListener("error", (event) => told.push("ERROR " + event.message));
  window.addEventListener("unhandledrejection", (event) => told.push("ERROR " + event.reason));
  const error = console.error;
  console.error = function (...words) { told.push("ERROR " + words.join(" ")); error(...words); };
  const check = (what, fine) => told.push((fine ? "ok " : "FAILED ") + what);
  const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  async function until(condition) {
    for (let i = 0; i < 200 && !condition(); i++) await wait(25);
    return condition();
  }
  const root = document.querySelector(".viewer"), find = (what) => root.querySelector(what);
  root.scrollIntoView();
  root.dispatchEvent(new PointerEvent("pointerenter"));
  const canvas = () => find(".stage canvas");
  const press = (key) => document.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  // A number that stands for what a pane shows.
  function look() {
    if (!canvas()) return 0;
    const { data } = canvas().getContext("2d").getImageData(0, 0, canvas().width, canvas().height);
    let sum = 0;
    for (let i = 0; i < data.length; i++) sum = (sum * 31 + data[i]) | 0;
    return sum;
  }
  const changes = async (act) => { const before = look(); act(); return until(() => look() !== before); };
  const pressed = () => find(".frame[aria-pressed=true]").textContent;

  check("an image is drawn", await until(look));
  const first = pressed();
  check("r flips", (await changes(() => press("r"))) && pressed() !== first && pressed().includes("reference"));
  check("and back", (await changes(() => press("r"))) && pressed() === first);
  check("a number chooses", (await changes(() => press("1"))) && pressed().startsWith("1 "));
  await changes(() => press("2"));
  check("exposure changes pixels", await changes(() => { const s = find("input.exposure"); s.value = Number(s.value) - 2; s.dispatchEvent(new Event("input")); }));
  check("a tone curve changes pixels", await changes(() => { const s = find("select.curve"); s.value = "ACES"; s.dispatchEvent(new Event("change")); }));
  for (const [key, name] of [["e", "error"], ["d", "signed"], ["f", "flip"], ["l", "luminance"], ["i", "image"]]) {
    check(name, (await changes(() => press(key))) && find(".mode[data-mode=" + name + "]").getAttribute("aria-pressed") === "true");
  }
  press("e");
  await wait(100);
  check("a range changes pixels", await changes(() => { const s = find("input.width"); s.value = -3; s.dispatchEvent(new Event("input")); }));
  press("i");
  await wait(100);
  check("+ zooms", await changes(() => { for (let i = 0; i < 3; i++) press("+"); }));
  check("0 shows all", await changes(() => press("0")));
  const box = canvas().getBoundingClientRect();
  const at = (kind, x, y) => canvas().dispatchEvent(new PointerEvent(kind, { clientX: box.left + x * box.width, clientY: box.top + y * box.height, bubbles: true, pointerId: 1 }));
  canvas().setPointerCapture = () => {};
  at("pointermove", 0.5, 0.5);
  check("values under the pointer", await until(() => /pixel \d+, \d+ .*\d/.test(find(".probe").textContent)));
  press("s");
  await wait(100);
  check("the divider moves", await changes(() => { at("pointerdown", 0.5, 0.5); at("pointermove", 0.1, 0.5); at("pointerup", 0.1, 0.5); }));
  press("s");
  const folder = document.body.dataset.folder;
  document.body.dataset.folder = "results/two words";
  const moved = located("rm -r 'results/two words/jobs/1' && lightbench run a.toml --out 'results/two words'");
  document.body.dataset.folder = folder;
  check("commands name the page's place, also quoted", !moved.includes("two words") && moved.startsWith("rm -r ") && moved.includes("/jobs/1"));
  check("o marks records", await changes(() => press("o")));
  const kept = JSON.parse(root.dataset.album).cells[0][0].some((cell) => cell.lights);
  check("and lights where they were kept", find(".marks").textContent === (kept ? "records and lights" : "records"));
  if (kept) check("the map is drawn", active.shown.some((shown) => shown.inset && shown.inset.width > 0));
  await changes(() => press("o"));
  press("a");
  check("all at once", await until(() => root.querySelectorAll("canvas").length === root.querySelectorAll(".frame").length));
  press("a");
  await until(() => root.querySelectorAll("canvas").length === 1);
  const slider = find("input.frames");
  if (slider) {
    const output = slider.nextSibling, before = output.textContent;
    check("the slider moves", await changes(() => { slider.value = slider.value === "0" ? 1 : 0; slider.dispatchEvent(new Event("input")); }));
    check("and says the frame", output.textContent !== before);
    const play = find("button.play"), last = slider.max;
    const plays = (on) => play.textContent === (on ? "pause" : "play") && (play.getAttribute("aria-pressed") === "true") === on;
    const stood = plays(false);
    play.click();
    check("the play button plays", stood && plays(true));
    const seen = new Set(), frames = () => seen.add(slider.value).size > Number(last);
    check("every frame, round and round", await until(frames) && (seen.clear(), await until(frames)));
    play.click();
    const still = slider.value;
    await wait(3 * JSON.parse(root.dataset.album).delay_ms);
    check("and stops", plays(false) && slider.value === still);
    press("p");
    check("p plays too", plays(true));
    press("p");
    const eyes = root.querySelectorAll(".eye");
    if (eyes.length > 1) {
      press("v");
      check("v takes the next viewer", eyes[1].getAttribute("aria-pressed") === "true");
    }
  }
  const table = document.querySelector(".jobs table"), column = [...table.tHead.rows[0].cells].findIndex((c) => c.textContent === "RMSE");
  const values = () => [...table.tBodies[0].rows].map((row) => Number(row.cells[column].dataset.value));
  const sorted = (list, way) => list.every((v, i) => i === 0 || way * (v - list[i - 1]) >= 0);
  table.tHead.rows[0].cells[column].click();
  check("a table sorts", sorted(values(), 1) && values().length > 1);
  table.tHead.rows[0].cells[column].click();
  check("and turns round", sorted(values(), -1));
  document.querySelector("button.command").click();
  const command = document.querySelector("pre.chosen").textContent;
  const here = decodeURIComponent(location.pathname).replace(/\/[^/]*$/, "");
  check("a command is shown with the folder of the page", command.startsWith("rm -r " + here + "/jobs/") && command.endsWith("--out " + here));
  check("and in what reports it again", document.querySelector("pre.located").textContent === "lightbench report " + here);
  check("nothing is wider than the page", document.documentElement.scrollWidth <= window.innerWidth);
}
