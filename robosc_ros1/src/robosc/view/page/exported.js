// A recording that lies in the page itself: what a server would answer.
"use strict";

const SNAPSHOTS = 1024; // events between two states that are kept as a whole

const exported = {
  data: null,

  /** Unpack what the page holds, if it holds anything, and show it. */
  async begin() {
    const packed = Uint8Array.from(atob(byId("recorded").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const [told, computed] = (await new Response(stream).text()).split("\n");
    this.data = { ...read(told), ...JSON.parse(computed) };
    this.keep();
    link.open = true;
    receive({ hello: this.data.hello, model: this.data.model });
  },

  /** Values by path, every so many events, so that no moment is far from one. */
  keep() {
    this.snapshots = [];
    const now = [];
    this.data.steps.forEach((step, i) => {
      if (i % SNAPSHOTS === 0) this.snapshots.push([...now]);
      this.take(now, step);
    });
  },

  take(now, step) {
    for (let i = 0; i < (step?.length ?? 0); i += 2) now[step[i]] = this.data.values[step[i + 1]];
  },

  answer(path, body) {
    return this[path](body);
  },

  overview() {
    return this.data.overview;
  },

  moment({ at }) {
    const first = Math.max(0, at - KEPT / 2);
    return { state: this.stateAt(at), events: this.data.events.slice(first, at).map(copyOfEvent) };
  },

  stateAt(at) {
    if (!this.data.steps[at - 1]) return null;
    const begin = Math.floor((at - 1) / SNAPSHOTS);
    const now = [...this.snapshots[begin]];
    for (let i = begin * SNAPSHOTS; i < at; i++) this.take(now, this.data.steps[i]);
    const { number, time } = this.data.events[at - 1];
    const state = { ...structuredClone(this.data.first), number, time };
    this.data.paths.forEach((path, i) => {
      const owner = path.slice(0, -1).reduce((part, key) => part[key], state);
      owner[path.at(-1)] = now[i];
    });
    return state;
  },

  search({ text }) {
    this.texts ??= this.data.events.map(copyOfEvent).map(searchText);
    const wanted = text.toLowerCase();
    const hits = [];
    this.texts.forEach((words, i) => words.includes(wanted) && hits.push(i + 1));
    return { hits };
  },

  events({ places }) {
    return { events: places.map((place) => copyOfEvent(this.data.events[place - 1])) };
  },
};

/** The page forgets values of events that it has put into words. */
const copyOfEvent = (document) => ({ ...document, event: { ...document.event } });
