// How numbers and states went over time, and their plots beside the states.
"use strict";

const PLOTTED = MINUTE; // seconds
const MOST_DATA = 6; // numbers of the data of a component that are plotted
const isNumeric = (type) => /^(integer|double)/.test(type);

/** What something was, and when; of a recording as a whole, else of the last while. */
class Series {
  constructor(times = [], values = []) {
    this.times = times;
    this.values = values;
  }

  add(time, value) {
    this.times.push(time);
    this.values.push(value);
    const first = this.times.length > 4000 ? this.before(time - PLOTTED) : 0;
    if (first > 2000) for (const list of [this.times, this.values]) list.splice(0, first);
  }

  /** A state or a variable: only changes matter. */
  change(time, value) {
    if (this.values.at(-1) !== value) this.add(time, value);
  }

  /** The place of the last entry up to a time; -1 if there is none. */
  before(time) {
    let [low, high] = [0, this.times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  /** What it was from one time to another, as [from, to, value]. */
  spans(begin, end) {
    const found = [];
    for (let i = Math.max(0, this.before(begin)); i < this.times.length && this.times[i] <= end; i++) {
      found.push([Math.max(begin, this.times[i]), Math.min(end, this.times[i + 1] ?? end), this.values[i]]);
    }
    return found;
  }
}

const past = {
  all: new Map(), // series by component (its states), Component.variable, or event and path (its data)
  owners: new Map(), // communication to component

  of(name) {
    if (!this.all.has(name)) this.all.set(name, new Series());
    return this.all.get(name);
  },

  /** The numbers of a component's data; `owner` is set for those only. */
  dataOf(component) {
    return [...this.all].filter(([, series]) => series.owner === component).map(([name]) => name);
  },

  /** A state of a robot that is watched or played; a recording brings its own series. */
  state(state, time) {
    for (const [name, where] of Object.entries(state.components)) this.of(name).change(time, where);
    for (const [name, value] of Object.entries(state.variables)) {
      if (typeof value === "number") this.of(name).change(time, value);
    }
  },

  /** The numbers that an event carried. */
  event(document, time) {
    if (document.outcome !== "applied" || isStep(document.event)) return;
    for (const [path, value] of numbersIn(document.event.value)) {
      const name = `${eventName(document.event)}${path}`;
      const series = this.of(name);
      series.add(time, value);
      if (series.owner) continue;
      series.owner = this.owners.get(document.event.name);
      page.cards.get(series.owner)?.addData(name);
    }
  },

  clear() {
    this.all.clear();
  },
};

/** The numbers of a value with their paths; lists are too many. */
function numbersIn(value, path = "") {
  if (typeof value === "number") return [[path, value]];
  if (value === null || typeof value !== "object" || Array.isArray(value)) return [];
  return Object.entries(value).flatMap(([name, part]) => numbersIn(part, `${path} ${name}`));
}

/** One number over the last minute, with the states of its component and what it is compared with. */
class Plot {
  constructor(name, component) {
    Object.assign(this, { name, component, visible: true });
    this.thresholds = own(page.thresholds, name) ?? [];
    this.element = make("canvas", { className: "plot" });
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", `${name} in the last minute`);
    this.element.dataset.plot = name;
    inSight.observe(this.element);
    plotOf.set(this.element, this);
  }

  draw(now, colours) {
    const series = past.all.get(this.name);
    const spans = series?.spans(now - PLOTTED, now).filter(([, , value]) => Number.isFinite(value)) ?? [];
    const { context, width, height } = blank(this.element);
    const levels = [...spans.map((span) => span[2]), ...this.thresholds];
    let [low, high] = [Math.min(...levels), Math.max(...levels)];
    if (!(low < high)) [low, high] = [low - 1, high + 1];
    const x = (time) => width * (1 - (now - time) / PLOTTED);
    const y = (value) => height - 3 - ((value - low) / (high - low)) * (height - 14);
    context.font = SMALL;
    this.drawStates(context, now, x, height, colours);
    context.setLineDash([4, 3]);
    context.strokeStyle = colours["--wait"];
    context.lineWidth = 1;
    for (const threshold of this.thresholds) stroke(context, [[0, y(threshold)], [width, y(threshold)]]);
    context.setLineDash([]);
    context.strokeStyle = colours["--accent"];
    context.lineWidth = 1.5;
    stroke(context, spans.flatMap(([from, to, value]) => [[x(from), y(value)], [x(to), y(value)]]));
    context.fillStyle = colours["--wait"];
    context.textAlign = "right";
    context.strokeStyle = colours["--card"]; // what is drawn behind a text does not strike it out
    context.lineWidth = 3;
    let above = Infinity; // one text does not cover another
    const lines = [...this.thresholds].sort((a, b) => a - b);
    for (const [i, threshold] of lines.entries()) {
      // Near the top are the names of states; and between two near lines there is no room.
      const isNear = i === 0 && lines.length > 1 && y(threshold) - y(lines[1]) < 11;
      const base = y(threshold) + (isNear || y(threshold) < 20 ? 10 : -2);
      if (above - base < 9 || base > height) continue;
      above = base;
      outlined(context, valueText(threshold), width - 2, base);
    }
    context.textAlign = "left";
    context.fillStyle = colours["--quiet"];
    const ends = spans.length ? [low, high].filter((level) => !this.thresholds.includes(level)) : [];
    for (const level of ends) outlined(context, valueText(level), 0, y(level) + (level === high ? 8 : 0));
  }

  /** Where the component changed its state, and what that was. */
  drawStates(context, now, x, height, colours) {
    for (const [from, to, state] of past.all.get(this.component)?.spans(now - PLOTTED, now) ?? []) {
      context.fillStyle = colours["--rule"];
      context.fillRect(x(from), 0, 1, height);
      context.fillStyle = colours["--quiet"];
      const room = x(to) - x(from) - 4;
      if (room > 20) context.fillText(fit(context, String(state), room), x(from) + 3, 9);
    }
  }
}

function outlined(context, text, x, y) {
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

function stroke(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}

const plotOf = new WeakMap();
/** Only plots that can be seen are drawn. */
const inSight = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) plotOf.get(target).visible = isIntersecting;
});

function drawPlots(now, colours) {
  for (const canvas of document.querySelectorAll("canvas.plot")) {
    const plot = plotOf.get(canvas);
    if (plot.visible) plot.draw(now, colours);
  }
}

const COMPARE = {
  "=": (a, b) => a === b, "!=": (a, b) => a !== b, "<": (a, b) => a < b,
  "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b,
};

/** What the model knows of a number: the class that it is in. */
function classOf(variable, value) {
  if (!variable.classes || typeof value !== "number") return "";
  const outcomes = variable.comparisons.map(([operator, constant]) => Number(COMPARE[operator](value, constant)));
  return own(variable.classes, outcomes.join("")) ?? "";
}
