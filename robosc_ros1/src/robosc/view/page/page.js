// The whole page. Whatever the source, it follows the documents of a running controller
// (docs/schemas). What arrives is gathered, and drawn once per frame of the screen.
"use strict";

const KEPT = 400; // events in memory
const SHOWN = 120; // events in the list
const PACE = 100; // milliseconds between two changes of what is read, not watched
const BROKEN = 7000; // milliseconds of silence; the server says something every two seconds

const page = {
  hello: null, model: null, communications: [], source: null, thresholds: {}, state: null, status: null,
  cards: new Map(), rows: new Map(),
  followed: new Map(), // component to the state that the events led to so far
  events: [], fresh: [], number: 0, time: 0, run: 0, later: null,
  begun: null, // when the node began that the last state is of
  times: new Times(),
  ahead: null, // seconds by which this machine's clock is ahead of the node's
  heard: performance.now(), // when the server said something
  shown: null, // the state that the page shows
  unlisted: [], listed: 0, // events that the list does not have yet, and when it was last updated
  listing: null, // what the list shows where it is not the last events: hits of a search
  held: false, waiting: false, redrawList: true,
  choices: [],
};

function schedule() {
  if (page.waiting || page.held) return;
  page.waiting = true;
  requestAnimationFrame(() => {
    page.waiting = false;
    if (!page.held) attempt("state", render); // it may have been held since
  });
}

/**
 * What comes over ROS may be anything: where the page cannot show it, it says so and goes on, until
 * the next message of that sort can be shown.
 */
function attempt(sort, action) {
  try {
    action();
    faults.delete(sort);
  } catch (fault) {
    faults.set(sort, `The last ${sort} cannot be shown (${fault}). Is it of a controller made by robosc?`);
  }
  tell("fault", [...faults.values()].join(" "));
}

const faults = new Map(); // by sort of message

/** Everything that a piece of the stream can hold. */
function receive(news) {
  page.heard = performance.now();
  if (news.hello) greet(news.hello);
  if (news.model) attempt("model", () => build(news.model, JSON.stringify(news.model)));
  if (news.operate) operating.offer(news.operate);
  if ("run" in news) forget();
  if (news.status) page.status = news.status;
  compareClocks(news);
  for (const document of news.events ?? []) attempt("event", () => note(document));
  if (news.state) {
    begin(news.state.begun);
    page.state = news.state;
    attempt("state", () => keep(news.state));
    noteLater(news.state.latest ?? []);
  }
  schedule();
}

function keep(state) {
  past.state(state, state.time + (page.ahead ?? 0));
  held.keep(state);
}

/**
 * Events are shown by this machine's clock, which need not be the robot's: the smallest difference
 * that was seen is the one without delay, unless a clock was set.
 */
function compareClocks(news) {
  const sign = news.state ?? (page.ahead === null ? null : news.events?.at(-1));
  if (!Number.isFinite(sign?.time)) return;
  const ahead = Date.now() / 1000 - sign.time;
  const fresh = page.status?.good !== false;
  if (page.ahead === null) page.ahead = fresh ? ahead : 0;
  else if (fresh && (ahead < page.ahead || ahead > page.ahead + 3)) page.ahead = ahead;
}

/**
 * A node that begins again begins anew with the numbers of events. Those of the run before are not
 * its own, whichever numbers it had reached when the page heard of it.
 */
function begin(begun) {
  if (!begun || begun === page.begun) return;
  page.begun = begun;
  const own = page.events.filter((document) => document.time >= begun);
  if (own.length === page.events.length) return;
  forget();
  own.forEach(note);
}

function place(document) {
  const time = document.time + (page.ahead ?? 0);
  past.event(document, time);
  page.times.count(time, sortOf(document));
  page.times.tick(time, document);
  hear(document, time);
}

function note(document) {
  if (!Number.isFinite(document.time) || !Number.isInteger(document.number)) throw new TypeError("no time or number");
  if (document.number <= page.number) {
    if (document.time <= page.time) return; // sent twice: by itself and with the state
    forget(); // the node has begun again
  }
  page.number = document.number;
  page.time = document.time;
  const before = page.events.at(-1)?.number;
  if (before && document.number > before + 1) document.missed = document.number - before - 1;
  page.events.push(document);
  page.fresh.push(document);
  place(document);
  if (page.events.length > 2 * KEPT) page.events.splice(0, page.events.length - KEPT);
  if (page.fresh.length > KEPT) page.fresh.splice(0, page.fresh.length - KEPT);
}

/**
 * A state repeats the last events, for where they are not sent by themselves. Where they are, they
 * may come after it: wait a little, and take from the state only what did not come.
 */
function noteLater(latest) {
  const first = page.events[0]?.number ?? Infinity;
  if (page.later || !latest.some((d) => d.number < first || d.number > page.number)) return;
  const run = page.run;
  page.later = setTimeout(() => {
    page.later = null;
    if (run === page.run) {
      putBefore(latest.filter((d) => d.number < page.events[0]?.number && d.time <= page.events[0].time));
      latest.forEach(note);
    }
    schedule();
  }, 500);
}

