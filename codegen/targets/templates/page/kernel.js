/* What the page was written with: the study, and its functions in WebAssembly or JavaScript. */

/** What a script of the page holds, unpacked. */
async function unpacked(id) {
  const bytes = Uint8Array.from(atob(byId(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

const text = (bytes) => new TextDecoder().decode(bytes);

/** The study, its functions `f`, the array `m` that they read and write, and the places in it. */
async function loaded() {
  const study = JSON.parse(text(await unpacked("study")));
  const kernel = await unpacked("kernel");
  if (byId("kernel").dataset.language === "javascript") {
    // no place is 0
    const places = placesOf(study, 1);
    const m = new Float64Array(places.end);
    return { study, places, m, f: new Function("m", text(kernel))(m) };
  }
  const { instance } = await WebAssembly.instantiate(kernel, { env: Math });
  const { memory, __heap_base: begin } = instance.exports;
  const places = placesOf(study, Math.ceil(begin.value / Float64Array.BYTES_PER_ELEMENT));
  const missing = places.end * Float64Array.BYTES_PER_ELEMENT - memory.buffer.byteLength;
  // in pages of 64 KiB
  memory.grow(Math.max(0, Math.ceil(missing / 65536)));
  return { study, places, m: new Float64Array(memory.buffer), f: instance.exports };
}
