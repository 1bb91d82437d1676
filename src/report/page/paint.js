// From pixels to colours: exposure and tone curves, false colours.
const paint = (function () {
  const value = lightbench.values;
  const CODED = 4096;
  const srgb = new Uint8ClampedArray(CODED + 1);
  for (let i = 0; i <= CODED; i++) {
    const x = i / CODED;
    srgb[i] = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055);
  }
  const ratio = (k) => (x) => (x * x * k[0] + x * k[1]) / (x * x * k[2] + x * k[3] + k[4]);
  // As `image::ToneCurve`; the first is how figures show images.
  const curves = {
    "linear": (x) => x,
    "ACES": ratio([0.9036, 0.018, 0.8748, 0.354, 0.14]),
    "Hable": ratio([0.231683, 0.013791, 0.18, 0.3, 0.018]),
    "Reinhard": (x) => x / (1 + x),
  };
  const palettes = {
    magma: [[0, 0, 3], [28, 18, 71], [82, 18, 125], [130, 38, 130], [184, 56, 120], [230, 79, 99], [250, 135, 97],
      [252, 196, 135], [252, 252, 191]],
    viridis: [[69, 0, 84], [71, 43, 122], [59, 82, 140], [43, 115, 143], [33, 145, 140], [41, 173, 128],
      [94, 201, 97], [173, 219, 48], [252, 232, 38]],
    signed: [[5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [247, 247, 247], [244, 165, 130],
      [214, 96, 77], [178, 24, 43], [103, 0, 31]],
  };
  const NOT_FINITE = [0, 255, 0];

  // 256 colours of a palette, for any number of pixels.
  const ramps = {};
  for (const name in palettes) {
    const table = palettes[name], ramp = new Uint8ClampedArray(3 * 256);
    for (let i = 0; i < 256; i++) {
      const at = i / 255 * (table.length - 1), low = Math.min(Math.floor(at), table.length - 2), t = at - low;
      for (let c = 0; c < 3; c++) ramp[3 * i + c] = table[low][c] * (1 - t) + table[low + 1][c] * t;
    }
    ramps[name] = ramp;
  }

  function gradient(name) {
    return "linear-gradient(to right, " + palettes[name].map((c) => "rgb(" + c + ")").join(", ") + ")";
  }

  // A picture at an exposure in stops. What is not finite is green.
  function picture(halves, out, exposure, curve) {
    const n = halves.length / 3, scale = 2 ** exposure, tone = curves[curve], data = out.data;
    // One look-up for each of the values there can be.
    const shown = new Uint8Array(65536);
    for (let bits = 0; bits < 65536; bits++) {
      const x = tone(Math.max(value[bits], 0) * scale);
      shown[bits] = srgb[Math.min(Math.round((x > 0 ? Math.min(x, 1) : 0) * CODED), CODED)];
    }
    const finite = (bits) => (bits & 0x7c00) !== 0x7c00;
    for (let i = 0; i < n; i++) {
      const r = halves[i], g = halves[i + n], b = halves[i + 2 * n];
      const fine = finite(r) && finite(g) && finite(b);
      data[4 * i] = fine ? shown[r] : NOT_FINITE[0];
      data[4 * i + 1] = fine ? shown[g] : NOT_FINITE[1];
      data[4 * i + 2] = fine ? shown[b] : NOT_FINITE[2];
      data[4 * i + 3] = 255;
    }
  }

  // Numbers in false colours, the ends of the palette at the ends of the range.
  function map(numbers, out, [low, high], palette) {
    const ramp = ramps[palette], data = out.data, scale = high > low ? 255 / (high - low) : 0;
    for (let i = 0; i < numbers.length; i++) {
      const x = numbers[i];
      const at = 3 * Math.max(0, Math.min(255, Math.round((x - low) * scale)));
      const fine = Number.isFinite(x);
      for (let c = 0; c < 3; c++) data[4 * i + c] = fine ? ramp[at + c] : NOT_FINITE[c];
      data[4 * i + 3] = 255;
    }
  }

  // Numbers of cells in colours that tell neighbours apart, clear where there is none.
  function tint(halves, out) {
    for (let i = 0; i < halves.length; i++) {
      const number = value[halves[i]], turn = number * 0.618;
      for (let c = 0; c < 3; c++) out.data[4 * i + c] = 140 + 110 * Math.cos(2 * Math.PI * (turn + c / 3));
      out.data[4 * i + 3] = number ? 165 : 0;
    }
  }

  const weights = [0.2126, 0.7152, 0.0722];
  function luminance(halves) {
    const n = halves.length / 3, out = new Float32Array(n);
    for (let i = 0; i < n; i++) {
      out[i] = weights[0] * value[halves[i]] + weights[1] * value[halves[i + n]] + weights[2] * value[halves[i + 2 * n]];
    }
    return out;
  }

  function plain(halves) { return Float32Array.from(halves, (bits) => value[bits]); }

  function difference(halves, reference) {
    const a = luminance(halves), b = luminance(reference);
    for (let i = 0; i < a.length; i++) a[i] -= b[i];
    return a;
  }

  return { curves: Object.keys(curves), gradient, picture, map, tint, luminance, plain, difference };
})();
