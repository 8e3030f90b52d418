// Rows of commands, with all reasons of those that are not enabled. Where a command is enabled for a
// moment only, its row keeps its height, so that the rows below it do not jump.
"use strict";

const STEADY = 3000; // milliseconds after which a row is as small as what it says

const isWaiting = (reason) => ["phase", "synchronisation", "preference"].includes(reason.kind);

/** The reason of an enabled command that is not sent, as one of those that disabled commands have. */
const preferredReason = (names) =>
  ({ kind: "preference", text: `waits for ${names.join(", ")}, which ${names.length > 1 ? "are" : "is"} preferred` });

/** What a command's lamp says: enabled, waiting or forbidden. */
const lampWord = ({ enabled, blocked_by: reasons, waits_for: preferred = [] }) => {
  if (enabled) return preferred.length > 0 ? "waiting" : "enabled";
  return reasons.length > 0 && reasons.every(isWaiting) ? "waiting" : "forbidden";
};
const LAMPS = { enabled: "lamp on", waiting: "lamp wait", forbidden: "lamp off" };

/** Show a lamp's word: `owner` is marked with it, `named` gets it, or a longer text, as its name. */
function setLamp(lamp, word, owner, named, text = word) {
  if (owner.dataset.is === word) return;
  owner.dataset.is = word;
  lamp.className = LAMPS[word];
  named.title = text;
  named.setAttribute("aria-label", text);
}

class CommandRow {
  constructor(event, hasData) {
    this.lamp = make("span", { className: "lamp", role: "img" });
    this.tally = make("span", { className: "tally" });
    this.below = make("div", { className: "below reasons" });
    this.sent = make("div", { className: "below sent", hidden: !hasData });
    const { name, kind } = event;
    this.key = eventName(event);
    this.name = make("button", { className: "command-name", type: "button", title: "Show all data" },
      name, make("small", {}, ` ${kind}`));
    this.name.setAttribute("aria-expanded", "false");
    this.name.addEventListener("click", () => this.unfold(!this.element.classList.contains("open")));
    this.element = make("li", {}, this.lamp, this.name, this.tally, this.sent, this.below);
    this.element.dataset.command = this.key;
    this.told = "";
  }

  unfold(on) {
    toggle(this.element, "open", on);
    this.name.setAttribute("aria-expanded", String(on));
  }

  show(command) {
    setLamp(this.lamp, lampWord(command), this.element, this.lamp);
    write(this.tally, command.count ? `${command.count}×` : "");
    if (!this.last && !this.would && command.data) {
      this.sent.hidden = false;
      const data = shorten(valueText(command.data), LONGEST);
      write(this.sent, lampWord(command) === "enabled" ? `would send ${data}` : "");
    }
    const { blocked_by: blocking, waits_for: preferred = [] } = command;
    const reasons = preferred.length > 0 ? [...blocking, preferredReason(preferred)] : blocking;
    const told = JSON.stringify(reasons);
    if (told === this.told) return;
    this.told = told;
    clearTimeout(this.ending);
    toggle(this.below, "past", !reasons.length);
    if (reasons.length) this.below.replaceChildren(...reasons.map(reasonLine));
    else this.ending = setTimeout(() => this.below.replaceChildren(), STEADY);
  }

  send(words, time) {
    this.last = { words, time };
    this.tell();
  }

  /** A shadow would have sent it. */
  withhold(words, time) {
    this.would = { words, time };
    this.sent.hidden = false;
    this.tell();
  }

  /** What was sent last, and beside it what a shadow would have sent, both with their times. */
  tell() {
    const { last, would } = this;
    const at = (done) => `${done.words} at ${clock(done.time)}`.trimStart();
    this.sent.classList.toggle("both", Boolean(would));
    if (!would) write(this.sent, `sent ${last.words}`.trimEnd());
    else write(this.sent, `${last ? `sent ${at(last)}` : "not sent"} · would send ${at(would)}`);
  }

  flash() {
    this.lamp.animate(glow(), fading(700));
  }

  forget() {
    this.last = this.would = null;
    write(this.sent, "");
  }
}

/**
 * Have the row of a command say what an event tells of it; `late`: unless a later one did. The row,
 * or null if the event tells nothing of a command.
 */
function tellRow(document, late = false) {
  const { event, outcome } = document;
  const row = page.rows.get(eventName(event));
  if (!row) return null;
  const at = document.time + (page.ahead ?? 0);
  if (outcome === "withheld") {
    if (!(late && row.would)) row.withhold(wordsOf(document), at);
  } else if (["applied", "forbidden", "undecided"].includes(outcome)) {
    if (!(late && row.last)) row.send(wordsOf(document), at);
  } else return null;
  return row;
}

function reasonLine(reason) {
  const { place: whole } = reason;
  // Of the model's own file, the line says enough.
  const short = whole?.startsWith(`${page.source}:`) ? whole.replace(`${page.source}:`, "line ") : whole;
  const place = whole ? [make("span", { className: "place", title: whole }, short), " "] : [];
  const because = reason.because ? `${reason.because.join(", ")}: ` : "";
  return make("div", { className: isWaiting(reason) ? "why wait" : "why" }, ...place, because + reason.text);
}