/** Events from before the page began to listen. */
function putBefore(documents) {
  if (!documents.length) return;
  page.events.unshift(...documents);
  page.redrawList = true;
  for (const document of documents) {
    tellRow(document, true);
    place(document);
  }
}

function forget() {
  page.run++;
  Object.assign(page, { events: [], fresh: [], number: 0, time: 0, redrawList: true });
  page.followed.clear();
  page.times.clear();
  clocks.heard.clear();
  past.clear();
  held.states = [];
  for (const row of page.rows.values()) row.forget();
}

function greet(hello) {
  page.hello = hello;
  write(byId("source"), hello.title);
  byId("playing").hidden = byId("to-playing").hidden = hello.source !== "model";
  byId("undo").hidden = Boolean(hello.clock);
  byId("scrub").hidden = hello.source !== "log";
  byId("freeze").hidden = hello.source === "log";
  byId("hits").hidden = hello.source !== "log";
  if (hello.source === "model" && !hello.clock) write(byId("playing-title"), "What can happen");
  for (const id of ["play", "speed", "goto"]) byId(id).hidden = hello.source !== "log";
  if (hello.source === "log") recording.begin(hello);
}

function build(model, text) {
  if (text === page.model) return; // the stream was opened again
  const drawn = whatMovesFirst(model.components.filter((c) => c.states.length));
  past.owners = new Map(model.communications.map((c) => [c.name, c.component]));
  page.thresholds = model.thresholds ?? {};
  zooms.clear();
  served.clear();
  for (const c of model.communications) if (c.kind === "outgoing service" || c.kind === "outgoing action") served.add(c.name);
  const cards = componentCards(drawn, fireByName);
  const rest = model.components.filter((c) => !c.states.length).map((c) => c.name);
  const note = rest.length ? [make("p", { className: "others" }, `Without behaviour: ${rest.join(", ")}`)] : [];
  const bare = new Set(model.communications.filter((c) => c.request === "none").map((c) => c.name));
  const commands = model.commands.filter((c) => c.event.kind !== "tau");
  page.source = model.source;
  page.communications = model.communications;
  operating.list();
  const rows = commandRows(commands, (command) => !bare.has(command.event.name));
  page.model = text;
  page.cards = cards.all;
  page.rows = rows.all;
  page.followed.clear();
  // A node that begins again may be another robot's: its state comes within a second.
  if (page.state && !drawn.every((c) => own(page.state.components, c.name) !== undefined)) page.state = null;
  page.shown = null;
  document.title = `${model.robot} · robosc`;
  write(byId("robot"), model.robot);
  byId("components").replaceChildren(...cards.shown.map((c) => c.element), ...note);
  const moving = cards.shown.filter((c) => c.diagram.states.size > 1);
  byId("overview").hidden = !moving.length;
  byId("overview").replaceChildren(...moving.map((c) => make("li", {}, c.link)));
  byId("command-list").replaceChildren(...rows.elements);
  restoreOpen();
}

/** Missions come first, then what has several states, then what only measures. */
function whatMovesFirst(components) {
  const rank = ({ states }) => (states.some((s) => s.performs) ? 0 : states.length > 1 ? 1 : 2);
  return [0, 1, 2].flatMap((wanted) => components.filter((c) => rank(c) === wanted));
}

function render() {
  const fresh = page.fresh;
  page.fresh = [];
  if (page.state && page.cards.size) {
    flash(fresh);
    if (page.state !== page.shown) showState(page.state);
    page.shown = page.state;
  }
  page.unlisted.push(...fresh);
  if (performance.now() - page.listed > PACE) {
    showEvents(page.unlisted.splice(0));
    showStatus();
    page.listed = performance.now();
  } else schedule();
}

/** Follow the events through the automata, and flash each transition at most once per frame. */
function flash(fresh) {
  const lit = new Set();
  const sent = new Map();
  for (const document of fresh.slice(-200)) {
    const { event, outcome, number } = document;
    if (isOwn(event) && !isStep(event)) sent.set(`${eventName(event)} ${outcome}`, document);
    if (outcome !== "applied") continue;
    for (const [name, card] of page.cards) {
      const state = page.followed.get(name) ?? own(page.state.components, name);
      const after = page.state.number >= number ? own(page.state.components, name) : undefined;
      const part = card.diagram.taken(event, state, after);
      if (!part) continue;
      lit.add(part.flash);
      page.followed.set(name, part.transition.to ?? state);
    }
  }
  lit.forEach(flashPath);
  for (const document of sent.values()) tellRow(document)?.flash();
}

function showState(state) {
  // Events may be ahead of the state, which comes less often.
  if (state.number >= page.number) page.followed = new Map(Object.entries(state.components));
  for (const [name, card] of page.cards) card.show(own(state.components, name), state.variables);
  for (const command of state.commands) page.rows.get(eventName(command.event))?.show(command);
  showPhases(state.communications);
  operating.show(state);
  byId("marked").hidden = !state.marked;
  if (state.choices && !page.held) showChoices(state.choices, state.undo);
}

