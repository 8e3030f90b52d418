// When events were: how often, and on a line of time.
"use strict";

const MINUTE = 60;
const SMALL = "10px system-ui, sans-serif";
const WINDOW = 20; // seconds that lanes show
const LANES = 8;
const LANE = 15; // pixels
const RATE = 48; // pixels for how often per second
const LATELY = 5; // seconds over which that is the mean
const LATE = 0.25; // seconds that events may be under way to the page
const FEW = 2000; // ticks that are kept whatever their age

const SORTS = [["robot", "--robot"], ["own", "--accent"], ["step", "--line"], ["bad", "--halt"]];
const searchText = (document) =>
  `${eventName(document.event)} ${wordsOf(document)} ${document.outcome} ${document.detail ?? ""}`.toLowerCase();
const sortOf = ({ event, outcome }) =>
  outcome === "withheld" ? "own" : outcome !== "applied" ? "bad" : event.kind === "tau" ? "step" : isOwn(event) ? "own" : "robot";

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

const tickOf = (time, document) => ({
  time, name: familyName(document.event.name) || document.event.kind, sort: sortOf(document), text: searchText(document),
});

/** When events were, by this machine's clock: how many per second, and each on a line of its own. */
class Times {
  constructor() { this.clear(); }

  clear(shown = []) {
    Object.assign(this, { seconds: new Map(), ticks: [], shown, latest: 0, kept: FEW });
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
    this.ticks.push(tickOf(time, document));
    if (this.ticks.length > 2 * this.kept) {
      const first = this.ticks.findIndex((t) => t.time > time - WINDOW);
      this.ticks.splice(0, first);
      this.kept = Math.max(FEW, this.ticks.length);
    }
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
        // What went wrong is seen, even once among hundreds.
        const least = sort === "bad" && second[sort] ? 2 : 0;
        const part = Math.max(least, Math.round((second[sort] / most) * (height - 14)));
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

  /**
   * Up to LANES communications that were heard of in the last seconds, each with its events and its
   * rate; who has a lane keeps it. And how many have none.
   */
  lanes(now, fits) {
    const begin = now - WINDOW;
    const first = this.ticks.findLastIndex((t) => t.time < begin) + 1;
    const found = new Map();
    for (let i = first; i < this.ticks.length; i++) {
      const tick = this.ticks[i];
      if (tick.time > now + 1 || !fits(tick)) continue;
      const lane = found.get(tick.name) ?? { name: tick.name, ticks: [], rate: 0 };
      if (!lane.ticks.length) found.set(tick.name, lane);
      lane.ticks.push(tick);
      if (tick.time > now - LATE - LATELY && tick.time <= now - LATE) lane.rate += 1 / LATELY;
    }
    const stay = this.shown.filter((name) => found.has(name));
    const others = [...found.keys()].filter((name) => !stay.includes(name));
    this.shown = [...stay, ...others.slice(0, LANES - stay.length)].sort();
    return { lanes: this.shown.map((name) => found.get(name)), hidden: found.size - this.shown.length };
  }

  drawLanes(canvas, now, colours, fits) {
    const { lanes, hidden } = this.lanes(now, fits);
    const tall = `${(Math.max(1, lanes.length) + 1) * LANE}px`;
    if (canvas.style.height !== tall) canvas.style.height = tall;
    const { context, width } = blank(canvas);
    context.font = SMALL;
    const widest = Math.max(20, ...lanes.map(({ name }) => context.measureText(name).width));
    const left = Math.min(width * 0.45, widest + RATE);
    const x = (time) => left + ((time - now + WINDOW) / WINDOW) * (width - left - 2);
    lanes.forEach((lane, i) => {
      const y = i * LANE;
      context.fillStyle = colours["--rule"];
      context.fillRect(left, y + LANE / 2, width - left, 1);
      for (const [sort, colour] of SORTS) {
        context.fillStyle = colours[colour];
        // Many events at one place are drawn once.
        const columns = new Set(lane.ticks.filter((t) => t.sort === sort).map((t) => Math.round(x(t.time))));
        for (const column of columns) context.fillRect(column, y + 2, 2, LANE - 4);
      }
      context.fillStyle = colours["--ink"];
      context.fillText(fit(context, lane.name, left - RATE), 0, y + LANE - 4);
      context.fillStyle = colours["--quiet"];
      context.textAlign = "right";
      context.fillText(lane.rate ? `${lane.rate.toFixed(1)}/s` : "", left - 6, y + LANE - 4);
      context.textAlign = "left";
    });
    context.fillStyle = colours["--quiet"];
    const y = (lanes.length + 1) * LANE - 2;
    context.fillText(hidden ? `and ${hidden} more` : "", 0, y);
    for (const ago of [0, 5, 10, 15]) {
      context.textAlign = ago ? "center" : "right";
      context.fillText(ago ? `−${ago} s` : "now", x(now - ago), y);
    }
  }
}

/** A text, cut where it would be wider. */
function fit(context, text, width) {
  let most = Math.min(text.length, 80);
  while (most > 1 && context.measureText(shorten(text, most)).width > width) most--;
  return shorten(text, most);
}
