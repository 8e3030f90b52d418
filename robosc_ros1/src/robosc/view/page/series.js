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
    this.varies = values.some((value) => value !== values[0]);
  }

  add(time, value) {
    this.varies ||= this.values.length > 0 && value !== this.values.at(-1);
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
    Object.assign(this, { name, component, visible: true, chart: null });
    this.thresholds = [...(own(page.thresholds, name) ?? [])].sort((a, b) => a - b);
    this.element = make("div", { className: "plot" });
    inSight.observe(this.element);
    plotOf.set(this.element, this);
  }

  draw(now) {
    const spans = past.all.get(this.name)?.spans(now - PLOTTED, now) ?? [];
    const times = spans.map(([from]) => from);
    const values = spans.map(([, , value]) => (Number.isFinite(value) ? value : null));
    if (spans.length) {
      times.push(spans.at(-1)[1]);
      values.push(values.at(-1));
    }
    this.now = now;
    this.chart ??= this.make();
    const width = this.element.clientWidth;
    if (width && this.chart.width !== width) this.chart.setSize({ width, height: PLOT_HEIGHT });
    this.chart.setData([times, values]);
  }

  make() {
    const in_ = (name) => () => Plot.colours[name];
    const chart = new uPlot({
      width: this.element.clientWidth || 300, height: PLOT_HEIGHT, padding: [6, 0, 4, 0],
      legend: { show: false }, cursor: { show: false }, select: { show: false },
      scales: {
        x: { time: false, range: () => [this.now - PLOTTED, this.now] },
        y: { range: (_, low, high) => this.range(low, high) },
      },
      axes: [
        { show: false },
        {
          stroke: in_("--quiet"), font: SMALL, size: 42, gap: 2, space: 18, ticks: { show: false },
          grid: { stroke: in_("--rule"), width: 1 }, values: (_, ticks) => ticks.map(valueText),
        },
      ],
      series: [{}, { stroke: in_("--accent"), width: 2, paths: uPlot.paths.stepped({ align: 1 }), points: { show: false } }],
      hooks: { drawAxes: [(u) => this.drawStates(u)], draw: [(u) => this.drawThresholds(u)] },
    }, [[], []], this.element);
    const { canvas } = chart.ctx;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${this.name} in the last minute`);
    canvas.dataset.plot = this.name;
    return chart;
  }

  range(low, high) {
    const levels = [low, high, ...this.thresholds].filter(Number.isFinite);
    const [least, most] = [Math.min(...levels, Infinity), Math.max(...levels, -Infinity)];
    if (least > most) return [0, 1];
    const room = (most - least) * 0.08 || 1;
    return [least - room, most + room];
  }

  /** Where the component changed its state, and what that was. */
  drawStates({ ctx, bbox, valToPos }) {
    ctx.font = `${10 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    for (const [from, to, state] of past.all.get(this.component)?.spans(this.now - PLOTTED, this.now) ?? []) {
      const [x, end] = [from, to].map((time) => valToPos(time, "x", true));
      ctx.fillStyle = Plot.colours["--rule"];
      ctx.fillRect(x, bbox.top, 1, bbox.height);
      ctx.fillStyle = Plot.colours["--quiet"];
      if (end - x > 24) ctx.fillText(fit(ctx, String(state), end - x - 4), x + 3, bbox.top + 9 * devicePixelRatio);
    }
  }

  drawThresholds({ ctx, bbox, valToPos }) {
    ctx.strokeStyle = ctx.fillStyle = Plot.colours["--wait"];
    ctx.lineWidth = devicePixelRatio;
    ctx.textAlign = "right";
    let above = Infinity; // one text does not cover another
    for (const threshold of this.thresholds) {
      const y = Math.round(valToPos(threshold, "y", true)) + 0.5;
      ctx.setLineDash([4, 3]);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      ctx.setLineDash([]);
      if (above - y < 11 * devicePixelRatio) continue;
      above = y;
      ctx.fillText(valueText(threshold), bbox.left + bbox.width - 2, y - 2);
    }
  }
}

const PLOT_HEIGHT = 64; // pixels
const plotOf = new WeakMap();
/** Only plots that can be seen are drawn. */
const inSight = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) plotOf.get(target).visible = isIntersecting;
});

/** A number has its plot as soon as it has changed: one that never does tells nothing. */
function drawPlots(now, colours) {
  Plot.colours = colours;
  for (const element of document.querySelectorAll(".plot")) {
    const plot = plotOf.get(element);
    if (!past.all.get(plot.name)?.varies) continue;
    plot.rows.forEach((row) => (row.hidden = false));
    if (plot.visible) plot.draw(now);
  }
}

const COMPARE = {
  "=": (a, b) => a === b, "!=": (a, b) => a !== b, "<": (a, b) => a < b,
  "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b,
};

/** What the model knows of a number: between which constants it is that it is compared with, else its class. */
function classOf(variable, value) {
  if (!variable.classes || typeof value !== "number") return "";
  const outcomes = variable.comparisons.map(([operator, constant]) => COMPARE[operator](value, constant));
  let [low, high] = [-Infinity, Infinity];
  variable.comparisons.forEach(([operator, constant], i) => {
    if (operator.includes("<") === outcomes[i]) high = Math.min(high, constant);
    else low = Math.max(low, constant);
  });
  const isRange = variable.comparisons.every(([operator]) => /[<>]/.test(operator));
  if (isRange && low > -Infinity && high < Infinity) return `${valueText(low)} … ${valueText(high)}`;
  const end = Math.abs(high) < Infinity ? high : low;
  const strict = variable.comparisons.some(([operator, constant]) => constant === end && (end === high ? /^(<|>=)$/ : /^(>|<=)$/).test(operator));
  if (isRange && Number.isFinite(value) && Number.isFinite(end)) return `${end === high ? "<" : ">"}${strict ? "" : "="} ${valueText(end)}`;
  return own(variable.classes, outcomes.map(Number).join("")) ?? "";
}
