// Playing the model.
"use strict";

let shownChoices = "";

function showChoices(choices, undo) {
  byId("undo").disabled = !undo;
  const text = JSON.stringify(choices);
  if (text === shownChoices) return;
  shownChoices = text;
  page.choices = [...choices].sort((a, b) => a.controllable - b.controllable);
  const able = new Set(choices.map((c) => eventName(c.event)));
  for (const { diagram } of page.cards.values()) {
    for (const { key, words } of diagram.words) enable(words, able.has(key));
  }
  const focused = document.activeElement?.dataset?.choice;
  const typed = new Map([...byId("choices").querySelectorAll("input")].map((i) => [i.dataset.choice, i.value]));
  byId("choices").replaceChildren(...page.choices.map((choice, i) => choiceRow(choice, i, typed)));
  if (focused) byId("choices").querySelector(`[data-choice="${CSS.escape(focused)}"]`)?.focus();
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

function choiceRow(choice, index, typed) {
  const button = make("button", { type: "button" }, choice.text);
  const row = make("form", { className: `choice ${choice.controllable ? "own" : "robot"}` },
    make("kbd", {}, index < 9 ? String(index + 1) : ""), button);
  button.type = "submit";
  let input = null;
  if (choice.needs) {
    input = make("input", { placeholder: choice.needs, value: typed.get(choice.text) ?? "" });
    input.setAttribute("aria-label", `Value of ${choice.text}`);
    input.dataset.choice = choice.text;
    row.append(input);
  } else button.dataset.choice = choice.text;
  row.addEventListener("submit", (event) => {
    event.preventDefault();
    play(input ? { event: choice.event, text: input.value } : { event: choice.event });
  });
  return row;
}

function fireByName(key) {
  const index = page.choices.findIndex((c) => eventName(c.event) === key);
  const several = page.choices.filter((c) => eventName(c.event) === key).length > 1;
  fireChoice(index, several);
}

/** Fire a choice, or lead to where its value is given. */
function fireChoice(index, several = false) {
  const row = byId("choices").children[index];
  if (!row) return;
  const target = row.querySelector("input") ?? row.querySelector("button");
  if (several || row.querySelector("input")) {
    row.scrollIntoView({ block: "center" });
    target.focus();
  } else row.requestSubmit();
}

async function post(path, body) {
  const answer = await fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
  });
  const document = await answer.json();
  if (!answer.ok) throw new Error(document.message);
  return document;
}

async function play(body) {
  try {
    await post("do", body);
    write(byId("refused"), "");
  } catch (fault) {
    write(byId("refused"), fault.message);
  }
}
