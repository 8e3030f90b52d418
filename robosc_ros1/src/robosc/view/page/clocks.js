// How long ago watched messages came, and how long it is until their timeout and until transitions
// after a delay. Between two states the page lets the clocks run by itself.
"use strict";

const clocks = { heard: new Map(), rows: new Map() };

/** Keep when a message came; it need not be one that is watched. */
function hear({ event, outcome }, time) {
  if (event.kind === "response" && outcome === "applied") clocks.heard.set(event.name, time);
}

function showClocks() {
  const state = page.shown; // what cannot be shown is reported elsewhere
  if (!state || page.held || document.body.classList.contains("stale")) return;
  const time = now();
  const passed = Math.max(0, time - state.time - (page.ahead ?? 0));
  const left = new Map(Object.entries(state.clocks ?? {}));
  const lines = new Map();
  for (const [name, phase] of Object.entries(state.communications)) {
    if (phase !== "fresh" && phase !== "silent") continue;
    const at = clocks.heard.get(name);
    const age = at === undefined ? [] : [`heard ${seconds(time - at)} ago`];
    const until = left.has(name) ? [`silent in ${seconds(left.get(name) - passed)}`] : [];
    if (age.length || until.length) lines.set(name, [...age, ...until].join(", "));
    left.delete(name);
  }
  for (const [name, rest] of left) lines.set(name, `${seconds(rest - passed)} left`);
  writeClocks(lines);
}

function writeClocks(lines) {
  const { rows } = clocks;
  if (lines.size !== rows.size || [...lines.keys()].some((name) => !rows.has(name))) {
    rows.clear();
    for (const name of lines.keys()) rows.set(name, make("li", {}));
    byId("clocks").replaceChildren(...rows.values());
  }
  for (const [name, text] of lines) {
    const row = rows.get(name);
    row.dataset.clock = name;
    write(row, `${name}: ${text}`);
  }
}

function seconds(amount) {
  return `${Math.max(0, amount).toFixed(1)} s`;
}
