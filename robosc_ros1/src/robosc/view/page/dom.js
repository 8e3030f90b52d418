// What all parts of the page use: elements, and values as text.
"use strict";

const byId = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";
const LONGEST = 300; // characters of a value
const calm = matchMedia("(prefers-reduced-motion: reduce)");

function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** Only what changes is written, so that the browser lays out no more than that. */
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function toggle(element, name, on) {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}

/** JSON, with integers beyond the doubles as they were written, where the browser keeps the text. */
function read(text) {
  return JSON.parse(text, (_, value, context) =>
    Number.isInteger(value) && !Number.isSafeInteger(value) ? (context?.source ?? value) : value);
}

function valueText(value) {
  if (value === null || value === undefined) return "";
  if (Array.isArray(value)) return `[${value.map(valueText).join(", ")}]`;
  if (typeof value === "object") {
    return `{${Object.entries(value).map(([k, v]) => `${k}: ${valueText(v)}`).join(", ")}}`;
  }
  if (typeof value === "number" && !Number.isInteger(value)) {
    return String(Math.abs(value) < 1e5 ? +value.toPrecision(6) : +value.toFixed(1));
  }
  return String(value);
}

/** What a supervisor made of a command, and which statement says so. */
function correctionOf({ corrected }) {
  if (!corrected) return null;
  const fields = Object.entries(corrected.fields);
  const changes = fields.map(([path, { sent, made }]) => `${path} ${JSON.stringify(sent)} → ${JSON.stringify(made)}`);
  return `corrected: ${changes.join(", ")} (${shorten(corrected.by, 80)}, ${corrected.place})`;
}

/** The value of an event in words; what is long (a whole map, perhaps) is not kept. */
function wordsOf(document) {
  if (document.words === undefined) {
    document.words = shorten(valueText(document.event.value), LONGEST);
    if (!isStep(document.event)) delete document.event.value;
  }
  return document.words;
}

const eventName = (event) =>
  isStep(event) ? `${event.name}.${event.kind}${event.index ?? ""}`
  : event.name ? `${event.name}.${event.kind}` : event.kind;
/** An event as people read it: a transition of a component is told by where it leads. */
const eventTitle = (event) => (isStep(event) ? event.name : eventName(event));
/** The event at an arrow, which shows where it leads. */
const eventAtArrow = (event) => (event.kind === "tau" ? "transition" : eventName(event));
/** Whether an event belongs to one transition of a component. */
const isStep = (event) => ["tau", "after"].includes(event.kind);
/** The names of what the controller serves: it gives feedback and answers. */
const served = new Set();
const isOwn = (event) =>
  (served.has(event.name) ? ["response", "error", "feedback"] : ["request", "cancel", "tau"]).includes(event.kind);
/** A component may be called `constructor`. */
const own = (object, name) => (Object.hasOwn(object, name) ? object[name] : undefined);
const shorten = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

/** What shows that an operator opened the page. */
const authority = () => (operating.token ? { Authorization: `Bearer ${operating.token}` } : {});

/** Ask the server, or the page itself where it holds a recording. */
async function post(path, body) {
  if (exported.data) return exported.answer(path, body);
  const answer = await fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json", ...authority() }, body: JSON.stringify(body),
  });
  const document = await answer.json();
  if (!answer.ok) throw new Error(document.message);
  return document;
}
