// Going through a recording.
"use strict";

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
    for (const document of events) {
      if (document.outcome === "applied") page.rows.get(eventName(document.event))?.send(wordsOf(document));
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
