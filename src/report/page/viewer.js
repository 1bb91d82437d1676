// The viewer: which image, which map of it, at which frame, and what the pixel under the pointer holds.
const viewers = [...document.querySelectorAll(".viewer")].map(function (root) {
  const album = JSON.parse(root.dataset.album);
  const MODES = {
    image: { name: "image" },
    flip: { name: "FLIP", palette: "magma", told: "FLIP map" },
    error: { name: "error", palette: "magma", told: "absolute error of the luminance" },
    signed: { name: "difference", palette: "signed", told: "luminance less the reference's" },
    luminance: { name: "luminance", palette: "viridis", told: "luminance" },
    discontinuity: { name: "discontinuity", palette: "viridis", told: "discontinuity" },
  };
  const end = album.error_end || 1, white = 2 ** -album.exposure;
  const ranges = { flip: [0, 1], error: [0, end], signed: [-end, end], luminance: [0, white], discontinuity: [0, 1] };
  const first = album.labels[0] === "reference" ? 0 : -1;
  const state = {
    eye: 0, frame: album.start, chosen: album.labels.length - 1, other: first >= 0 ? 0 : Math.max(0, album.labels.length - 2),
    mode: "image", exposure: album.exposure, curve: "linear", split: false, all: false, marks: false, place: null,
  };
  let timer = null, turn = 0;
  const painted = new Map();

  // --- the controls
  function make(tag, attributes, ...inside) {
    const node = document.createElement(tag);
    for (const key in attributes) {
      if (key.startsWith("on")) node.addEventListener(key.slice(2), attributes[key]);
      else node.setAttribute(key, attributes[key]);
    }
    node.append(...inside);
    return node;
  }
  const button = (kind, text, act, title) => make("button", { type: "button", class: kind, onclick: act, title: title || "" }, text);
  const gap = () => make("span", { class: "gap" });
  const has = (what) => album.cells.some((eye) => eye.some((frame) => frame.some((cell) => cell[what])));
  const choices = album.labels.map((label, i) => button("frame", (i < 9 ? i + 1 + " " : "") + label, () => choose(i)));
  const modes = Object.keys(MODES).filter((m) => m === "image" || m === "luminance" || (m === "error" || m === "signed" ? first >= 0 : has(m)))
    .map(function (m) { const b = button("mode", MODES[m].name, () => viewer.mode(m)); b.dataset.mode = m; return b; });
  const split = button("split", "split", () => viewer.split(), "two images with a divider (s)");
  const all = button("all", "all", () => viewer.all(), "all images at once (a)");
  const marked = ["records", "lights", "cells"].filter(has);
  const marks = button("marks", marked.join(" and "), () => viewer.marks(), "where records are, lights on the environment map, and a colour for each cell that pixels show (o)");
  const stops = make("input", { type: "range", class: "exposure", min: album.exposure - 8, max: album.exposure + 8, step: 0.1, "aria-label": "exposure",
    oninput: () => { state.exposure = Number(stops.value); show(); } });
  const curve = make("select", { class: "curve", "aria-label": "tone curve", onchange: () => { state.curve = curve.value; show(); } },
    ...paint.curves.map((name) => make("option", { value: name }, name)));
  const stopsTold = make("output", { class: "stops" });
  const ends = [0, 1].map((i) => make("input", { type: "number", class: "end", step: "any", "aria-label": i ? "end of the range" : "start of the range",
    onchange: () => { ranges[state.mode][i] = Number(ends[i].value); show(); } }));
  const width = make("input", { type: "range", class: "width", min: -6, max: 6, step: 0.05, value: 0, "aria-label": "width of the range", oninput: stretch });
  const ramp = make("span", { class: "ramp" });
  const light = make("div", { class: "bar light" }, "exposure", stops, stopsTold, curve, button("back", "reset", () => { state.exposure = album.exposure; state.curve = "linear"; show(); }));
  const range = make("div", { class: "bar range" }, ends[0], ramp, ends[1], "range", width, button("auto", "fit", () => autoRange()));
  const bars = [
    make("div", { class: "bar" }, ...choices),
    make("div", { class: "bar" }, ...modes, gap(), split, all, ...(marked.length ? [marks] : []), gap(),
      button("zoom", "−", () => viewer.zoom(-1), "zoom out (−)"), button("zoom", "+", () => viewer.zoom(1), "zoom in (+)"), button("zoom", "fit", () => stage.reset(), "the whole image (0)")),
    light, range,
  ];
  const play = button("play", "play", toggle);
  const slider = make("input", { type: "range", class: "frames", min: 0, max: album.frames.length - 1, step: 1, value: state.frame, "aria-label": "frame", oninput: () => go(Number(slider.value)) });
  const frameTold = make("output", {});
  const eyes = album.viewers.map((name, i) => button("eye", name, () => look(i)));
  if (album.frames.length > 1 || album.viewers.length > 1) {
    bars.push(make("div", { class: "bar" }, play, slider, frameTold, ...(eyes.length > 1 ? [gap(), ...eyes] : [])));
  }
  const caption = make("p", { class: "caption" });
  const board = make("div", { class: "stage", tabindex: "0" });
  const probe = make("p", { class: "probe" });
  const again = make("code", {});
  const replay = make("p", { class: "replay", hidden: "" }, again, " ", button("copy", "copy", () => navigator.clipboard && navigator.clipboard.writeText(again.textContent).catch(() => {})));
  root.append(...bars, caption, board, probe, replay);
  const stage = makeStage(board, album, { over: over, click: click });

  // --- what is shown
  function cell(index, at = state.frame) { return album.cells[state.eye][at][index]; }
  function modeOf(index) {
    const data = cell(index);
    if (state.mode === "image" || !data.image) return "image";
    if (state.mode === "luminance") return "luminance";
    if (state.mode === "error" || state.mode === "signed") return index !== first && first >= 0 && cell(first).image ? state.mode : "image";
    return data[state.mode] ? state.mode : "image";
  }

  async function numbersOf(index, mode) {
    const data = cell(index);
    if (mode === "luminance") return paint.luminance(await lightbench.load(data.image));
    if (mode === "signed" || mode === "error") {
      const [own, reference] = await Promise.all([lightbench.load(data.image), lightbench.load(cell(first).image)]);
      const numbers = paint.difference(own, reference);
      return mode === "signed" ? numbers : numbers.map(Math.abs);
    }
    return paint.plain(await lightbench.load(data[mode]));
  }

  // An image's canvas, painted again when what it depends on has changed, and its values.
  async function prepared(index) {
    const data = cell(index), mode = modeOf(index);
    const result = { label: album.labels[index], index, mode, picture: null, at: null, dots: null, tint: null, inset: null };
    if (!data.image) {
      if (data.picture) result.picture = await eightBits(data.picture);
      return result;
    }
    const halves = await lightbench.load(data.image);
    if (!halves) return result;
    const key = [index, mode].join(), look = [state.eye, state.frame, mode === "image" ? state.exposure + state.curve : ranges[mode]].join();
    let entry = painted.get(key);
    if (!entry) {
      const canvas = document.createElement("canvas");
      canvas.width = album.width;
      canvas.height = album.height;
      painted.set(key, entry = { canvas, look: "" });
    }
    if (entry.look !== look) {
      const context = entry.canvas.getContext("2d", { willReadFrequently: true }), out = context.createImageData(album.width, album.height);
      if (mode === "image") paint.picture(halves, out, state.exposure, state.curve);
      else {
        entry.numbers = await numbersOf(index, mode);
        paint.map(entry.numbers, out, ranges[mode], MODES[mode].palette);
      }
      context.putImageData(out, 0, 0);
      entry.look = look;
    }
    const n = album.width * album.height, numbers = entry.numbers;
    result.picture = entry.canvas;
    result.halves = halves;
    result.at = (x, y) => mode === "image" ? [0, 1, 2].map((c) => short(lightbench.values[halves[x + y * album.width + c * n]])) : [short(numbers[x + y * album.width])];
    if (state.marks && data.records) result.dots = await places(data.records);
    if (state.marks && data.cells) result.tint = await tintOf(data.cells);
    if (state.marks && data.lights) result.inset = await eightBits(data.lights);
    return result;
  }

  const dotsOf = new Map();
  async function places(name) {
    if (!dotsOf.has(name)) {
      const halves = await lightbench.load(name), list = [];
      halves.forEach((bits, i) => { if (bits) list.push(i % album.width, Math.floor(i / album.width), lightbench.values[bits]); });
      dotsOf.set(name, list);
    }
    return dotsOf.get(name);
  }

  const tints = new Map();
  async function tintOf(name) {
    if (!tints.has(name)) {
      const halves = await lightbench.load(name), canvas = document.createElement("canvas");
      canvas.width = album.width;
      canvas.height = album.height;
      const context = canvas.getContext("2d"), out = context.createImageData(album.width, album.height);
      paint.tint(halves, out);
      context.putImageData(out, 0, 0);
      tints.set(name, canvas);
    }
    return tints.get(name);
  }

  const pictures = {};
  function eightBits(source) {
    if (!pictures[source]) {
      pictures[source] = new Promise(function (resolve) {
        const image = new Image();
        image.onload = () => resolve(image);
        image.onerror = () => resolve(null);
        image.src = source;
      });
    }
    return pictures[source];
  }

  async function show() {
    const mine = ++turn;
    buttons();
    const wanted = state.all ? album.labels.map((_, i) => i) : [state.chosen];
    const shown = await Promise.all(wanted.map(prepared));
    const other = state.split && !state.all ? await prepared(state.other) : null;
    if (mine !== turn) return;
    stage.show(shown.map((s) => ({ shown: s, other })));
    viewer.shown = shown.concat(other || []);
    tell();
  }

  function press(b, on) { b.setAttribute("aria-pressed", on); }
  function buttons() {
    const mode = state.all ? state.mode : modeOf(state.chosen), map = mode !== "image";
    choices.forEach(function (b, i) { press(b, i === state.chosen); b.classList.toggle("other", state.split && i === state.other); });
    modes.forEach(function (b) { press(b, b.dataset.mode === state.mode); });
    press(split, state.split); press(all, state.all); press(marks, state.marks);
    light.hidden = map || !cell(state.chosen).image;
    range.hidden = !map;
    stops.value = state.exposure;
    stopsTold.textContent = (state.exposure >= 0 ? "+" : "−") + Math.abs(state.exposure).toFixed(1) + " stops";
    curve.value = state.curve;
    if (map) {
      ends.forEach((e, i) => { e.value = Number(ranges[mode][i].toPrecision(4)); });
      ramp.style.background = paint.gradient(MODES[mode].palette);
    }
    slider.value = state.frame;
    frameTold.textContent = album.frames[state.frame];
    eyes.forEach((b, i) => press(b, i === state.eye));
  }

  function short(x) {
    if (!Number.isFinite(x)) return String(x);
    const size = Math.abs(x);
    return size === 0 ? "0" : size >= 1000 || size < 0.001 ? x.toExponential(2) : x.toPrecision(3);
  }

  function tell() {
    const data = cell(state.chosen), label = make("b", {}, album.labels[state.chosen]);
    const mode = modeOf(state.chosen), what = data.image || data.picture ? data.values : "no image of this frame";
    caption.replaceChildren(label, what);
    if (mode !== "image") caption.append((what ? " · " : "") + MODES[mode].told);
    else if (state.mode !== "image" && data.image) caption.append((what ? " · " : "") + "image: it has no such map");
    else if (data.picture && !data.image) caption.append(" · eight bits, at one exposure");
    over(state.place);
  }

  // Values of the pixel under the pointer, in every image that is shown, and in the reference.
  async function over(place) {
    state.place = place;
    if (!place) { probe.textContent = "\u00a0"; return; }
    const n = album.width * album.height, at = place.x + place.y * album.width, mine = turn;
    const told = ["pixel " + place.x + ", " + place.y];
    const list = [...new Set([first, ...(viewer.shown || []).map((s) => s.index)])].filter((i) => i >= 0);
    for (const index of list) {
      const halves = await lightbench.load(cell(index).image);
      if (halves) told.push(album.labels[index] + " " + [0, 1, 2].map((c) => short(lightbench.values[halves[at + c * n]])).join(" "));
      const mode = modeOf(index);
      if (mode !== "image" && painted.has([index, mode].join())) told.push(MODES[mode].name + " " + short(painted.get([index, mode].join()).numbers[at]));
    }
    if (mine === turn && state.place === place) probe.textContent = told.join(" · ");
  }

  // A click flips to the reference and back, and says how the pixel is replayed.
  function click(pane, place) {
    if (state.all) { state.all = false; choose(pane, true); return; }
    const job = album.jobs[state.chosen] || album.jobs[state.other];
    if (job && place) {
      const folder = document.body.dataset.folder + "/jobs/" + job;
      again.textContent = located("lightbench replay " + quoted(folder) + " --pixel " + place.x + "," + place.y);
      replay.hidden = false;
    }
    flip();
  }

  // --- what changes it
  function choose(index, again) {
    if (index < 0 || index >= album.labels.length || (index === state.chosen && !again)) return;
    if (index !== state.chosen) state.other = state.chosen;
    state.chosen = index;
    show();
  }
  function flip() { choose(state.chosen === first || first < 0 ? state.other : first); }
  function go(to) { state.frame = (to + album.frames.length) % album.frames.length; show(); }
  function look(to) { state.eye = to % album.viewers.length; show(); }
  function preload(at) { return Promise.all(album.labels.map((_, i) => cell(i, at)).map((c) => c.image ? lightbench.load(c.image) : c.picture && eightBits(c.picture))); }

  // Waits for the next image rather than showing nothing.
  async function advance() {
    const next = (state.frame + 1) % album.frames.length, data = cell(state.chosen, next);
    await (data.image ? lightbench.load(data.image) : data.picture && eightBits(data.picture));
    if (timer !== null) { go(next); timer = setTimeout(advance, album.delay_ms); }
  }
  function toggle() {
    if (album.frames.length < 2) return;
    if (timer === null) timer = setTimeout(advance, album.delay_ms);
    else { clearTimeout(timer); timer = null; }
    play.textContent = timer === null ? "play" : "pause";
    press(play, timer !== null);
  }

  // The slider widens or narrows a range about its start, or about zero where there are signs.
  let narrow = 0;
  function stretch() {
    const by = 2 ** (Number(width.value) - narrow), r = ranges[state.mode];
    narrow = Number(width.value);
    ranges[state.mode] = state.mode === "signed" ? [r[0] * by, r[1] * by] : [r[0], r[0] + (r[1] - r[0]) * by];
    show();
  }
  async function autoRange() {
    const mode = modeOf(state.chosen);
    if (mode === "image") return;
    const sorted = (await numbersOf(state.chosen, mode)).filter(Number.isFinite).map(mode === "signed" ? Math.abs : (x) => x).sort();
    const high = sorted[Math.floor((sorted.length - 1) * 0.995)] || sorted[sorted.length - 1] || 1;
    ranges[mode] = mode === "signed" ? [-high, high] : [Math.min(0, sorted[0]), high];
    show();
  }

  const viewer = {
    state, shown: [],
    flip, choose, look: () => look(state.eye + 1), play: toggle,
    step: (by) => album.frames.length > 1 ? go(state.frame + by) : choose((state.chosen + by + album.labels.length) % album.labels.length),
    mode: function (name) {
      if (modes.some((b) => b.dataset.mode === name)) { state.mode = name; narrow = 0; width.value = 0; show(); }
    },
    zoom: (by) => stage.zoomBy(2 ** by), reset: () => stage.reset(),
    split: () => { state.split = !state.split; state.all = false; show(); },
    all: () => { state.all = !state.all; show(); },
    marks: () => { if (marked.length) { state.marks = !state.marks; show(); } },
    brighten: (by) => { state.exposure += by; show(); },
  };
  function use() { active = viewer; preload(state.frame); }
  root.addEventListener("pointerenter", use);
  root.addEventListener("focusin", use);
  if (timer === null && window.IntersectionObserver) {
    const seen = new IntersectionObserver(function (entries) {
      if (entries.some((e) => e.isIntersecting)) { seen.disconnect(); show(); }
    }, { rootMargin: "600px" });
    seen.observe(root);
  } else show();
  window.addEventListener("beforeprint", show);
  buttons();
  return viewer;
});
var active = viewers[0];

document.addEventListener("keydown", function (event) {
  if (!active || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.matches && event.target.matches("input[type=number], select")) return;
  const key = event.key;
  const keys = {
    ArrowRight: () => active.step(1), ArrowLeft: () => active.step(-1), r: active.flip,
    i: () => active.mode("image"), f: () => active.mode("flip"), e: () => active.mode("error"),
    d: () => active.mode("signed"), l: () => active.mode("luminance"),
    p: active.play, v: active.look, s: active.split, a: active.all, o: active.marks,
    "+": () => active.zoom(1), "=": () => active.zoom(1), "-": () => active.zoom(-1), 0: active.reset,
    "[": () => active.brighten(-0.5), "]": () => active.brighten(0.5),
  };
  if (key >= "1" && key <= "9") active.choose(Number(key) - 1);
  else if (keys[key]) keys[key]();
  else return;
  event.preventDefault();
});
