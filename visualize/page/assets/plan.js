// SPDX-License-Identifier: Apache-2.0
// A plan among the values: its moves as a list, each with what it assumes; any other value as its text.

const MOST_MOVES = 60;

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

/** A value as an element, or as text. */
function valueView(value) {
  const moves = movesOf(value);
  if (!moves || !moves.length) return valueWords(value);
  return make("ol", { class: "plan" },
    moves.slice(0, MOST_MOVES)
      .map((move) => make("li", {}, make("b", {}, moveWords(move)), move.why ? ` – ${valueText(move.why)}` : "",
    Array.isArray(move.assumes) && move.assumes.length
      ? make("ul", { class: "assumes", "aria-label": "assumes" },
        move.assumes.map((each) => make("li", {}, valueText(each)))) : "")),
  moves.length > MOST_MOVES ? make("li", {}, `and ${moves.length - MOST_MOVES} more`) : "");
}
