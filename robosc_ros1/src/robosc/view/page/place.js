// What one looks at, in the page's address: a link that restores it.
"use strict";

/** What the address held when the page was opened. */
const restored = (() => {
  const given = new URLSearchParams(location.hash.slice(1));
  return {
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
    history.replaceState(null, "", `#${place}`);
  }, 500);
}
