// The operator's hand: orders to the node, and messages of the components that stand for persons.
// What the node made of it comes back as events, like everything else.
"use strict";

const operating = {
  token: null, persons: [], model: null,

  /** The token comes behind the address, where no server and no log sees it; a reload keeps it. */
  begin() {
    const given = new URLSearchParams(location.hash.slice(1)).get("token");
    if (given) {
      sessionStorage.setItem("token", given);
      history.replaceState(null, "", location.pathname);
    }
    this.token = sessionStorage.getItem("token");
  },

  offer({ persons }) {
    this.persons = persons;
    byId("operating").hidden = false;
    this.list();
  },

  /** A row for each message of a person. */
  list() {
    const offered = page.communications.filter((c) =>
      c.kind === "outgoing message" && this.persons.includes(c.component));
    const text = JSON.stringify(offered);
    if (text === this.model) return;
    this.model = text;
    byId("messages").replaceChildren(...offered.map((message) => this.row(message)));
    const unknown = this.persons.filter((name) => !page.communications.some((c) => c.component === name));
    if (page.communications.length && unknown.length) this.say(`The model has no messages of ${unknown.join(", ")}.`);
  },

  row({ name, response }) {
    const input = response === "none" ? null : make("input", { placeholder: response });
    input?.setAttribute("aria-label", `Data of ${name}`);
    const button = make("button", { type: "submit" }, name);
    const form = make("form", { className: "choice robot" }, button, ...(input ? [input] : []));
    form.dataset.message = name;
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.ask({ send: name, text: input?.value ?? "" });
    });
    return form;
  },

  show({ stopped }) {
    const held = stopped === "held by the operator";
    byId("hold-all").disabled = Boolean(stopped);
    byId("release").disabled = byId("step").disabled = !held;
  },

  async ask(body) {
    try {
      await post("operate", body);
      this.say("");
    } catch (fault) {
      this.say(fault.message);
    }
  },

  say(text) {
    write(byId("told"), text);
  },
};

if (!byId("recorded")) operating.begin();
for (const [id, order] of [["hold-all", "hold"], ["release", "release"], ["step", "step"]]) {
  byId(id).addEventListener("click", () => operating.ask({ order }));
}
