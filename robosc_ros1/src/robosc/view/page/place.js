// What one looks at, in the page's address: a link that restores it.
"use strict";

/** What the address held when the page was opened. */
const restored = (() => {
  const given = new URLSearchParams(location.hash.slice(1));
  return {
    open: given.getAll("open"),
    at: Number(given.get("at")) || null,
    filter: given.get("filter") ?? "",
  };
})();

let remembering = null;

/** Write into the address what is looked at; browsers allow it a few times per second. */
function remember() {
  remembering ??= setTimeout(() => {
    remembering = null;
    const place = new URLSearchParams();
    if (page.hello?.source === "log") place.set("at", recording.at);
    if (byId("filter").value) place.set("filter", byId("filter").value);
    for (const [name, card] of page.cards) if (card instanceof Copy && card.card) place.append("open", name);
    history.replaceState(null, "", `#${place}`);
  }, 500);
}

function restoreOpen() {
  for (const name of restored.open) {
    const copy = page.cards.get(name);
    if (copy instanceof Copy) copy.unfold(true);
  }
}
