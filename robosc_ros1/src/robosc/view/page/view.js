// The page of `robosc view`. Whatever the source, it follows the documents of a running controller
// (docs/schemas). What arrives is gathered, and drawn once per frame of the screen.
"use strict";

const byId = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";
const KEPT = 400; // events in memory
const SHOWN = 120; // events in the list
const MANY = 8; // components that are too many to see all at once
const LONGEST = 300; // characters of a value
const MINUTE = 60;
const PACE = 100; // milliseconds between two changes of what is read, not watched
const BROKEN = 7000; // milliseconds of silence; the server says something every two seconds
const calm = matchMedia("(prefers-reduced-motion: reduce)");

function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** Only what changes is written, so that the browser lays out no more than that. */
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function toggle(element, name, on) {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}

/** JSON, with integers beyond the doubles as they were written, where the browser can tell. */
function read(text) {
  return JSON.parse(text, (_, value, context) =>
    Number.isInteger(value) && !Number.isSafeInteger(value) ? (context?.source ?? value) : value);
}

function valueText(value) {
  if (value === null || value === undefined) return "";
  if (Array.isArray(value)) return `[${value.map(valueText).join(", ")}]`;
  if (typeof value === "object") {
    return `{${Object.entries(value).map(([k, v]) => `${k}: ${valueText(v)}`).join(", ")}}`;
  }
  if (typeof value === "number" && !Number.isInteger(value)) {
    return String(Math.abs(value) < 1e5 ? +value.toPrecision(6) : +value.toFixed(1));
  }
  return String(value);
}

const eventName = (event) =>
  event.kind === "tau" ? `${event.name}.tau${event.index ?? ""}`
  : event.name ? `${event.name}.${event.kind}` : event.kind;
const isOwn = (event) => ["request", "cancel", "tau"].includes(event.kind);
/** A component may be called `constructor`. */
const own = (object, name) => (Object.hasOwn(object, name) ? object[name] : undefined);
const shorten = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

// --- where the parts of an automaton lie ---------------------------------------------------------

/**
 * Places for a row of boxes as near as possible to where they want to be, in their order and
 * without overlap: the least sum of squares, by pooling adjacent violators.
 */
function settle(boxes, wished, gap) {
  const offsets = [0];
  for (let i = 1; i < boxes.length; i++) {
    offsets.push(offsets[i - 1] + boxes[i - 1].right + gap + boxes[i].left);
  }
  const pools = [];
  boxes.forEach((_, i) => {
    let pool = { sum: wished[i] - offsets[i], count: 1 };
    while (pools.length && pools.at(-1).sum / pools.at(-1).count > pool.sum / pool.count) {
      const before = pools.pop();
      pool = { sum: pool.sum + before.sum, count: pool.count + before.count };
    }
    pools.push(pool);
  });
  const places = [];
  for (const pool of pools) {
    for (let i = 0; i < pool.count; i++) {
      places.push(pool.sum / pool.count + offsets[places.length]);
    }
  }
  return places;
}

/** Nodes in the order in which they are met from the first one. */
function breadthFirst(nodes, links) {
  const order = [];
  const met = new Set();
  for (const start of nodes) {
    const queue = met.has(start) ? [] : [start];
    met.add(start);
    while (queue.length) {
      const node = queue.shift();
      order.push(node);
      for (const link of links) {
        if (link.from === node && !met.has(link.to)) {
          met.add(link.to);
          queue.push(link.to);
        }
      }
    }
  }
  return order;
}

/** Layers by the longest way from above; each link leads over one layer for its label at least. */
function giveRanks(order, links) {
  order.forEach((node, i) => Object.assign(node, { turn: i, rank: 0 }));
  for (const link of links) {
    link.back = link.from.turn > link.to.turn;
    [link.upper, link.lower] = link.back ? [link.to, link.from] : [link.from, link.to];
  }
  for (const node of order) {
    for (const link of links) {
      if (link.upper === node) link.lower.rank = Math.max(link.lower.rank, node.rank + 2);
    }
  }
  for (const node of order.slice(1).reverse()) {
    const below = links.filter((l) => l.upper === node).map((l) => l.lower.rank);
    const above = links.some((l) => l.lower === node);
    if (!above && below.length) node.rank = Math.max(0, Math.min(...below) - 2);
  }
}

/** Rows of boxes: nodes, labels, and bends where a link passes a layer. */
function makeRows(order, links) {
  const rows = [];
  const put = (box, rank) => (rows[rank] ??= []).push(Object.assign(box, { rank }));
  for (const node of order) put(node, node.rank);
  for (const link of links) {
    link.way = [];
    const labelled = link.back ? link.lower.rank - 1 : link.upper.rank + 1;
    for (let rank = link.upper.rank + 1; rank < link.lower.rank; rank++) {
      const half = rank === labelled ? link.width / 2 : 3;
      const bend = { left: half, right: half, height: rank === labelled ? link.height : 0, bend: true };
      if (rank === labelled) link.label = bend;
      put(bend, rank);
      link.way.push(bend);
    }
  }
  const boxes = Array.from(rows, (row) => row ?? []);
  for (const row of boxes) for (const box of row) Object.assign(box, { up: [], down: [] });
  for (const link of links) {
    const chain = [link.upper, ...link.way, link.lower];
    for (let i = 1; i < chain.length; i++) {
      chain[i - 1].down.push(chain[i]);
      chain[i].up.push(chain[i - 1]);
    }
  }
  return boxes;
}

function crossings(rows) {
  let count = 0;
  for (const row of rows) {
    const ends = row.flatMap((box, i) => box.down.map((below) => [i, below.place]));
    for (let a = 0; a < ends.length; a++) {
      for (let b = a + 1; b < ends.length; b++) {
        if ((ends[a][0] - ends[b][0]) * (ends[a][1] - ends[b][1]) < 0) count++;
      }
    }
  }
  return count;
}

