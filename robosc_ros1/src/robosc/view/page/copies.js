// Several of a kind: copies of a component in one drawing, their commands in one row of lamps. A click
// on a copy unfolds it.
"use strict";

/** The name and the number of a copy: `Station[3].serve` is 3 of `Station[i].serve`. */
function copyOf(name) {
  const found = /^([^[\]]*)\[(\d+)\](.*)$/.exec(name);
  return found && { family: `${found[1]}[i]${found[3]}`, number: Number(found[2]) };
}

/** What communications of copies are called where they are counted together. */
const familyName = (name) => copyOf(name)?.family ?? name;

/** Things in the order of the first of each family; those that are alone, or no copies, as [thing]. */
function families(things, nameOf) {
  const found = new Map();
  for (const thing of things) {
    const family = familyName(nameOf(thing));
    if (!found.has(family)) found.set(family, []);
    found.get(family).push(thing);
  }
  return [...found.values()];
}

const shapeOf = (component) => JSON.stringify([
  component.states, component.transitions.map((t) => [t.from, t.to, t.event.kind, familyName(t.event.name)]),
]);

/** A component that stands for its copies; where their texts differ there is "…". */
function template(copies) {
  const [first] = copies;
  const general = (copy, text) => text?.replaceAll(copy.name, copyOf(copy.name).family) ?? null;
  const common = (textOf) => {
    const texts = new Set(copies.map((copy) => general(copy, textOf(copy))));
    return texts.size === 1 ? [...texts][0] : "…";
  };
  const transitions = first.transitions.map((t, i) => ({
    ...t, event: { ...t.event, name: familyName(t.event.name) },
    guard: common((copy) => copy.transitions[i].guard),
    assignments: t.assignments.map((_, n) => common((copy) => copy.transitions[i].assignments[n])),
  }));
  return { ...first, name: copyOf(first.name).family, variables: [], transitions, room: ` · ${copies.length}` };
}

/** Cards of all components with states, copies of the same shape in one. */
function componentCards(components, fire) {
  const all = new Map();
  const shown = [];
  const add = (component) => {
    const card = new Card(component, all.size, fire);
    all.set(component.name, card);
    shown.push(card);
  };
  for (const family of families(components, (c) => c.name)) {
    if (family.length < 2 || new Set(family.map(shapeOf)).size > 1) family.forEach(add);
    else {
      const folded = new Folded(family, all.size, fire);
      shown.push(folded);
      for (const copy of folded.copies) all.set(copy.component.name, copy);
    }
  }
  return { all, shown };
}

/** Copies of a component: one drawing, with how many are in each state, and a row of all. */
class Folded {
  constructor(components, number, fire) {
    const general = template(components);
    this.diagram = new Diagram(general, number, () => {});
    this.counts = new Map(general.states.map(({ name }) => [name, 0]));
    this.tile = make("b");
    this.link = make("a", { href: `#component-${number}` }, make("span", {}, `${general.name} `), this.tile);
    this.chips = make("ul", { className: "copies", ariaLabel: `Copies of ${general.name}` });
    this.opened = make("div", { className: "opened" });
    this.element = cardElement(this.diagram, `${components.length} copies · ${general.place}`);
    this.element.classList.add("folded");
    this.element.append(this.chips, this.opened);
    this.copies = components.map((component, i) => new Copy(component, this, `${number}-${i}`, fire));
    this.chips.append(...this.copies.map((copy) => copy.chip));
  }

  /** A copy went from a state to another. */
  move(from, to) {
    for (const [state, by] of [[from, -1], [to, 1]]) {
      if (this.counts.has(state)) this.counts.set(state, this.counts.get(state) + by);
    }
    for (const [state, group] of this.diagram.states) {
      const count = this.counts.get(state);
      toggle(group, "active", count > 0);
      write(group.querySelector("text"), bareName(state) + (count ? ` · ${count}` : ""));
    }
    const told = [...this.counts].filter(([, count]) => count).map(([state, count]) => `${count} ${state}`);
    write(this.tile, told.join(", "));
  }
}

/** One of them: a chip, and a card of its own while it is unfolded. */
class Copy {
  constructor(component, folded, number, fire) {
    Object.assign(this, { component, folded, number, fire, card: null, shown: null });
    this.state = make("span");
    this.button = make("button", { type: "button", title: component.name }, make("b", {}, String(copyOf(component.name).number)), this.state);
    this.button.setAttribute("aria-pressed", "false");
    this.button.addEventListener("click", () => this.unfold(!this.card));
    this.chip = make("li", {}, this.button);
    this.diagram = this; // as of a card: which transition an event takes, and its words
  }