const phases = new Map();

/** Communications and their phases; of copies how many are in each. */
function showPhases(communications) {
  const groups = families(Object.keys(communications), (name) => name);
  const label = (group) => (group.length > 1 ? familyName(group[0]) : group[0]);
  if (groups.length !== phases.size || groups.some((group) => !phases.has(label(group)))) {
    phases.clear();
    for (const group of groups) phases.set(label(group), make("li"));
    byId("phases").replaceChildren(...phases.values());
    byId("calls").hidden = !groups.length;
  }
  for (const group of groups) {
    const item = phases.get(label(group));
    const counts = new Map();
    for (const name of group) counts.set(communications[name], (counts.get(communications[name]) ?? 0) + 1);
    const told = [...counts].map(([phase, count]) => (group.length > 1 ? `${count} ${phase}` : phase));
    write(item, `${label(group)} ${told.sort().join(", ")}`);
    toggle(item, "busy", counts.has("busy"));
    item.dataset.phase = [...counts.keys()].sort().join(" ");
  }
}

const gauges = new Map();

function gauge(name, text, trouble = false) {
  if (!gauges.has(name)) {
    const value = make("dd");
    const whole = make("div", {}, make("dt", {}, name), value);
    gauges.set(name, { whole, value });
    byId("gauges").append(whole);
  }
  const { whole, value } = gauges.get(name);
  write(value, text);
  toggle(whole, "trouble", trouble);
  value.dataset.gauge = name;
}

function now() {
  if (held.state) return held.state.time + (page.ahead ?? 0);
  return page.hello?.source === "log" ? page.times.latest : Date.now() / 1000;
}

function showStatus() {
  if (!page.hello) return;
  const live = page.hello.source !== "log";
  if (live) gauge("events/s", page.times.mean(now()).toFixed(1));
  const counters = page.state?.counters ?? {};
  for (const name of ["inputs", "commands", "errors"]) gauge(name, String(counters[name] ?? 0));
  for (const name of ["mismatches", "blocked", "corrected", "failed", "undefined", "late", "forbidden", "violations", "undecided"]) {
    const count = counters[name] ?? 0;
    if (count || gauges.has(name) || name === "mismatches") gauge(name, String(count), count > 0);
  }
  if ("withheld" in counters) gauge("withheld", String(counters.withheld));
  const told = page.state?.stopped;
  tell("alert", told && (told.startsWith("held") ? `Commands are ${told}` : `Safe stop: ${told}`));
  tell("faults", page.state?.faults?.join(" · "));
  const broken = !exported.data && (link.open === false || performance.now() - page.heard > BROKEN);
  const usual = { good: true, text: live ? "playing" : "recording" };
  if (link.open === null) return;
  const status = broken ? { good: false, text: "the server is gone", stale: true } : (page.status ?? usual);
  const pill = byId("link");
  write(pill, page.held ? "held" : status.text);
  toggle(pill, "good", status.good && !page.held);
  toggle(pill, "bad", !status.good);
  const old = Boolean(status.stale && page.state && live);
  tell("stale", old && `No data since ${clock(page.state.time)}: ${status.text}. Everything below is as it was then.`);
  toggle(document.body, "stale", old);
  byId("empty").hidden = page.cards.size > 0 || page.rows.size > 0;
  write(byId("empty"), broken ? "" : `Nothing to show yet: ${status.text}.`);
}

/** A line across the page, as long as there is something to say. */
function tell(id, text) {
  byId(id).hidden = !text;
  write(byId(id), text || "");
}

function showEvents(fresh) {
  const log = page.hello?.source === "log";
  const wanted = byId("filter").value.trim().toLowerCase();
  toggle(document.body, "eventless", Boolean(page.hello) && !log && !page.events.length);
  listEvents(fresh, log ? "" : wanted);
  if (log && recording.at) recording.fill(page.times);
  const style = getComputedStyle(document.documentElement);
  const names = ["--robot", "--accent", "--line", "--halt", "--quiet", "--rule", "--ink", "--wait", "--card"];
  const colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(name)]));
  page.times.drawRates(byId("rates"), now(), colours);
  const hits = recording.hits?.all;
  const fits = !log ? (tick) => tick.text.includes(wanted) : hits ? (tick) => hits.has(tick.place) : () => true;
  page.times.drawLanes(byId("lanes"), now(), colours, fits);
  drawPlots(now(), colours);
}

function listEvents(fresh, wanted) {
  const list = byId("events");
  const last = held.state?.number ?? Infinity;
  const fits = (document) => document.number <= last && searchText(document).includes(wanted);
  if (page.redrawList) {
    const rows = (page.listing ?? page.events.filter(fits)).slice(-SHOWN).reverse().map(eventRow);
    list.replaceChildren(...rows);
    page.redrawList = false;
  } else if (fresh.length && !page.listing) {
    const rows = fresh.filter(fits).slice(-SHOWN).reverse().map(eventRow);
    list.prepend(...rows);
    while (list.childElementCount > SHOWN) list.lastElementChild.remove();
  }
}