/** Order each row by the mean place of its neighbours, downwards and upwards; keep the best. */
function untangle(rows) {
  const number = () => rows.forEach((row) => row.forEach((box, i) => (box.place = i)));
  const mean = (list, other) => (list.length ? list.reduce((s, b) => s + b.place, 0) / list.length : other);
  number();
  let best = { count: crossings(rows), rows: rows.map((row) => [...row]) };
  for (let sweep = 0; sweep < 10 && best.count; sweep++) {
    const side = sweep % 2 ? "down" : "up";
    for (const row of sweep % 2 ? [...rows].reverse() : rows) {
      for (const box of row) box.wish = mean(box[side], box.place);
      row.sort((a, b) => a.wish - b.wish);
      row.forEach((box, i) => (box.place = i));
    }
    const count = crossings(rows);
    if (count < best.count) best = { count, rows: rows.map((row) => [...row]) };
  }
  rows.forEach((row, i) => row.splice(0, row.length, ...best.rows[i]));
  number();
}

/** Columns: each row is drawn to its neighbours, again and again. */
function giveColumns(rows) {
  for (const row of rows) {
    const places = settle(row, row.map(() => 0), 16);
    row.forEach((box, i) => (box.x = places[i]));
  }
  for (let sweep = 0; sweep < 24; sweep++) {
    for (const row of sweep % 2 ? [...rows].reverse() : rows) {
      const wished = row.map((box) => {
        const near = sweep < 20 ? (sweep % 2 ? box.down : box.up) : [...box.up, ...box.down];
        return near.length ? near.reduce((s, b) => s + b.x, 0) / near.length : box.x;
      });
      const places = settle(row, wished, 16);
      row.forEach((box, i) => (box.x = places[i]));
    }
  }
}

/** Where links touch a node's upper or lower side: below their next bend, in its order. */
function ports(node, links, side) {
  const ends = links
    .map((link) => {
      if (side === "down" && link.upper === node) return { link, next: link.way[0] };
      if (side === "up" && link.lower === node) return { link, next: link.way.at(-1) };
      return null;
    })
    .filter(Boolean)
    .sort((a, b) => a.next.x - b.next.x);
  const reach = Math.max(0, node.half - 10);
  const near = (x) => Math.min(node.x + reach, Math.max(node.x - reach, x));
  const dots = ends.map(() => ({ left: 0, right: 0 }));
  const gap = Math.min(14, (2 * reach) / Math.max(1, ends.length - 1));
  settle(dots, ends.map((end) => near(end.next.x)), gap).forEach((x, i) => {
    ends[i].link[side === "down" ? "leaves" : "enters"] = near(x);
  });
}

/**
 * A layered drawing after Sugiyama, Tagawa and Toda (1981): `nodes` have `left`, `right`, `height`
 * and `half` (of the box itself); `links` join two of them and have the `width` and `height` of
 * their labels. All get their places; the result is the size of the whole.
 */
function layOut(nodes, links) {
  const order = breadthFirst(nodes, links);
  giveRanks(order, links);
  const rows = makeRows(order, links);
  untangle(rows);
  giveColumns(rows);
  let y = 12;
  for (const row of rows) {
    const height = Math.max(4, ...row.map((box) => box.height));
    for (const box of row) box.y = y + height / 2;
    y += height + 11;
  }
  const boxes = rows.flat();
  const shift = 14 - Math.min(...boxes.map((box) => box.x - box.left));
  for (const box of boxes) box.x += shift;
  for (const node of nodes) for (const side of ["up", "down"]) ports(node, links, side);
  return { width: Math.max(...boxes.map((box) => box.x + box.right)) + 14, height: y };
}

/** A curve through the bends, upright at ends and labels, in the direction of the arrow. */
function pathOf(link) {
  const points = [[link.leaves, link.upper.y + link.upper.height / 2]];
  for (const bend of link.way) {
    if (bend.height) points.push([bend.x, bend.y - bend.height / 2], [bend.x, bend.y + bend.height / 2]);
    else points.push([bend.x, bend.y, "free"]);
  }
  points.push([link.enters, link.lower.y - link.lower.height / 2]);
  if (link.back) points.reverse();
  const slopes = points.map(([, , free], i) =>
    free ? (points[i + 1][0] - points[i - 1][0]) / (points[i + 1][1] - points[i - 1][1]) : 0);
  let text = `M${round(points[0][0])},${round(points[0][1])}`;
  for (let i = 1; i < points.length; i++) {
    const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
    const half = (y1 - y0) / 2;
    text += `C${round(x0 + slopes[i - 1] * half)},${round(y0 + half)} ` +
      `${round(x1 - slopes[i] * half)},${round(y1 - half)} ${round(x1)},${round(y1)}`;
  }
  return text;
}

const round = (x) => Math.round(x * 10) / 10;

// --- the diagram of a component ------------------------------------------------------------------

const pen = document.createElement("canvas").getContext("2d");

function widthOf(text, font) {
  const family = getComputedStyle(document.body).fontFamily;
  pen.font = `${font} ${family}`;
  return pen.measureText(text).width;
}

/** The lines that stand at a transition: its event, then what it depends on and what it does. */
function linesOf(transition) {
  const lines = [{ text: eventName(transition.event), transition }];
  if (transition.guard) lines.push({ text: `if ${shorten(transition.guard, 30)}`, more: true });
  for (const assignment of transition.assignments.slice(0, 3)) {
    lines.push({ text: shorten(assignment, 34), more: true });
  }
  if (transition.assignments.length > 3) lines.push({ text: "…", more: true });
  return lines;
}

const LINE = 14;
const SMALLEST = 0.75; // of their size, to which diagrams shrink before they have to be scrolled

function sizeOf(transitions) {
  const lines = transitions.flatMap(linesOf);
  const widths = lines.map((l) => widthOf(l.text, l.more ? "italic 11px" : "11px"));
  return { lines, width: Math.max(...widths) + 10, height: lines.length * LINE + 2 };
}

