// Cards of components, rows of events.
"use strict";

/** What cards have in common: the name, a note beside it, and the diagram with its zoom. */
function cardElement({ component: { name }, number, element: picture }, note) {
  const title = make("h2", {}, name, make("small", {}, note));
  const drawing = make("div", { className: "drawing" }, picture);
  const card = make("article", { className: "card", id: `component-${number}`, tabIndex: -1 }, title,
    new Zoom(drawing, name).buttons, drawing);
  card.dataset.component = name;
  return card;
}

class Card {
  constructor(component, number, fire) {
    this.component = component;
    this.diagram = new Diagram(component, number, fire);
    this.now = make("span", { className: "now" });
    this.tile = make("b");
    this.link = make("a", { href: `#component-${number}` }, make("span", {}, `${component.name} `), this.tile);
    this.values = new Map();
    this.element = cardElement(this.diagram, component.place);
    this.element.firstElementChild.after(this.now);
    toggle(this.element, "wide", this.diagram.element.width.baseVal.value > 1.5 * WIDE);
    this.addEverywhere(component);
    this.addVariables(component);
  }

  addEverywhere(component) {
    const inAny = component.transitions.filter((t) => t.from === null && t.to === null);
    if (!inAny.length) return;
    const list = make("ul", { className: "anywhere" });
    for (const t of inAny) {
      const more = [t.guard && `if ${t.guard}`, ...t.assignments].filter(Boolean).join(", ");
      const name = make("b", {}, t.delay ? `after ${t.delay}` : eventAtArrow(t.event));
      const item = make("li", { title: wholeText(t) }, "in any state ", name, more && ` ${more}`);
      this.diagram.remember(t, name, item);
      list.append(item);
    }
    this.element.append(list);
  }

  addVariables(component) {
    this.rows = make("tbody");
    this.data = 0;
    for (const variable of component.variables) {
      const name = `${component.name}.${variable.name}`;
      const value = make("span");
      const kind = make("small", { className: "class" });
      this.values.set(name, { value, kind, variable });
      this.addRow([`${variable.name} `, make("small", {}, variable.type)], [kind, value]);
      if (isNumeric(variable.type)) this.addPlot(name, []);
    }
    this.element.append(make("table", { className: "variables" }, this.rows));
    for (const name of past.dataOf(component.name)) this.addData(name);
  }

  addRow(left, right) {
    const row = make("tr", {}, make("td", {}, ...left), make("td", {}, ...right));
    this.rows.append(row);
    return row;
  }

  /** A plot, which is hidden, and `others` of its rows with it, as long as the number does not change. */
  addPlot(name, others) {
    const plot = new Plot(name, this.component.name);
    const row = make("tr", { className: "plotted" }, make("td", { colSpan: 2 }, plot.element));
    plot.rows = [...others, row];
    plot.rows.forEach((hidden) => (hidden.hidden = true));
    this.rows.append(row);
  }

  /** A number that an event of the component carries. */
  addData(name) {
    if (this.data++ >= MOST_DATA) return;
    this.addPlot(name, [this.addRow([make("small", {}, name)], [])]);
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
    for (const [name, { value: cell, kind, variable }] of this.values) {
      const value = own(variables, name);
      const text = shorten(valueText(value), LONGEST);
      if (cell.textContent !== text) {
        if (cell.textContent) light(cell);
        cell.textContent = text;
      }
      if (typeof value === "number") cell.title = String(value);
      write(kind, classOf(variable, value).replaceAll(`${this.component.name}.`, ""));
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

function eventRow(document) {
  const { event, outcome, detail, time, place } = document;
  const text = make("span", {}, eventTitle(event));
  const value = wordsOf(document);
  if (value) text.append(" ", make("span", { className: "value" }, value));
  const more = [outcome === "applied" ? null : outcome, detail].filter(Boolean).join(": ");
  if (more) text.append(` · ${more}`);
  const correction = correctionOf(document);
  if (correction) text.append(` · ${correction}`);
  if (document.missed) {
    text.append(make("div", { className: "gap" }, `${document.missed} before it were not received`));
  }
  const row = make("li", { className: sortOf(document) }, make("time", {}, clock(time)), text);
  if (place) row.dataset.place = place;
  const left = place && recording.departureAt(place);
  if (left) {
    row.classList.add("beyond");
    if (left.at === place) text.append(make("div", { className: "left-here" }, `Event ${place} leaves the model: ${left.reason}`));
  }
  return row;
}

function clock(seconds) {
  const date = new Date(seconds * 1000);
  const two = (n, width = 2) => String(n).padStart(width, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${two(date.getMilliseconds(), 3)}`;
}
