// What one looks at, in the page's address: a link that restores it.
"use strict";

/** What the address held when the page was opened. */
const restored = (() => {
  const given = new URLSearchParams(location.hash.slice(1));
  return {
    sizes: ["side", "below"].map((name) => [name, Number(given.get(name))]).filter(([, size]) => size),
    open: given.getAll("open"),
    zoom: new Map(given.getAll("zoom").map(zoomOf).filter(([, place]) => place.every(Number.isFinite))),
    at: Number(given.get("at")) || null,
    filter: given.get("filter") ?? "",
  };
})();

/** A component and what of its diagram is shown: `Arm,2,30.5,12` is Arm, twice as large, from there on. */
function zoomOf(text) {
  const [name, ...place] = text.split(",");
  return [name, place.length === 3 ? place.map(Number) : [NaN]]; // which is left out
}

let remembering = null;

/** Write into the address what is looked at; browsers allow it a few times per second. */
function remember() {
  remembering ??= setTimeout(() => {
    remembering = null;
    const place = new URLSearchParams();
    if (page.hello?.source === "log") place.set("at", recording.at);
    if (byId("filter").value) place.set("filter", byId("filter").value);
    for (const [name, card] of page.cards) if (card instanceof Copy && card.card) place.append("open", name);
    for (const [name, { scale, x, y }] of zooms) {
      if (scale > 1) place.append("zoom", [name, ...[scale, x, y].map((number) => number.toFixed(2))].join(","));
    }
    for (const [name, size] of sizes) place.set(name, size);
    history.replaceState(null, "", `#${place}`);
  }, 500);
}

/** What was unfolded; sizes of panels are restored at once. */
function restoreOpen() {
  for (const name of restored.open) {
    const copy = page.cards.get(name);
    if (copy instanceof Copy) copy.unfold(true);
  }
}
