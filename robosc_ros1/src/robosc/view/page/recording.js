// Going through a recording.
"use strict";

const LONGEST_PAUSE = 2; // seconds without events that are played
const SORT_OF_LETTER = { x: "bad", c: "own", t: "step", r: "robot" };

const recording = {
  count: 0, at: 0, wanted: 0, asking: false, playing: false,
  times: [], ticks: [], departures: [], // of the whole log
  text: "", hits: null, // what is searched for, and the places of the events that have it

  async begin(hello) {
    if (this.count) return; // the stream was opened again
    this.count = hello.count;
    Object.assign(byId("moment"), { min: 1, max: hello.count, value: 1 });
    const { times, sorts, names, name, departures, series } = await post("overview", {});
    const ticks = times.map((time, i) => ({ time, name: familyName(names[name[i]]), sort: SORT_OF_LETTER[sorts[i]], place: i + 1 }));
    Object.assign(this, { times, ticks, departures });
    for (const { name: what, component, places, values } of series) {
      const whole = new Series(places.map((place) => times[place - 1]), values);
      past.all.set(what, whole);
      whole.owner = component ?? undefined;
      if (component) page.cards.get(component)?.addData(what);
    }
    byId("departure").hidden = !departures.length;
    await this.go(restored.at ?? 1);
    if (restored.filter) this.search(restored.filter);
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
    } catch {
      this.pause();
    } finally {
      this.asking = false;
    }
  },

  show(at, { state, events }) {
    const steps = at - this.at;
    this.at = at;
    events.forEach((document, i) => (document.place = at - events.length + 1 + i));
    page.events = events;
    page.fresh = steps > 0 ? events.slice(-steps) : [];
    page.redrawList = true;
    for (const row of page.rows.values()) row.forget();
    for (const document of events) {
      tellRow(document);
    }
    // The transitions of what was skipped are not known to have followed one another.
    if (steps <= 0 || steps > events.length) page.followed.clear();
    page.state = state ?? page.state;
    this.tellDeparture();
    byId("moment").value = at;
    write(byId("where"), `${at} of ${this.count} · ${dayAndClock(this.times[at - 1])}`);
    this.tellHits();
    this.list();
    remember();
    schedule();
  },

  // --- where the log leaves the model ------------------------------------------------------------

  /** The departure that is not known any more what came after. */
  departureAt(place) {
    return this.departures.find((d) => d.at <= place && place <= d.until);
  },

  tellDeparture() {
    const left = this.departureAt(this.at);
    page.status = left ? { good: false, text: "left the model" } : { good: true, text: "recording" };
    const words = left && `The log leaves the model at event ${left.at}: ${left.reason}. The state before it is shown.`;
    tell("lost", words);
    const next = this.nextDeparture();
    write(byId("departure"), next ? `Leaves the model at event ${next.at}` : "");
  },

  /** The one to jump to: the next, or the first again. */
  nextDeparture() {
    return this.departures.find((d) => d.at > this.at) ?? this.departures[0];
  },

  // --- searching ---------------------------------------------------------------------------------

  async search(text) {
    this.text = text;
    const { hits } = text ? await post("search", { text }) : { hits: null };
    if (text !== this.text) return; // more was typed meanwhile
    this.hits = hits && { places: hits, all: new Set(hits) };
    this.tellHits();
    this.list();
    schedule();
  },

  /** Which of the hits is the last one up to now: their number is 1 more. */
  hitIndex() {
    return this.hits.places.findLastIndex((place) => place <= this.at);
  },

  tellHits() {
    for (const id of ["previous", "next"]) byId(id).disabled = !this.hits?.places.length;
    if (!this.hits) return write(byId("found"), "");
    const { length } = this.hits.places;
    const index = this.hitIndex();
    const here = this.hits.places[index] === this.at ? `${index + 1} of ` : "";
    write(byId("found"), `${here}${length === 1 ? "1 hit" : `${length} hits`}`);
  },

  next(by) {
    const { places } = this.hits;
    const index = this.hitIndex();
    const here = places[index] === this.at;
    const place = places[by > 0 || here ? index + by : index];
    if (place !== undefined) this.jump(place);
  },

  /** The list shows the last events up to now, or the last hits. */
  async list() {
    if (!this.hits) page.listing = null;
    else {
      const index = this.hitIndex();
      const places = this.hits.places.slice(Math.max(0, index + 1 - SHOWN), index + 1);
      const asked = (this.listed = `${this.text}\n${places.at(-1)}`);
      const { events } = await post("events", { places });
      if (asked !== this.listed) return;
      events.forEach((document, i) => (document.place = places[i]));
      page.listing = events;
    }
    page.redrawList = true;
    schedule();
  },

  /** Ticks of the last seconds and counts of the last minute, from the whole log. */
  fill(times) {
    times.clear(times.shown);
    const now = this.times[this.at - 1];
    times.latest = now;
    let first = this.at;
    for (let i = this.at - 1; i >= 0 && this.times[i] > now - MINUTE; i--) {
      times.count(this.times[i], this.ticks[i].sort);
      if (this.times[i] > now - WINDOW) first = i;
    }
    times.ticks = this.ticks.slice(first, this.at);
  },

  // --- moving ------------------------------------------------------------------------------------

  jump(at) {
    this.pause();
    this.go(at);
  },

  step(by) {
    this.jump(this.wanted + by);
  },

  /** Where a number of an event, or a time of day, leads; undefined where there is no such thing. */
  placeOf(text) {
    if (/^\d+$/.test(text)) return Number(text) || undefined;
    const time = /^(\d{1,2}):(\d\d)(?::(\d\d(?:\.\d+)?))?$/.exec(text);
    if (!time) return undefined;
    const day = new Date(this.times[this.at - 1] * 1000);
    day.setHours(Number(time[1]), Number(time[2]), 0, 0);
    const wanted = day / 1000 + Number(time[3] ?? 0);
    const place = this.times.findIndex((t) => t >= wanted);
    return place < 0 ? this.count : place + 1;
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