  get element() { return this.button; }

  get words() { return this.card?.diagram.words ?? []; }

  taken(event, state, after) {
    if (this.card) return this.card.diagram.taken(event, state, after);
    return copyOf(event.name)?.number === copyOf(this.component.name).number || !copyOf(event.name)
      ? this.folded.diagram.taken({ ...event, name: familyName(event.name) }, state, after) : undefined;
  }

  addData(name) {
    this.card?.addData(name);
  }

  unfold(on) {
    this.card?.element.remove();
    this.card = on ? new Card(this.component, this.number, this.fire) : null;
    this.button.setAttribute("aria-pressed", String(on));
    if (on) {
      this.folded.opened.append(this.card.element);
      if (this.shown) this.card.show(...this.shown);
      for (const { key, words } of this.words) enable(words, page.choices.some((c) => eventName(c.event) === key));
    }
    remember();
  }

  show(state, variables) {
    const before = this.shown?.[0];
    this.shown = [state, variables];
    this.card?.show(state, variables);
    if (state === before) return;
    if (before !== undefined) light(this.button);
    write(this.state, state ?? "");
    this.button.dataset.state = state;
    toggle(this.button, "away", !this.component.states.some((s) => s.initial && s.name === state));
    this.folded.move(before, state);
  }
}

/** A row for each command, or for a command of several copies. */
function commandRows(commands, hasData) {
  const all = new Map();
  const elements = [];
  for (const family of families(commands, (c) => eventName(c.event))) {
    if (family.length < 2) {
      const row = new CommandRow(family[0].event, hasData(family[0]));
      all.set(eventName(family[0].event), row);
      elements.push(row.element);
    } else {
      const rows = new CommandRows(family.map((c) => c.event), hasData(family[0]));
      for (const lamp of rows.lamps) all.set(lamp.key, lamp);
      elements.push(rows.element);
    }
  }
  return { all, elements };
}

/** The same command of several copies: a lamp for each, and what there is to say of the chosen one. */
class CommandRows {
  constructor(events, hasData) {
    const family = { ...events[0], name: familyName(events[0].name) };
    this.row = new CommandRow(family, hasData);
    this.chosen = make("span", { className: "chosen" });
    this.lamps = events.map((event) => new CopyLamp(event, this));
    this.row.lamp.replaceWith(make("span"));
    this.row.name.append(" ", this.chosen);
    const strip = make("div", { className: "lamps" }, ...this.lamps.map((lamp) => lamp.button));
    this.row.sent.before(strip);
    this.element = this.row.element;
    this.choose(this.lamps[0]);
  }

  choose(lamp) {
    this.lamp?.button.setAttribute("aria-pressed", "false");
    this.lamp = lamp;
    lamp.button.setAttribute("aria-pressed", "true");
    write(this.chosen, `i = ${lamp.number}`);
    this.row.forget();
    if (lamp.last) this.row.send(...lamp.last);
    if (lamp.would) this.row.withhold(...lamp.would);
    if (lamp.command) this.row.show(lamp.command);
  }
}

/** The command of one copy. */
class CopyLamp {
  constructor(event, rows) {
    Object.assign(this, { rows, key: eventName(event), number: copyOf(event.name).number, last: null, would: null, command: null });
    this.lamp = make("span", { className: "lamp" });
    this.button = make("button", { type: "button" }, this.lamp);
    this.button.setAttribute("aria-pressed", "false");
    this.button.dataset.command = this.key;
    this.button.addEventListener("click", () => rows.choose(this));
  }

  show(command) {
    this.command = command;
    const word = lampWord(command);
    setLamp(this.lamp, word, this.button, this.button, `${this.key}: ${word}`);
    if (this.rows.lamp === this) this.rows.row.show(command);
  }

  send(...told) {
    this.last = told;
    if (this.rows.lamp === this) this.rows.row.send(...told);
  }

  withhold(...told) {
    this.would = told;
    if (this.rows.lamp === this) this.rows.row.withhold(...told);
  }

  flash() {
    this.lamp.animate(glow(), fading(700));
  }

  forget() {
    this.last = this.would = null;
    if (this.rows.lamp === this) this.rows.row.forget();
  }
}