class Diagram {
  constructor(component, number, fire) {
    this.component = component;
    this.number = number;
    this.states = new Map();
    this.parts = new Map(); // event to its transitions, with what shows them
    this.active = null;
    this.fire = fire;
    this.words = [];
    this.element = this.build();
  }

  build() {
    const nodes = this.nodes();
    const links = this.links(nodes);
    const size = layOut(nodes, links);
    const name = `tip-${this.number}`;
    const tip = draw("marker", {
      id: name, viewBox: "0 0 10 10", refX: 9, refY: 5, markerWidth: 8, markerHeight: 8, orient: "auto",
      markerUnits: "userSpaceOnUse",
    }, draw("path", { d: "M0 1L10 5L0 9z" }));
    const picture = draw("svg", {
      viewBox: `0 0 ${round(size.width)} ${round(size.height)}`, width: round(size.width),
      height: round(size.height), role: "group",
      "aria-label": `Automaton of ${this.component.name}`,
    }, draw("defs", {}, tip));
    picture.style.minWidth = `${round(size.width * SMALLEST)}px`;
    for (const link of links) picture.append(this.drawLink(link, name));
    for (const node of nodes) picture.append(...this.drawNode(node, name));
    return picture;
  }

  nodes() {
    const { states, transitions } = this.component;
    const nodes = states.map((state) => {
      const loops = transitions.filter(
        (t) => t.from === state.name && (t.to === null || t.to === state.name));
      const half = Math.max(34, widthOf(state.name, "600 12.5px") / 2 + 14);
      const label = loops.length ? sizeOf(loops) : null;
      return {
        state, half, label, left: half + (state.initial ? 28 : 0), right: half + (label ? label.width + 26 : 0),
        height: Math.max(32, label ? label.height : 0), loops,
      };
    });
    nodes.sort((a, b) => b.state.initial - a.state.initial);
    if (transitions.some((t) => t.from === null && t.to !== null)) {
      nodes.push({ any: true, half: 34, left: 34, right: 34, height: 24, loops: [] });
    }
    return nodes;
  }

  links(nodes) {
    const groups = new Map();
    for (const t of this.component.transitions) {
      if (t.to === null || t.from === t.to) continue;
      const key = `${t.from}\n${t.to}\n${isOwn(t.event)}`;
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(t);
    }
    return [...groups.values()].map((transitions) => {
      const [{ from, to, event }] = transitions;
      return {
        from: nodes.find((n) => (from === null ? n.any : n.state?.name === from)),
        to: nodes.find((n) => n.state?.name === to),
        own: isOwn(event), transitions, ...sizeOf(transitions),
      };
    });
  }

  drawLink(link, tip) {
    const group = draw("g", { class: `edge ${link.own ? "controllable" : "uncontrollable"}` });
    const d = pathOf(link);
    group.append(draw("path", { d, "marker-end": `url(#${tip})` }));
    const flash = draw("path", { d, class: "flash" });
    const x = link.label.x;
    group.append(flash, this.drawWords(link.lines, x, link.label.y, "middle", flash));
    return group;
  }

  drawWords(lines, x, y, anchor, flash) {
    const words = draw("g");
    const top = y - ((lines.length - 1) * LINE) / 2;
    let text = null;
    lines.forEach((line, i) => {
      const at = { x: round(x), y: round(top + i * LINE), "text-anchor": anchor, "dominant-baseline": "central" };
      if (line.transition) {
        text = draw("text", { class: "words", ...at }, line.text);
        text.append(draw("title", {}, wholeText(line.transition)));
        this.remember(line.transition, text, flash);
      } else {
        text = draw("text", { class: "words", ...at }, draw("tspan", { class: "more" }, line.text));
      }
      words.append(text);
    });
    return words;
  }

  remember(transition, words, flash) {
    const key = eventName(transition.event);
    if (!this.parts.has(key)) this.parts.set(key, []);
    this.parts.get(key).push({ transition, words, flash });
    this.words.push({ key, words });
    const fire = () => words.classList.contains("able") && this.fire(key);
    words.addEventListener("click", fire);
    words.addEventListener("keydown", (event) => {
      if (event.key === "Enter") fire();
    });
  }

  drawNode(node, tip) {
    const [x, y, h] = [node.x - node.half, node.y, node.any ? 24 : 32];
    const box = { x: round(x), y: round(y - h / 2), width: round(2 * node.half), height: h, rx: 9 };
    if (node.any) {
      return [draw("g", { class: "any" }, draw("rect", box),
        draw("text", { x: round(node.x), y: round(y) }, "any state"))];
    }
    const group = draw("g", { class: "state" }, draw("rect", box));
    if (node.state.marked) {
      group.append(draw("rect", {
        class: "inner", x: round(x + 3), y: round(y - h / 2 + 3), width: round(2 * node.half - 6),
        height: h - 6, rx: 6,
      }));
    }
    group.append(draw("text", { x: round(node.x), y: round(y) }, node.state.name));
    this.states.set(node.state.name, group);
    const drawn = [group];
    if (node.loops.length) drawn.unshift(this.drawLoop(node, tip));
    if (node.state.initial) {
      drawn.push(draw("circle", { class: "start", cx: round(x - 24), cy: round(y), r: 3.5 }),
        draw("path", { class: "start", d: `M${round(x - 24)} ${round(y)}h24`, "marker-end": `url(#${tip})` }));
    }
    return drawn;
  }

  drawLoop(node, tip) {
    const x = node.x + node.half;
    const own = node.loops.every((t) => isOwn(t.event));
    const d = `M${round(x)} ${round(node.y - 7)}c26 -8 26 22 0 14`;
    const flash = draw("path", { d, class: "flash" });
    return draw("g", { class: `edge ${own ? "controllable" : "uncontrollable"}` },
      draw("path", { d, "marker-end": `url(#${tip})` }), flash,
      this.drawWords(node.label.lines, x + 25, node.y, "start", flash));
  }

  show(state) {
    if (state === this.active) return;
    if (this.active !== null) toggle(this.states.get(this.active), "active", false);
    this.active = this.states.has(state) ? state : null;
    if (this.active !== null) toggle(this.states.get(state), "active", true);
  }

