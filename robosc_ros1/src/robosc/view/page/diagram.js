// The diagram of a component.
"use strict";

const pen = document.createElement("canvas").getContext("2d");

function widthOf(text, font) {
  const family = getComputedStyle(document.body).fontFamily;
  pen.font = `${font} ${family}`;
  return pen.measureText(text).width;
}

/** The lines that stand at a transition: its event, then what it depends on and what it does. */
function linesOf(transition) {
  const text = transition.delay ? `after ${transition.delay}` : eventAtArrow(transition.event);
  const lines = [{ text, transition }];
  if (transition.guard) lines.push({ text: `if ${shorten(transition.guard, 30)}`, more: true });
  for (const assignment of transition.assignments.slice(0, 3)) {
    lines.push({ text: shorten(assignment, 34), more: true });
  }
  if (transition.assignments.length > 3) lines.push({ text: "…", more: true });
  return lines;
}

const LINE = 14;
const WIDE = 360; // pixels that a card has for sure, but for phones
const SMALLEST = 0.75; // of their size, to which diagrams shrink before they have to be scrolled

function sizeOf(transitions) {
  const lines = transitions.flatMap(linesOf);
  const widths = lines.map((l) => widthOf(l.text, l.more ? "italic 11px" : "600 11px"));
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
    this.alike = new Map(); // a transition to those that are drawn as one with it
    this.element = this.build();
  }

  build() {
    const nodes = this.nodes();
    const links = this.links();
    const level = new Level(nodes, links);
    const { size } = level;
    this.isWide = size.width > WIDE;
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
    for (const box of level.boxes) picture.append(this.drawBox(box));
    for (const link of links) picture.append(this.drawLink(link, name));
    for (const node of nodes) picture.append(...this.drawNode(node, name));
    return picture;
  }

  nodes() {
    const { states, transitions, room = "" } = this.component; // room for what stands behind names
    const nodes = states.map((state) => {
      const loops = transitions.filter(
        (t) => t.from === state.name && (t.to === null || t.to === state.name));
      const told = state.performs ? widthOf(`performs ${state.performs}`, "11px") : 0;
      const half = Math.max(34, Math.max(widthOf(bareName(state.name) + room, "600 12.5px"), told) / 2 + 14);
      const tall = told ? 42 : 32;
      const begins = state.initial || transitions.some((t) => t.into && t.to === state.name);
      const label = loops.length ? sizeOf(loops) : null;
      return {
        state, path: state.name, half, tall, begins, label, left: half + (begins ? 28 : 0),
        right: half + (label ? label.width + 26 : 0), height: Math.max(tall, label ? label.height : 0), loops,
      };
    });
    nodes.sort((a, b) => b.state.initial - a.state.initial);
    if (transitions.some((t) => t.from === null && t.to !== null)) {
      nodes.push({ any: true, half: 34, tall: 24, left: 34, right: 34, height: 24, loops: [] });
    }
    return nodes;
  }

  /** One that leaves a state with states in it, or enters one, is listed for each, and drawn once. */
  links() {
    const groups = new Map();
    for (const t of this.component.transitions) {
      if (t.to === null || t.from === t.to) continue;
      const leaves = t.box && !standsIn(t.into ?? t.to, t.box) && !standsIn(t.to, t.box);
      const enters = t.into && t.from !== null && !standsIn(leaves ? t.box : t.from, t.into);
      const [source, target] = [leaves ? t.box : t.from ?? "", enters ? t.into : t.to];
      const key = `${source}\n${target}\n${isOwn(t.event)}`;
      if (!groups.has(key)) groups.set(key, { source, target, own: isOwn(t.event), transitions: [] });
      const { transitions } = groups.get(key);
      const like = transitions.find((other) => leaves && other.place === t.place
        && eventName(other.event) === eventName(t.event));
      if (like) this.alike.get(like).push(t);
      else {
        transitions.push(t);
        this.alike.set(t, [t]);
      }
    }
    return [...groups.values()].map((link) => ({ ...link, ...sizeOf(link.transitions) }));
  }

  drawBox({ path, x, y, half, height }) {
    const [left, top] = [round(x - half), round(y - height / 2)];
    return draw("g", { class: "box" },
      draw("rect", { x: left, y: top, width: round(2 * half), height: round(height), rx: 12 }),
      draw("text", { x: left + 10, y: top + TITLE / 2 + 2 }, bareName(path)));
  }

  drawLink(link, tip) {
    const group = draw("g", { class: `edge ${link.own ? "controllable" : "uncontrollable"}` });
    const d = wayOf(link);
    group.append(draw("path", { d, "marker-end": `url(#${tip})` }));
    const flash = draw("path", { d, class: "flash" });
    const x = link.label.x;
    group.append(flash, this.drawWords(link.lines, x, link.label.y, "middle", flash));
    return group;
  }

  drawWords(lines, x, y, anchor, flash) {
    const words = draw("g");
    const top = y - ((lines.length - 1) * LINE) / 2;
    lines.forEach(({ text, transition }, i) => {
      const line = draw("text", {
        class: "words", x: round(x), y: round(top + i * LINE), "text-anchor": anchor, "dominant-baseline": "central",
      }, transition ? text : draw("tspan", { class: "more" }, text));
      words.append(line);
      if (!transition) return;
      line.append(draw("title", {}, wholeText(transition)));
      for (const one of this.alike.get(transition) ?? [transition]) this.remember(one, line, flash);
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
    const [x, y, h] = [node.x - node.half, node.y, node.tall];
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
    const { name, performs } = node.state;
    group.append(draw("text", { x: round(node.x), y: round(performs ? y - 7 : y) }, bareName(name)));
    if (performs) {
      group.append(draw("text", { class: "performs", x: round(node.x), y: round(y + 9) }, `performs ${performs}`));
    }
    if (name !== bareName(name)) group.append(draw("title", {}, name));
    this.states.set(node.state.name, group);
    const drawn = [group];
    if (node.loops.length) drawn.unshift(this.drawLoop(node, tip));
    if (node.begins) {
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
    if (this.active === null) return;
    toggle(this.states.get(state), "active", true);
    if (this.isWide) this.bringIntoSight(this.states.get(state));
  }

  /** Diagrams that are wider than their card are scrolled; nothing else on the page is. */
  bringIntoSight(group) {
    const pane = this.element.parentElement;
    if (!pane || pane.scrollWidth <= pane.clientWidth) return;
    const [outside, inside] = [pane.getBoundingClientRect(), group.getBoundingClientRect()];
    if (inside.left >= outside.left && inside.right <= outside.right) return;
    pane.scrollLeft += (inside.left + inside.right - outside.left - outside.right) / 2;
  }

  /**
   * The parts of the transition that an event took in a state, and where it led. Where guards
   * decide, the state that is known to follow decides; `after` is that state, if known.
   */
  taken(event, state, after) {
    const all = this.parts.get(eventName(event)) ?? [];
    const path = isStep(event) && typeof event.value === "string" ? event.value.split("->") : null;
    let found = all.filter((p) => p.transition.from === state);
    if (!found.length) found = all.filter((p) => p.transition.from === null);
    if (path) found = found.filter((p) => (p.transition.to ?? state) === path.at(-1));
    const sure = found.find((p) => p.transition.guard === null);
    const fits = found.find((p) => after === undefined || (p.transition.to ?? state) === after);
    return path ? found[0] : sure && found.length === 1 ? sure : fits;
  }
}

function wholeText(t) {
  const parts = [t.delay ? `after ${t.delay}` : eventAtArrow(t.event)];
  if (t.guard) parts.push(`if ${t.guard}`);
  if (t.assignments.length) parts.push(`do ${t.assignments.join(", ")}`);
  return `${parts.join("\n")}\n${t.place}`;
}
