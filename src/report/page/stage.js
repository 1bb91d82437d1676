// Where images are shown: panes that pan and zoom as one, to single pixels; a divider between two images.
function makeStage(root, album, on) {
  const MOST = 64, CLOSE = 44;
  const panes = [];
  // Magnification over the fitted image, and the image's point in the middle of a pane.
  const view = { zoom: 1, x: album.width / 2, y: album.height / 2 };
  let cut = 0.5;

  function fit(pane) { return Math.min(pane.canvas.width / album.width, pane.canvas.height / album.height); }
  function scale(pane) { return fit(pane) * view.zoom; }
  function corner(pane) {
    const s = scale(pane);
    return { s, x: pane.canvas.width / 2 - view.x * s, y: pane.canvas.height / 2 - view.y * s };
  }

  function keepInside() {
    if (!panes.length) return;
    const s = scale(panes[0]);
    const clamp = function (at, side, room) {
      const half = room / s / 2;
      return half * 2 >= side ? side / 2 : Math.max(half, Math.min(side - half, at));
    };
    view.x = clamp(view.x, album.width, panes[0].canvas.width);
    view.y = clamp(view.y, album.height, panes[0].canvas.height);
  }

  // Magnifies about a point of a pane, in its pixels.
  function zoomBy(factor, pane = panes[0], px = pane.canvas.width / 2, py = pane.canvas.height / 2) {
    const before = corner(pane);
    const at = { x: (px - before.x) / before.s, y: (py - before.y) / before.s };
    const most = Math.max(1, MOST * (window.devicePixelRatio || 1) / fit(pane));
    view.zoom = Math.max(1, Math.min(most, view.zoom * factor));
    const s = scale(pane);
    view.x = at.x - (px - pane.canvas.width / 2) / s;
    view.y = at.y - (py - pane.canvas.height / 2) / s;
    keepInside();
    draw();
  }

  function reset() { view.zoom = 1; keepInside(); draw(); }

  function size() {
    for (const pane of panes) {
      const width = Math.max(1, Math.round(pane.canvas.clientWidth * (window.devicePixelRatio || 1)));
      const tall = width * album.height / album.width;
      const most = 0.86 * window.innerHeight * (window.devicePixelRatio || 1);
      pane.canvas.width = width;
      pane.canvas.height = Math.max(1, Math.round(Math.min(tall, Math.max(most, 200))));
    }
    keepInside();
  }

  function drawOne(context, shown, from, to, at) {
    const { canvas } = context;
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, canvas.height);
    context.clip();
    context.imageSmoothingEnabled = at.s < 1;
    if (shown.picture) {
      context.drawImage(shown.picture, at.x, at.y, album.width * at.s, album.height * at.s);
    }
    if (shown.tint) context.drawImage(shown.tint, at.x, at.y, album.width * at.s, album.height * at.s);
    if (shown.dots) dots(context, shown.dots, at);
    if (shown.inset) inset(context, shown.inset, from, to);
    if (at.s / (window.devicePixelRatio || 1) >= CLOSE && shown.at) numbers(context, shown, at);
    context.restore();
  }

  // A picture in the lower left corner of what is shown between two columns.
  function inset(context, picture, from, to) {
    const ratio = window.devicePixelRatio || 1, edge = 8 * ratio;
    const width = Math.min(0.45 * context.canvas.width, to - from - 2 * edge), height = width * picture.height / picture.width;
    if (width < 40 * ratio) return;
    const x = from + edge, y = context.canvas.height - edge - height;
    context.fillStyle = "#fff";
    context.fillRect(x - ratio, y - ratio, width + 2 * ratio, height + 2 * ratio);
    context.imageSmoothingEnabled = true;
    context.drawImage(picture, x, y, width, height);
  }

  // Records, those of the refinement red.
  function dots(context, list, at) {
    const radius = Math.max(0.7, Math.min(5, 0.32 * at.s));
    for (const [stage, color] of [[1, "rgb(0, 69, 217)"], [2, "rgb(224, 13, 13)"]]) {
      context.fillStyle = color;
      context.beginPath();
      for (let i = 0; i < list.length; i += 3) {
        if (list[i + 2] !== stage) continue;
        const x = at.x + (list[i] + 0.5) * at.s, y = at.y + (list[i + 1] + 0.5) * at.s;
        context.moveTo(x + radius, y);
        context.arc(x, y, radius, 0, 7);
      }
      context.fill();
    }
  }

  // The values of every pixel, where there is room for them.
  function numbers(context, shown, at) {
    const { canvas } = context, line = at.s / 4.6;
    context.font = Math.floor(line * 0.86) + "px ui-monospace, monospace";
    context.textAlign = "center";
    const first = { x: Math.max(0, Math.floor(-at.x / at.s)), y: Math.max(0, Math.floor(-at.y / at.s)) };
    const wide = Math.ceil(canvas.width / at.s) + 1, tall = Math.ceil(canvas.height / at.s) + 1;
    const { data } = shown.picture.getContext("2d").getImageData(first.x, first.y, wide, tall);
    for (let y = first.y; y < album.height && at.y + y * at.s < canvas.height; y++) {
      for (let x = first.x; x < album.width && at.x + x * at.s < canvas.width; x++) {
        const texts = shown.at(x, y), i = 4 * (x - first.x + (y - first.y) * wide);
        context.fillStyle = 0.3 * data[i] + 0.6 * data[i + 1] + 0.1 * data[i + 2] > 110 ? "#000" : "#fff";
        texts.forEach(function (text, row) {
          const px = at.x + (x + 0.5) * at.s, py = at.y + (y + 0.5) * at.s + (row + 0.85 - texts.length / 2) * line;
          context.fillText(text, px, py);
        });
      }
    }
  }

  function name(context, text, x, align) {
    const ratio = window.devicePixelRatio || 1;
    context.font = 13 * ratio + "px system-ui, sans-serif";
    const width = context.measureText(text).width + 14 * ratio;
    const left = align === "right" ? x - width : x;
    context.fillStyle = "rgba(0, 0, 0, .66)";
    context.fillRect(left, 0, width, 22 * ratio);
    context.fillStyle = "#fff";
    context.textAlign = "left";
    context.fillText(text, left + 7 * ratio, 15.5 * ratio);
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    for (const pane of panes) {
      const { canvas } = pane, context = canvas.getContext("2d"), at = corner(pane);
      canvas.style.touchAction = view.zoom > 1 ? "none" : "pan-y";
      context.clearRect(0, 0, canvas.width, canvas.height);
      const shown = pane.shown;
      if (!shown) continue;
      const middle = Math.round(cut * canvas.width);
      drawOne(context, shown, 0, pane.other ? middle : canvas.width, at);
      if (pane.other) {
        drawOne(context, pane.other, middle, canvas.width, at);
        name(context, shown.label, 0, "left");
        name(context, pane.other.label, canvas.width, "right");
        context.fillStyle = "#333";
        context.fillRect(middle - 2 * ratio, 0, 4 * ratio, canvas.height);
        context.fillRect(middle - 6 * ratio, canvas.height / 2 - 17 * ratio, 12 * ratio, 34 * ratio);
        context.fillStyle = "#fff";
        context.fillRect(middle - ratio, 0, 2 * ratio, canvas.height);
        context.fillRect(middle - 5 * ratio, canvas.height / 2 - 16 * ratio, 10 * ratio, 32 * ratio);
        context.fillStyle = "#333";
        context.fillRect(middle - ratio / 2, canvas.height / 2 - 10 * ratio, ratio, 20 * ratio);
      } else if (panes.length > 1) {
        name(context, shown.label, 0, "left");
      }
      if (pane.mark && at.s >= 3 * ratio) {
        context.strokeStyle = "#fff";
        context.lineWidth = ratio;
        context.strokeRect(at.x + pane.mark.x * at.s, at.y + pane.mark.y * at.s, at.s, at.s);
      }
    }
  }

  // The image's pixel under a pointer, if there is one.
  function pixel(pane, event) {
    const box = pane.canvas.getBoundingClientRect(), at = corner(pane);
    const px = (event.clientX - box.left) * pane.canvas.width / box.width;
    const py = (event.clientY - box.top) * pane.canvas.height / box.height;
    const x = Math.floor((px - at.x) / at.s), y = Math.floor((py - at.y) / at.s);
    const inside = x >= 0 && y >= 0 && x < album.width && y < album.height;
    return { px, py, place: inside ? { x, y } : null };
  }

  function listen(pane) {
    const { canvas } = pane;
    let drag = null;
    const nearCut = (px) => pane.other && Math.abs(px - cut * canvas.width) < 12 * (window.devicePixelRatio || 1);
    canvas.addEventListener("pointerdown", function (event) {
      const { px, py } = pixel(pane, event);
      drag = { px, py, x: view.x, y: view.y, moved: false, cut: nearCut(px) };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", function (event) {
      const { px, py, place } = pixel(pane, event);
      if (drag) {
        drag.moved = drag.moved || Math.hypot(px - drag.px, py - drag.py) > 4;
        if (drag.cut) cut = Math.max(0, Math.min(1, px / canvas.width));
        else if (drag.moved) {
          view.x = drag.x - (px - drag.px) / scale(pane);
          view.y = drag.y - (py - drag.py) / scale(pane);
          keepInside();
        }
      }
      canvas.style.cursor = nearCut(px) ? "col-resize" : view.zoom > 1 ? "grab" : "crosshair";
      for (const each of panes) each.mark = place;
      on.over(place);
      draw();
    });
    canvas.addEventListener("pointerup", function (event) {
      if (drag && !drag.moved && !drag.cut) on.click(panes.indexOf(pane), pixel(pane, event).place);
      drag = null;
    });
    canvas.addEventListener("pointercancel", () => { drag = null; });
    canvas.addEventListener("pointerleave", function () {
      for (const each of panes) each.mark = null;
      on.over(null);
      draw();
    });
    canvas.addEventListener("wheel", function (event) {
      if (!event.ctrlKey && document.activeElement !== root) return;
      event.preventDefault();
      const { px, py } = pixel(pane, event);
      zoomBy(2 ** (-event.deltaY / 240), pane, px, py);
    }, { passive: false });
  }

  // As many panes as asked for; each shows an image, and beyond the divider another.
  function show(list) {
    while (panes.length > list.length) panes.pop().canvas.remove();
    const more = panes.length < list.length;
    while (panes.length < list.length) {
      const pane = { canvas: document.createElement("canvas"), mark: null };
      root.append(pane.canvas);
      panes.push(pane);
      listen(pane);
    }
    root.classList.toggle("several", list.length > 1);
    list.forEach((entry, i) => Object.assign(panes[i], entry));
    if (more || panes[0].columns !== list.length) size();
    panes[0].columns = list.length;
    draw();
  }

  new ResizeObserver(function () { size(); draw(); }).observe(root);
  return { show, zoomBy, reset, pan: function (x, y, zoom) { view.zoom = zoom; view.x = x; view.y = y; zoomBy(1); } };
}
