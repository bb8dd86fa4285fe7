// SPDX-License-Identifier: Apache-2.0
// A plan among the values: its moves as a list, each with what it assumes. A list of named things: each in a line, what
// is known of it folded into that. Any other value as its text.

const MOST_MOVES = 60, MOST_NAMED = 60;

/** The moves of a plan; null for a value that is none. */
function movesOf(value) {
  if (value === null || typeof value !== "object" || !Array.isArray(value.moves)
    || !Object.hasOwn(value, "next")) return null;
  return value.moves.every((move) => move !== null && typeof move === "object" && typeof move.object === "string")
    ? value.moves : null;
}

/** A move in words. */
function moveWords(move) {
  const { x, y } = move.place || {},
    place = Number.isFinite(x) && Number.isFinite(y) ? `, at ${valueText(x, 2)}, ${valueText(y, 2)} m` : "";
  return `${move.object} onto ${valueText(move.onto)}${place}`;
}

/** A value as a line of text. */
function valueWords(value) {
  const moves = movesOf(value);
  if (moves === null) return valueText(value);
  if (!moves.length) return value.reason ? `no plan: ${valueText(value.about || value.reason)}` : "nothing to move";
  return moves.slice(0, MOST_MOVES).map((move, index) => `${index + 1}. ${moveWords(move)}`).join("; ");
}

/** The fields of a value that are lists of named things. */
function namedIn(value) {
  if (value === null || typeof value !== "object" || Array.isArray(value)) return [];
  return Object.keys(value).filter((field) => Array.isArray(value[field]) && value[field].length
    && value[field].every((each) => each !== null && typeof each === "object" && typeof each.name === "string"));
}

/** A value that has lists of named things: these, and the rest as text. */
function namedView(value, fields) {
  const rest = Object.fromEntries(Object.entries(value).filter(([field]) => !fields.includes(field)));
  return make("div", {}, valueText(rest), fields.map((field) => make("ul", { class: "named", "aria-label": field },
    value[field].slice(0, MOST_NAMED).map(({ name, ...known }) => make("li", {}, make("details", {},
      make("summary", {}, make("b", {}, name), make("span", {}, ` ${valueText(known)}`)), valueText(known)))),
    value[field].length > MOST_NAMED ? make("li", {}, `and ${value[field].length - MOST_NAMED} more`) : "")));
}

/** A value as an element, or as text. */
function valueView(value) {
  const moves = movesOf(value), named = namedIn(value);
  if (named.length) return namedView(value, named);
  if (!moves || !moves.length) return valueWords(value);
  return make("ol", { class: "plan" },
    moves.slice(0, MOST_MOVES)
      .map((move) => make("li", {}, make("b", {}, moveWords(move)), move.why ? ` – ${valueText(move.why)}` : "",
    Array.isArray(move.assumes) && move.assumes.length
      ? make("ul", { class: "assumes", "aria-label": "assumes" },
        move.assumes.map((each) => make("li", {}, valueText(each)))) : "")),
  moves.length > MOST_MOVES ? make("li", {}, `and ${moves.length - MOST_MOVES} more`) : "");
}

/** Puts a view in the place of another: what was opened there, and what has the keyboard, stays so. */
function replaceView(cell, view) {
  const named = (selector) => [...cell.querySelectorAll(`${selector} b`)].map((each) => each.textContent);
  const open = named("[open] summary"), focused = named("summary:focus");
  cell.replaceChildren(view);
  for (const summary of cell.querySelectorAll("summary")) {
    const [name] = [...summary.querySelectorAll("b")].map((each) => each.textContent);
    summary.parentNode.open = open.includes(name);
    if (focused.includes(name)) summary.focus({ preventScroll: true });
  }
}
