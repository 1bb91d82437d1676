// Pixels: half floats, unpacked when they are first asked for. They lie in scripts beside the page, or in the page.
const lightbench = (function () {
  const LIMIT = 4e8;
  const asked = new Map();
  let bytes = 0;

  // The value of every half float.
  const values = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
    values[bits] = sign * (exponent === 0 ? fraction * 2 ** -24
      : exponent === 31 ? (fraction ? NaN : Infinity)
      : (1 + fraction / 1024) * 2 ** (exponent - 15));
  }

  async function unpack(text) {
    const coded = atob(text), packed = new Uint8Array(coded.length);
    for (let i = 0; i < packed.length; i++) packed[i] = coded.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const plain = new Uint8Array(await new Response(stream).arrayBuffer());
    for (let i = 1; i < plain.length; i++) plain[i] += plain[i - 1];
    const halves = new Uint16Array(plain.length / 2);
    for (let i = 0; i < halves.length; i++) halves[i] = plain[i] << 8 | plain[i + halves.length];
    return halves;
  }

  // The halves of a name: all of red, then of green, then of blue; or of a map. Null where there are none.
  function load(name) {
    if (!name) return Promise.resolve(null);
    const known = asked.get(name);
    if (known) { asked.delete(name); asked.set(name, known); return known.promise; }
    const entry = { size: 0 };
    entry.promise = new Promise(function (resolve) {
      entry.take = (text) => unpack(text).then(function (halves) {
        entry.size = halves.byteLength;
        bytes += entry.size;
        forget(name);
        resolve(halves);
      }, () => resolve(null));
      const inside = document.getElementById("pixels-" + name);
      if (inside) { entry.take(inside.textContent); return; }
      const script = document.createElement("script");
      script.src = "figures/viewer/" + encodeURIComponent(name) + ".js";
      script.onload = () => script.remove();
      script.onerror = () => resolve(null);
      document.head.append(script);
    });
    asked.set(name, entry);
    return entry.promise;
  }

  // What was not used for longest goes when there is too much.
  function forget(kept) {
    for (const [name, entry] of asked) {
      if (bytes <= LIMIT) return;
      if (name !== kept && entry.size) { bytes -= entry.size; asked.delete(name); }
    }
  }

  function put(name, text) {
    const entry = asked.get(name);
    if (entry) entry.take(text);
  }

  return { load, put, values };
})();