  /**
   * The parts of the transition that an event took in a state, and where it led. Where guards
   * decide, the state that is known to follow tells; `after` is that state, if known.
   */
  taken(event, state, after) {
    const all = this.parts.get(eventName(event)) ?? [];
    const path = event.kind === "tau" && typeof event.value === "string" ? event.value.split("->") : null;
    let found = all.filter((p) => p.transition.from === state);
    if (!found.length) found = all.filter((p) => p.transition.from === null);
    if (path) found = found.filter((p) => (p.transition.to ?? state) === path.at(-1));
    const sure = found.find((p) => p.transition.guard === null);
    const fits = found.find((p) => after === undefined || (p.transition.to ?? state) === after);
    return path ? found[0] : sure && found.length === 1 ? sure : fits;
  }
}

function wholeText(t) {
  const parts = [eventName(t.event)];
  if (t.guard) parts.push(`if ${t.guard}`);
  if (t.assignments.length) parts.push(`do ${t.assignments.join(", ")}`);
  return `${parts.join("\n")}\n${t.place}`;
}

// --- cards, commands, events ---------------------------------------------------------------------

class Card {
  constructor(component, number, fire) {
    this.diagram = new Diagram(component, number, fire);
    this.now = make("span", { className: "now" });
    this.tile = make("b");
    this.link = make("a", { href: `#component-${number}` }, `${component.name} `, this.tile);
    this.values = new Map();
    const title = make("h2", {}, component.name, make("small", {}, component.place));
    this.element = make("article", { className: "card", id: `component-${number}`, tabIndex: -1 }, title, this.now,
      make("div", { className: "drawing" }, this.diagram.element));
    this.element.dataset.component = component.name;
    this.addEverywhere(component);
    this.addVariables(component);
  }

  addEverywhere(component) {
    const inAny = component.transitions.filter((t) => t.from === null && t.to === null);
    if (!inAny.length) return;
    const list = make("ul", { className: "anywhere" });
    for (const t of inAny) {
      const more = [t.guard && `if ${t.guard}`, ...t.assignments].filter(Boolean).join(", ");
      const name = make("b", {}, eventName(t.event));
      const item = make("li", { title: wholeText(t) }, "in any state ", name, more && ` ${more}`);
      this.diagram.remember(t, name, item);
      list.append(item);
    }
    this.element.append(list);
  }

  addVariables(component) {
    if (!component.variables.length) return;
    const body = make("tbody");
    for (const variable of component.variables) {
      const value = make("span");
      this.values.set(`${component.name}.${variable.name}`, value);
      const name = make("td", {}, `${variable.name} `, make("small", {}, variable.type));
      body.append(make("tr", {}, name, make("td", {}, value)));
    }
    this.element.append(make("table", { className: "variables" }, body));
  }

  show(state, variables) {
    if (state !== undefined) {
      this.diagram.show(state);
      write(this.now, `is ${state}`);
      if (this.tile.textContent !== state) {
        if (this.tile.textContent) light(this.tile);
        write(this.tile, state);
      }
      this.element.dataset.state = state;
    }
    for (const [name, cell] of this.values) {
      const text = shorten(valueText(own(variables, name)), LONGEST);
      if (cell.textContent !== text) {
        if (cell.textContent) light(cell);
        cell.textContent = text;
      }
    }
  }
}

const FLASH = [{ opacity: 1 }, { opacity: 1, offset: 0.3 }, { opacity: 0 }];

/** Who wishes for less motion gets it on, and then off. */
const fading = (duration) => (calm.matches ? { duration: 1500, easing: "steps(1)" } : { duration });

const glow = () => [{ boxShadow: `0 0 0 5px ${colourOf("--flash")}` }, { boxShadow: "0 0 0 0 transparent" }];
const colourOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

function flashPath(element) {
  if (element instanceof SVGElement) {
    element.dataset.flashed = Number(element.dataset.flashed ?? 0) + 1;
    element.animate(FLASH, fading(900));
  } else light(element);
}

function light(element) {
  const colour = `color-mix(in srgb, ${colourOf("--flash")} 60%, transparent)`;
  element.animate([{ background: colour }, { background: "transparent" }], fading(700));
}

class CommandRow {
  constructor(command) {
    this.lamp = make("span", { className: "lamp", role: "img" });
    this.tally = make("span", { className: "tally" });
    this.below = make("div", { className: "below" });
    this.sent = make("div", { className: "below sent" });
    const { name, kind } = command.event;
    this.key = eventName(command.event);
    this.element = make("li", {}, this.lamp,
      make("span", { className: "command-name" }, name, make("small", {}, ` ${kind}`)), this.tally,
      this.sent, this.below);
    this.element.dataset.command = this.key;
    this.told = "";
  }

  show(command) {
    const waits = command.blocked_by.length > 0 &&
      command.blocked_by.every((r) => r.kind === "phase" || r.kind === "consent");
    const word = command.enabled ? "enabled" : waits ? "waiting" : "forbidden";
    if (this.element.dataset.is !== word) {
      this.element.dataset.is = word;
      this.lamp.className = `lamp ${command.enabled ? "on" : waits ? "wait" : "off"}`;
      this.lamp.setAttribute("aria-label", word);
      this.lamp.title = word;
    }
    write(this.tally, command.count ? `${command.count}×` : "");
    if (!this.last && command.data) {
      write(this.sent, command.enabled ? `would send ${shorten(valueText(command.data), LONGEST)}` : "");
    }
    const told = JSON.stringify(command.blocked_by);
    if (told === this.told) return;
    this.told = told;
    this.below.replaceChildren(...command.blocked_by.map(reasonLine));
  }

  send(value) {
    this.last = true;
    write(this.sent, `sent ${shorten(valueText(value), LONGEST)}`.trimEnd());
  }

  forget() {
    this.last = false;
    write(this.sent, "");
  }
}

