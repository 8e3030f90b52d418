// Playing the model. A choice keeps its place and its element while events rush, so that a click
// reaches what it was meant for; one that is not possible now is dimmed, and the server says why.
"use strict";

const MOST_CHOICES = 40; // rows, beyond which those leave that were not possible for the longest

class ChoiceRow {
  constructor(choice) {
    this.number = make("kbd");
    this.button = make("button", { type: "submit", title: choice.text }, choice.short ?? choice.text);
    this.element = make("form", { className: `choice ${choice.controllable ? "own" : "robot"}` }, this.number, this.button);
    this.input = choice.needs ? make("input", { placeholder: choice.needs }) : null;
    if (this.input) {
      this.input.setAttribute("aria-label", `Value of ${choice.text}`);
      this.element.append(this.input);
    }
    (this.input ?? this.button).dataset.choice = choice.text;
    this.event = choice.event;
    this.lately = 0; // when it was possible last
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      play(this.input ? { event: this.event, text: this.input.value } : { event: this.event });
    });
  }

  show(possible, now) {
    if (possible) this.lately = now;
    this.possible = possible;
    toggle(this.element, "gone", !possible);
    if (this.button.getAttribute("aria-disabled") !== String(!possible)) {
      this.button.setAttribute("aria-disabled", String(!possible));
    }
  }

  /** Fire it, or lead to where its value is given. */
  fire(several = false) {
    if (!several && !this.input) return this.element.requestSubmit();
    this.element.scrollIntoView({ block: "center" });
    (this.input ?? this.button).focus();
  }
}

const choiceRows = new Map(); // by what is written on them
let shownChoices = "";

function showChoices(choices, undo) {
  byId("undo").disabled = !undo;
  const text = JSON.stringify(choices);
  if (text === shownChoices) return;
  shownChoices = text;
  page.choices = choices;
  const able = new Set(choices.map((c) => eventName(c.event)));
  for (const { diagram } of page.cards.values()) {
    for (const { key, words } of diagram.words) enable(words, able.has(key));
  }
  const before = choiceRows.size;
  const possible = new Set();
  for (const choice of choices) {
    possible.add(choice.text);
    if (choiceRows.has(choice.text)) continue;
    const row = new ChoiceRow(choice);
    choiceRows.set(choice.text, row);
    byId(choice.controllable ? "own-choices" : "robot-choices").append(row.element);
  }
  const now = performance.now();
  for (const [text, row] of choiceRows) row.show(possible.has(text), now);
  if (dropChoices() || choiceRows.size !== before) numberChoices();
}

/** Large robots: only as many rows as can be looked through; none leaves under the pointer. */
function dropChoices() {
  const list = byId("choices");
  const gone = [...choiceRows].filter(([, row]) => !row.possible).sort((a, b) => a[1].lately - b[1].lately);
  const many = Math.min(gone.length, choiceRows.size - MOST_CHOICES);
  if (many <= 0 || list.matches(":hover, :focus-within")) return false;
  for (const [text, row] of gone.slice(0, many)) {
    row.element.remove();
    choiceRows.delete(text);
  }
  return true;
}

const listedChoices = () =>
  [...byId("choices").querySelectorAll("form")].map((form) => choiceRows.get(form.querySelector("[data-choice]").dataset.choice));

function numberChoices() {
  listedChoices().forEach((row, i) => write(row.number, i < 9 ? String(i + 1) : ""));
}

/** What is written at a transition fires its event, while that is possible. */
function enable(words, on) {
  if (words.classList.contains("able") === on) return;
  toggle(words, "able", on);
  for (const [name, value] of [["role", "button"], ["tabindex", "0"]]) {
    if (on) words.setAttribute(name, value);
    else words.removeAttribute(name);
  }
}

function fireByName(key) {
  const rows = listedChoices().filter((row) => row.possible && eventName(row.event) === key);
  rows[0]?.fire(rows.length > 1);
}

async function play(body) {
  try {
    await post("do", body);
    write(byId("refused"), "");
  } catch (fault) {
    write(byId("refused"), fault.message);
  }
}
