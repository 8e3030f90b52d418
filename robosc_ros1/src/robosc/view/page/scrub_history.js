// While the picture is held, one can go back through the states of the last while.
"use strict";

const OFTEN = 0.1; // seconds between two states that are kept
const STATES = 600;

const held = {
  states: [], // oldest first
  at: null, // which of them is shown; null while nothing is held

  keep(state) {
    if (page.held) return;
    const before = this.states.at(-2);
    // Of states that come more often, the last one of a while.
    if (before && state.time - before.time < OFTEN) this.states.pop();
    this.states.push(state);
    if (this.states.length > STATES) this.states.shift();
  },

  begin() {
    Object.assign(byId("moment"), { min: 0, max: this.states.length - 1, value: this.states.length - 1 });
    byId("scrub").hidden = this.states.length < 2;
    this.go(this.states.length - 1);
  },

  go(at) {
    if (!this.states.length) return;
    this.at = Math.max(0, Math.min(this.states.length - 1, at));
    const state = this.states[this.at];
    byId("moment").value = this.at;
    write(byId("where"), dayAndClock(state.time));
    showState(state);
    page.shown = state; // not the last one, which is shown when the picture goes on
    page.redrawList = true;
    showEvents([]);
  },

  end() {
    this.at = null;
    byId("scrub").hidden = true;
    page.followed.clear();
  },

  /** When and after which event the state is that is shown; null if nothing is held. */
  get state() {
    return this.at === null ? null : this.states[this.at];
  },
};
