// Panels whose size is changed by dragging what lies between them, or by the arrow keys.
"use strict";

const STEP = 24; // pixels for a key

/** By the name of a custom property of the style: the size in pixels that it has got. */
const sizes = new Map();

function resize(name, pixels) {
  const most = name === "side" ? innerWidth * 0.7 : innerHeight * 0.7;
  const size = Math.round(Math.max(120, Math.min(most, pixels)));
  sizes.set(name, size);
  document.documentElement.style.setProperty(`--${name}`, `${size}px`);
  byId(`split-${name}`).setAttribute("aria-valuenow", size);
  remember();
  schedule();
}

/** A bar between panels; the panel behind it has the size. */
function makeSplit(name, panel, along, keys) {
  const bar = byId(`split-${name}`);
  const sizeNow = () => panel.getBoundingClientRect()[along === "x" ? "width" : "height"];
  let from = null;
  bar.addEventListener("pointerdown", (event) => {
    from = { at: event[along], size: sizeNow() };
    bar.setPointerCapture(event.pointerId);
    event.preventDefault();
    bar.focus();
  });
  bar.addEventListener("pointermove", (event) => from && resize(name, from.size + from.at - event[along]));
  for (const end of ["pointerup", "pointercancel"]) bar.addEventListener(end, () => (from = null));
  bar.addEventListener("keydown", (event) => {
    const by = keys.indexOf(event.key);
    if (by < 0) return;
    resize(name, sizeNow() + (by ? -STEP : STEP));
    event.preventDefault();
    event.stopPropagation();
  });
}

makeSplit("side", document.querySelector(".side"), "x", ["ArrowLeft", "ArrowRight"]);
makeSplit("below", byId("timeline"), "y", ["ArrowUp", "ArrowDown"]);