function reasonLine(reason) {
  const waits = reason.kind === "phase" || reason.kind === "consent";
  const line = make("div", { className: waits ? "why wait" : "why" }, reason.text);
  if (reason.place) line.append(" ", make("span", { className: "place" }, reason.place));
  return line;
}

function eventRow(document) {
  const { event, outcome, detail, time } = document;
  const text = make("span", {}, eventName(event));
  const value = shorten(valueText(event.value), LONGEST);
  if (value) text.append(" ", make("span", { className: "value" }, value));
  const more = [outcome === "applied" ? null : outcome, detail].filter(Boolean).join(": ");
  if (more) text.append(` · ${more}`);
  if (document.missed) {
    text.append(make("div", { className: "gap" }, `${document.missed} before it were not told`));
  }
  return make("li", { className: sortOf(document) }, make("time", {}, clock(time)), text);
}

function clock(seconds) {
  const date = new Date(seconds * 1000);
  const two = (n, width = 2) => String(n).padStart(width, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${two(date.getMilliseconds(), 3)}`;
}

const SORTS = [["robot", "--robot"], ["own", "--accent"], ["step", "--line"], ["bad", "--halt"]];
const searchText = ({ event, outcome }) =>
  `${eventName(event)} ${valueText(event.value)} ${outcome}`.toLowerCase();
const sortOf = ({ event, outcome }) =>
  outcome !== "applied" ? "bad" : event.kind === "tau" ? "step" : isOwn(event) ? "own" : "robot";

/** A canvas as sharp as the screen, empty; its context, width and height. */
function blank(canvas) {
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.textAlign = "left";
  return { context, width, height };
}

/** When events were, by this machine's clock: how many per second, and each on a line of its own. */
class Times {
  constructor() { this.clear(); }

  clear() {
    Object.assign(this, { seconds: new Map(), ticks: [], shown: [], latest: 0 });
  }

  count(time, sort) {
    const second = Math.floor(time);
    this.latest = Math.max(this.latest, time);
    if (!this.seconds.has(second)) this.seconds.set(second, { robot: 0, own: 0, step: 0, bad: 0 });
    this.seconds.get(second)[sort]++;
    if (this.seconds.size > 3 * MINUTE) {
      for (const old of this.seconds.keys()) if (old < this.latest - MINUTE) this.seconds.delete(old);
    }
  }

  tick(time, document) {
    const name = document.event.name || document.event.kind;
    this.ticks.push({ time, name, sort: sortOf(document), text: searchText(document) });
    if (this.ticks.length > 2 * TICKS) this.ticks.splice(0, TICKS);
  }

  /** Mean of the last whole seconds. */
  mean(now, over = 3) {
    let sum = 0;
    for (let s = Math.floor(now) - over; s < Math.floor(now); s++) {
      sum += Object.values(this.seconds.get(s) ?? {}).reduce((a, b) => a + b, 0);
    }
    return sum / over;
  }

  drawRates(canvas, now, colours) {
    const { context, width, height } = blank(canvas);
    const last = Math.floor(now);
    const seconds = Array.from({ length: MINUTE }, (_, i) => this.seconds.get(last - MINUTE + 1 + i));
    const sums = seconds.map((s) => (s ? s.robot + s.own + s.step + s.bad : 0));
    const most = Math.max(5, ...sums);
    const step = width / MINUTE;
    seconds.forEach((second, i) => {
      let y = height - 1;
      for (const [sort, name] of second ? SORTS : []) {
        const part = (second[sort] / most) * (height - 14);
        context.fillStyle = colours[name];
        context.fillRect(i * step, y - part, Math.max(1, step - 1), part);
        y -= part;
      }
    });
    context.fillStyle = colours["--quiet"];
    context.fillRect(0, height - 1, width, 1);
    context.font = SMALL;
    context.fillText(`${most}/s`, 0, 9);
    context.textAlign = "right";
    context.fillText("last minute", width, 9);
  }

  /** A lane for each communication that was heard of, if there is room; who has one keeps it. */
  drawLanes(canvas, now, colours, wanted) {
    const begin = now - WINDOW;
    const first = this.ticks.findLastIndex((t) => t.time < begin) + 1;
    const ticks = this.ticks.slice(first).filter((t) => t.text.includes(wanted));
    const names = new Set(ticks.map((t) => t.name));
    const stay = this.shown.filter((name) => names.delete(name));
    const lanes = [...stay, ...[...names].slice(0, LANES - stay.length)].sort();
    const hidden = stay.length + names.size - lanes.length;
    this.shown = lanes;
    const tall = `${(Math.max(1, lanes.length) + 1) * LANE}px`;
    if (canvas.style.height !== tall) canvas.style.height = tall;
    const { context, width } = blank(canvas);
    context.font = SMALL;
    const left = Math.min(width * 0.4, Math.max(40, ...lanes.map((n) => context.measureText(n).width)) + 8);
    const x = (time) => left + ((time - begin) / WINDOW) * (width - left - 2);
    context.fillStyle = colours["--rule"];
    lanes.forEach((_, i) => context.fillRect(left, i * LANE + LANE / 2, width - left, 1));
    const places = new Map(lanes.map((name, i) => [name, i * LANE]));
    for (const [sort, colour] of SORTS) {
      context.fillStyle = colours[colour];
      for (const tick of ticks) {
        const y = tick.sort === sort ? places.get(tick.name) : undefined;
        if (y !== undefined) context.fillRect(x(tick.time), y + 2, 2, LANE - 4);
      }
    }
    context.fillStyle = colours["--ink"];
    lanes.forEach((name, i) => context.fillText(fit(context, name, left - 6), 0, (i + 1) * LANE - 4));
    context.fillStyle = colours["--quiet"];
    const y = (lanes.length + 1) * LANE - 2;
    context.fillText(hidden ? `and ${hidden} more` : "", 0, y);
    for (const ago of [0, 5, 10, 15]) {
      context.textAlign = ago ? "center" : "right";
      context.fillText(ago ? `−${ago} s` : "now", x(now - ago), y);
    }
  }
}

const SMALL = "10px system-ui, sans-serif";
const WINDOW = 20; // seconds that lanes show
const LANES = 8;
const LANE = 15; // pixels
const TICKS = 4000;

/** A text, cut where it would be wider. */
function fit(context, text, width) {
  let most = text.length;
  while (most > 1 && context.measureText(shorten(text, most)).width > width) most--;
  return shorten(text, most);
}

// --- the whole page ------------------------------------------------------------------------------

const page = {
  hello: null, model: null, state: null, status: null,
  cards: new Map(), rows: new Map(),
  followed: new Map(), // component to the state that the events led to so far
  events: [], fresh: [], number: 0, time: 0, run: 0, later: null,
  times: new Times(),
  ahead: null, // seconds by which this machine's clock is ahead of the node's
  heard: performance.now(), // when the server said something
  shown: null, // the state that the page shows
  unlisted: [], listed: 0, // events that the list does not have yet, and when it was told last
  held: false, waiting: false, redrawList: true,
  choices: [],
};

function schedule() {
  if (page.waiting || page.held) return;
  page.waiting = true;
  requestAnimationFrame(() => {
    page.waiting = false;
    attempt(render);
  });
}

/** What comes over ROS may be anything: where the page cannot show it, it says so and goes on. */
function attempt(action) {
  try {
    action();
  } catch (fault) {
    tell("fault", `Something that was told cannot be shown (${fault}). Is it a controller made by robosc?`);
  }
}

/** Everything that a piece of the stream can hold. */
function receive(news) {
  page.heard = performance.now();
  if (news.hello) greet(news.hello);
  if (news.model) build(news.model, JSON.stringify(news.model));
  if ("run" in news) forget();
  if (news.status) page.status = news.status;
  compareClocks(news);
  for (const document of news.events ?? []) note(document);
  if (news.state) {
    page.state = news.state;
    noteLater(news.state.latest ?? []);
  }
  schedule();
}

/**
 * Events are shown by this machine's clock, which need not be the robot's: the smallest difference
 * that was seen is the one without delay, unless a clock was set.
 */
function compareClocks(news) {
  const sign = page.ahead === null ? news.state : (news.events?.at(-1) ?? news.state);
  if (!sign) return;
  const ahead = Date.now() / 1000 - sign.time;
  const fresh = page.status?.good !== false;
  if (page.ahead === null) page.ahead = fresh ? ahead : 0;
  else if (fresh && (ahead < page.ahead || ahead > page.ahead + 3)) page.ahead = ahead;
}

function place(document) {
  const time = document.time + (page.ahead ?? 0);
  page.times.count(time, sortOf(document));
  page.times.tick(time, document);
}

function note(document) {
  if (document.number <= page.number) {
    if (document.time <= page.time) return; // told twice: by itself and with the state
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
 * A state repeats the last events, for where they are not told by themselves. Where they are, they
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
    const row = page.rows.get(eventName(document.event));
    if (row && !row.last && document.outcome === "applied") row.send(document.event.value);
    place(document);
  }
}

function forget() {
  page.run++;
  Object.assign(page, { events: [], fresh: [], number: 0, time: 0, redrawList: true });
  page.followed.clear();
  page.times.clear();
  for (const row of page.rows.values()) row.forget();
}

function greet(hello) {
  page.hello = hello;
  tell("fault", "");
  write(byId("source"), hello.title);
  byId("playing").hidden = byId("to-playing").hidden = hello.source !== "model";
  byId("undo").hidden = Boolean(hello.clock);
  byId("scrub").hidden = hello.source !== "log";
  byId("freeze").hidden = hello.source === "log";
  if (hello.source === "model" && !hello.clock) write(byId("playing-title"), "What can happen");
  if (hello.source === "log") recording.begin(hello);
}

function build(model, text) {
  if (text === page.model) return; // the stream was opened again
  const drawn = model.components.filter((c) => c.states.length);
  const cards = drawn.map((component, i) => new Card(component, i, fireByName));
  const rest = model.components.filter((c) => !c.states.length).map((c) => c.name);
  const note = rest.length ? [make("p", { className: "others" }, `Without behaviour: ${rest.join(", ")}`)] : [];
  const commands = model.commands.filter((c) => c.event.kind !== "tau");
  const rows = commands.map((command) => new CommandRow(command));
  page.model = text;
  page.cards = new Map(drawn.map((component, i) => [component.name, cards[i]]));
  page.rows = new Map(rows.map((row) => [row.key, row]));
  page.followed.clear();
  // A node that begins again may be another robot's: its state comes within a second.
  if (page.state && !drawn.every((c) => own(page.state.components, c.name) !== undefined)) page.state = null;
  page.shown = null;
  document.title = `${model.robot} · robosc`;
  write(byId("robot"), model.robot);
  byId("components").replaceChildren(...cards.map((c) => c.element), ...note);
  byId("overview").hidden = cards.length < MANY;
  byId("overview").replaceChildren(...cards.map((c) => make("li", {}, c.link)));
  byId("command-list").replaceChildren(...[...page.rows.values()].map((r) => r.element));
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
  for (const { event, outcome, number } of fresh.slice(-200)) {
    if (outcome !== "applied") continue;
    if (event.kind === "request" || event.kind === "cancel") sent.set(eventName(event), event.value);
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
  for (const [key, value] of sent) {
    const row = page.rows.get(key);
    if (!row) continue;
    row.send(value);
    row.lamp.animate(glow(), fading(700));
  }
}

function showState(state) {
  // Events may be ahead of the state, which comes less often.
  if (state.number >= page.number) page.followed = new Map(Object.entries(state.components));
  for (const [name, card] of page.cards) card.show(own(state.components, name), state.variables);
  for (const command of state.commands) page.rows.get(eventName(command.event))?.show(command);
  showPhases(state.communications);
  byId("marked").hidden = !state.marked;
  if (state.choices) showChoices(state.choices, state.undo);
}

const phases = new Map();

function showPhases(communications) {
  const names = Object.keys(communications);
  if (names.length !== phases.size || names.some((name) => !phases.has(name))) {
    phases.clear();
    for (const name of names) phases.set(name, make("li"));
    byId("phases").replaceChildren(...phases.values());
    byId("calls").hidden = !names.length;
  }
  for (const [name, item] of phases) {
    const phase = communications[name];
    write(item, `${name} ${phase}`);
    toggle(item, "busy", phase === "busy");
    item.dataset.phase = phase;
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
  return page.hello?.source === "log" ? page.times.latest : Date.now() / 1000;
}

function showStatus() {
  const live = page.hello?.source !== "log";
  if (live) gauge("events/s", page.times.mean(now()).toFixed(1));
  const counters = page.state?.counters ?? {};
  for (const name of ["inputs", "commands", "errors"]) gauge(name, String(counters[name] ?? 0));
  for (const name of ["mismatches", "blocked", "failed", "undefined", "late"]) {
    const count = counters[name] ?? 0;
    if (count || gauges.has(name) || name === "mismatches") gauge(name, String(count), count > 0);
  }
  const told = page.state?.stopped;
  tell("alert", told && `Safe stop: ${told}`);
  tell("faults", page.state?.faults?.join(" · "));
  const broken = link.open === false || performance.now() - page.heard > BROKEN;
  const usual = { good: true, text: live ? "playing" : "recording" };
  if (link.open === null) return;
  const status = broken ? { good: false, text: "the server is gone", stale: true } : (page.status ?? usual);
  const pill = byId("link");
  write(pill, page.held ? "held" : status.text);
  toggle(pill, "good", status.good && !page.held);
  toggle(pill, "bad", !status.good);
  const old = Boolean(status.stale && page.state && live);
  tell("stale", old && `Out of date: ${status.text}. Everything below is how it was at ${clock(page.state.time)}.`);
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
  const list = byId("events");
  const wanted = byId("filter").value.trim().toLowerCase();
  const fits = (document) => searchText(document).includes(wanted);
  if (page.redrawList) {
    const rows = page.events.filter(fits).slice(-SHOWN).reverse().map(eventRow);
    list.replaceChildren(...rows);
    page.redrawList = false;
  } else if (fresh.length) {
    const rows = fresh.filter(fits).slice(-SHOWN).reverse().map(eventRow);
    list.prepend(...rows);
    while (list.childElementCount > SHOWN) list.lastElementChild.remove();
  }
  const style = getComputedStyle(document.documentElement);
  const names = ["--robot", "--accent", "--line", "--halt", "--quiet", "--rule", "--ink"];
  const colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(name)]));
  page.times.drawRates(byId("rates"), now(), colours);
  page.times.drawLanes(byId("lanes"), now(), colours, wanted);
}

// --- playing the model ---------------------------------------------------------------------------

let shownChoices = "";

function showChoices(choices, undo) {
  byId("undo").disabled = !undo;
  const text = JSON.stringify(choices);
  if (text === shownChoices) return;
  shownChoices = text;
  page.choices = [...choices].sort((a, b) => a.controllable - b.controllable);
  const able = new Set(choices.map((c) => eventName(c.event)));
  for (const { diagram } of page.cards.values()) {
    for (const { key, words } of diagram.words) enable(words, able.has(key));
  }
  const focused = document.activeElement?.dataset?.choice;
  const typed = new Map([...byId("choices").querySelectorAll("input")].map((i) => [i.dataset.choice, i.value]));
  byId("choices").replaceChildren(...page.choices.map((choice, i) => choiceRow(choice, i, typed)));
  if (focused) byId("choices").querySelector(`[data-choice="${CSS.escape(focused)}"]`)?.focus();
}

/** What is written at a transition fires its event, while that is possible. */
function enable(words, on) {
  if (words.classList.contains("able") === on) return;
  toggle(words, "able", on);
  for (const [name, value] of [["role", "button"], ["tabindex", "0"]]) {
    if (on) words.setAttribute(name, value);
    else words.removeAttribute(name);
  }
}

function choiceRow(choice, index, typed) {
  const button = make("button", { type: "button" }, choice.text);
  const row = make("form", { className: `choice ${choice.controllable ? "own" : "robot"}` },
    make("kbd", {}, index < 9 ? String(index + 1) : ""), button);
  button.type = "submit";
  let input = null;
  if (choice.needs) {
    input = make("input", { placeholder: choice.needs, value: typed.get(choice.text) ?? "" });
    input.setAttribute("aria-label", `Value of ${choice.text}`);
    input.dataset.choice = choice.text;
    row.append(input);
  } else button.dataset.choice = choice.text;
  row.addEventListener("submit", (event) => {
    event.preventDefault();
    play(input ? { event: choice.event, text: input.value } : { event: choice.event });
  });
  return row;
}

function fireByName(key) {
  const index = page.choices.findIndex((c) => eventName(c.event) === key);
  const several = page.choices.filter((c) => eventName(c.event) === key).length > 1;
  fireChoice(index, several);
}

/** Fire a choice, or lead to where its value is given. */
function fireChoice(index, several = false) {
  const row = byId("choices").children[index];
  if (!row) return;
  const target = row.querySelector("input") ?? row.querySelector("button");
  if (several || row.querySelector("input")) {
    row.scrollIntoView({ block: "center" });
    target.focus();
  } else row.requestSubmit();
}

async function post(path, body) {
  const answer = await fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
  });
  const document = await answer.json();
  if (!answer.ok) throw new Error(document.message);
  return document;
}

async function play(body) {
  try {
    await post("do", body);
    write(byId("refused"), "");
  } catch (fault) {
    write(byId("refused"), fault.message);
  }
}

// --- recordings ----------------------------------------------------------------------------------

const LONGEST_PAUSE = 2; // seconds without events that are played

const recording = {
  count: 0, at: 0, wanted: 0, asking: false, playing: false, times: [], sorts: "",

  async begin(hello) {
    if (this.count) return; // the stream was opened again
    this.count = hello.count;
    Object.assign(byId("moment"), { min: 1, max: hello.count, value: 1 });
    Object.assign(this, await post("overview", {}));
    this.go(1);
  },

  /** Show a moment; of those asked for while one is on its way, the last. */
  async go(at) {
    this.wanted = Math.max(1, Math.min(this.count, at));
    if (this.asking) return;
    this.asking = true;
    try {
      while (this.at !== this.wanted) {
        const next = this.wanted;
        this.show(next, await post("moment", { at: next }));
      }
    } catch (fault) {
      this.pause();
    } finally {
      this.asking = false;
    }
  },

  show(at, { state, events, lost }) {
    const steps = at - this.at;
    this.at = at;
    page.events = events;
    page.fresh = steps > 0 ? events.slice(-steps) : [];
    page.redrawList = true;
    for (const row of page.rows.values()) row.forget();
    for (const { event, outcome } of events) {
      if (outcome === "applied") page.rows.get(eventName(event))?.send(event.value);
    }
    // The transitions of what was skipped are not known to have followed one another.
    if (steps <= 0 || steps > events.length) page.followed.clear();
    page.state = state ?? page.state;
    page.status = lost ? { good: false, text: "leaves the model" } : { good: true, text: "recording" };
    tell("lost", lost && `Here the log leaves the model; the last state that is known stays. ${lost}`);
    this.placeAll(events);
    byId("moment").value = at;
    write(byId("where"), `${at} of ${this.count} · ${dayAndClock(this.times[at - 1])}`);
    schedule();
  },

  placeAll(events) {
    page.times.clear();
    const names = { x: "bad", c: "own", r: "robot" };
    const now = this.times[this.at - 1];
    for (let i = this.at - 1; i >= 0 && this.times[i] > now - MINUTE; i--) {
      page.times.count(this.times[i], names[this.sorts[i]]);
    }
    for (const document of events) {
      if (document.time <= now) page.times.tick(document.time, document);
    }
  },

  step(by) {
    this.pause();
    this.go(this.wanted + by);
  },

  toggle() {
    if (this.playing) return this.pause();
    if (this.wanted >= this.count) this.wanted = 1;
    this.playing = true;
    this.label();
    this.time = this.times[this.wanted - 1];
    let before = performance.now();
    const tick = (moment) => {
      if (!this.playing) return;
      this.time += ((moment - before) / 1000) * Number(byId("speed").value);
      before = moment;
      let at = this.wanted;
      this.time = Math.max(this.time, (this.times[at] ?? 0) - LONGEST_PAUSE);
      if (this.times[at] < this.times[at - 1]) this.time = this.times[at]; // the clock was set
      while (at < this.count && this.times[at] <= this.time) at++;
      if (at !== this.wanted) this.go(at);
      if (at >= this.count) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  },

  pause() {
    this.playing = false;
    this.label();
  },

  label() {
    byId("play").setAttribute("aria-pressed", String(this.playing));
    write(byId("play"), this.playing ? "Pause" : "Play");
  },
};

function dayAndClock(seconds) {
  return `${new Date(seconds * 1000).toLocaleDateString()} ${clock(seconds)}`;
}

// --- the link to the server, keys ----------------------------------------------------------------

const link = {
  open: null, stream: null, // open is null until the first time

  /** A browser opens few streams to one server: a page that nobody sees leaves its to others. */
  follow() {
    if (document.hidden) {
      this.stream?.close();
      this.stream = null;
      return;
    }
    if (this.stream) return;
    this.stream = new EventSource("stream");
    this.stream.onopen = () => { this.open = true; schedule(); };
    this.stream.onmessage = (message) => attempt(() => receive(read(message.data)));
    this.stream.onerror = () => { this.open = false; schedule(); };
  },
};

function hold(on) {
  page.held = on;
  byId("freeze").setAttribute("aria-pressed", String(on));
  page.redrawList = true;
  if (on) showStatus();
  else schedule();
}

function onKey(event) {
  const typing = event.target.matches("input:not([type=range]), select, textarea");
  if (typing) {
    if (event.key === "Escape") event.target.blur();
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help-box").open) return;
  const log = page.hello?.source === "log";
  const pressing = event.target.matches("button");
  if (event.key === " " && !pressing) log ? recording.toggle() : hold(!page.held);
  else if (event.key === "/") byId("filter").focus();
  else if (event.key === "?") byId("help-box").showModal();
  else if (log && event.key === "ArrowLeft") recording.step(event.shiftKey ? -100 : -1);
  else if (log && event.key === "ArrowRight") recording.step(event.shiftKey ? 100 : 1);
  else if (page.choices.length && /^[1-9]$/.test(event.key)) fireChoice(Number(event.key) - 1);
  else if (page.choices.length && event.key === "u") play({ undo: 1 });
  else if (page.choices.length && event.key === "r") play({ random: 1 });
  else return;
  event.preventDefault();
}

byId("freeze").addEventListener("click", () => hold(!page.held));
byId("help").addEventListener("click", () => byId("help-box").showModal());
byId("filter").addEventListener("input", () => { page.redrawList = true; schedule(); });
byId("undo").addEventListener("click", () => play({ undo: 1 }));
byId("random").addEventListener("click", () => play({ random: 1 }));
byId("restart").addEventListener("click", () => play({ restart: true }));
byId("play").addEventListener("click", () => recording.toggle());
byId("back").addEventListener("click", () => recording.step(-1));
byId("onward").addEventListener("click", () => recording.step(1));
byId("moment").addEventListener("input", (event) => {
  recording.pause();
  recording.go(Number(event.target.value));
});
document.addEventListener("keydown", onKey);
document.addEventListener("visibilitychange", () => link.follow());
addEventListener("resize", schedule);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", schedule);
setInterval(() => {
  if (document.hidden) return;
  if (page.held) showStatus();
  else schedule();
}, 250);
link.follow();
