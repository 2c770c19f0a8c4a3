/* Pieces of the page, and numbers in words. */

const byId = (id) => document.getElementById(id);

/** A new element with attributes and children. */
function made(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** The colour of an observer. */
const swatch = (name) =>
  made("span", { class: "swatch", style: `background: var(--of-${name})`, "aria-hidden": "true" });

/** A number with three digits. */
function short(number) {
  if (!Number.isFinite(number)) return "–";
  const size = Math.abs(number);
  const words = size !== 0 && (size < 1e-3 || size >= 1e4) ? number.toExponential(2) : Number(number.toPrecision(3));
  return String(words).replaceAll("-", "−").replace("e+", "e");
}
