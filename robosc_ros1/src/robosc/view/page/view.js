// The link to the server, and the keys. The last script: it begins.
"use strict";

const link = {
  open: null, stream: null, // open is null until the first time

  /** A browser opens few streams to one server: a page that nobody sees leaves its to others. */
  follow() {
    if (exported.data) return;
    if (document.hidden) {
      this.stream?.close();
      this.stream = null;
      return;
    }
    if (this.stream) return;
    this.stream = new EventSource("stream");
    this.stream.onopen = () => { this.open = true; schedule(); };
    this.stream.onmessage = (message) => attempt("message", () => receive(read(message.data)));
    this.stream.onerror = () => { this.open = false; schedule(); };
  },
};

function hold(on) {
  page.held = on;
  byId("freeze").setAttribute("aria-pressed", String(on));
  page.redrawList = true;
  if (on) {
    showStatus();
    held.begin();
  } else {
    held.end();
    schedule();
  }
}

/** Through a recording, or back while the picture is held. */
function step(by) {
  if (page.held) held.go(held.at + by);
  else recording.step(by);
}

function filter() {
  if (page.hello?.source === "log") recording.search(byId("filter").value.trim());
  page.redrawList = true;
  remember();
  schedule();
}

function onKey(event) {
  const typing = event.target.matches("input:not([type=range]), select, textarea");
  if (typing) {
    if (event.key === "Escape") event.target.blur();
    if (event.key === "Enter" && event.target.id === "filter" && recording.hits) recording.next(event.shiftKey ? -1 : 1);
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help-box").open) return;
  const log = page.hello?.source === "log";
  const pressing = event.target.matches("button");
  if (event.key === " " && !pressing) log ? recording.toggle() : hold(!page.held);
  else if (event.key === "/") byId("filter").focus();
  else if (event.key === "?") byId("help-box").showModal();
  else if ((log || page.held) && event.key === "ArrowLeft") step(event.shiftKey ? -100 : -1);
  else if ((log || page.held) && event.key === "ArrowRight") step(event.shiftKey ? 100 : 1);
  else if (log && recording.hits && event.key === "n") recording.next(1);
  else if (log && recording.hits && event.key === "N") recording.next(-1);
  else if (page.choices.length && /^[1-9]$/.test(event.key)) listedChoices()[event.key - 1]?.fire();
  else if (page.choices.length && event.key === "u") play({ undo: 1 });
  else if (page.choices.length && event.key === "r") play({ random: 1 });
  else return;
  event.preventDefault();
}

byId("freeze").addEventListener("click", () => hold(!page.held));
byId("help").addEventListener("click", () => byId("help-box").showModal());
byId("filter").addEventListener("input", filter);
byId("undo").addEventListener("click", () => play({ undo: 1 }));
byId("random").addEventListener("click", () => play({ random: 1 }));
byId("restart").addEventListener("click", () => play({ restart: true }));
byId("play").addEventListener("click", () => recording.toggle());
byId("back").addEventListener("click", () => step(-1));
byId("onward").addEventListener("click", () => step(1));
byId("moment").addEventListener("input", (event) => {
  const at = Number(event.target.value);
  if (page.held) held.go(at);
  else recording.jump(at);
});
byId("goto").addEventListener("change", (event) => {
  const place = recording.placeOf(event.target.value.trim());
  event.target.setCustomValidity(place ? "" : "Neither the number of an event nor a time as 13:05:07");
  if (event.target.reportValidity()) recording.jump(place);
});
byId("departure").addEventListener("click", () => recording.jump(recording.nextDeparture().at));
byId("previous").addEventListener("click", () => recording.next(-1));
byId("next").addEventListener("click", () => recording.next(1));
byId("events").addEventListener("click", ({ target }) => {
  const place = Number(target.closest("li")?.dataset.place);
  if (place) recording.jump(place);
});
document.addEventListener("keydown", onKey);
document.addEventListener("visibilitychange", () => link.follow());
addEventListener("resize", schedule);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", schedule);
setInterval(() => {
  if (document.hidden) return;
  if (page.held) showStatus();
  else schedule();
}, 250);
setInterval(showClocks, 100);
byId("filter").value = restored.filter;
for (const [name, size] of restored.sizes) resize(name, size);
if (byId("recorded")) exported.begin();
else link.follow();
