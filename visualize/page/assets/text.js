// SPDX-License-Identifier: Apache-2.0
// How wide a text is, and where it is broken so that it stays in its box in every script.

const FONTS = getComputedStyle(document.documentElement).getPropertyValue("--sans"); // those that the chart is drawn in
const PEN = document.createElement("canvas").getContext("2d");
const WIDTHS = new Map();
const LETTERS = typeof Intl.Segmenter === "function" ? new Intl.Segmenter(undefined, { granularity: "grapheme" })
  : null;
const LONGEST = 600;
const PLAIN = /^[ -~]*$/;

function width(text, size, bold) {
  const key = `${bold ? "b" : ""}${size}|${text}`;
  let found = WIDTHS.get(key);
  if (found === undefined) {
    PEN.font = `${bold ? "bold " : ""}${size}px ${FONTS}`;
    found = PEN.measureText(text).width;
    if (WIDTHS.size > 50000) WIDTHS.clear();
    WIDTHS.set(key, found);
  }
  return found;
}

function letters(text) {
  if (PLAIN.test(text)) return text.split("");
  return LETTERS ? Array.from(LETTERS.segment(text), (each) => each.segment) : Array.from(text);
}

/** The pieces of a word that is wider than a line: its parts, each with the `_`, `.` or `/` behind it; a part that is
 *  wider still is cut between letters. */
function pieces(word, size, bold, limit) {
  const found = [];
  let piece = "";
  for (const part of word.split(/(?<=[_./])/)) {
    const fits = width(part, size, bold) <= limit;
    if (piece && width(piece + part, size, bold) > limit && (fits || width(piece, size, bold) > limit / 2)) {
      found.push(piece);
      piece = "";
    }
    for (const letter of fits ? [part] : letters(part)) {
      if (piece && width(piece + letter, size, bold) > limit) {
        found.push(piece);
        piece = "";
      }
      piece += letter;
    }
  }
  found.push(piece);
  return found;
}

/** A text in at most so many lines of at most `limit` pixels: {lines, width, cut}. */
function wrapped(given, size, { bold = false, limit = 200, most = 3 } = {}) {
  const text = shown(given).replace(/\s+/g, " ").trim();
  const lines = [];
  let line = "";
  let cut = text.length > LONGEST;
  for (const word of letters(text.slice(0, LONGEST)).join("").split(" ")) {
    const parts = width(word, size, bold) > limit ? pieces(word, size, bold, limit) : [word];
    parts.forEach((part, index) => {
      const joined = line && index === 0 ? `${line} ${part}` : line + part;
      if (line && width(joined, size, bold) > limit) {
        lines.push(line);
        line = part;
      } else {
        line = joined;
      }
    });
    if (lines.length > most) break;
  }
  if (line) lines.push(line);
  if (lines.length > most) {
    lines.length = most;
    cut = true;
  }
  if (cut && lines.length) lines[lines.length - 1] = ended(lines[lines.length - 1], size, bold, limit);
  return { lines, width: Math.max(0, ...lines.map((each) => width(each, size, bold))), cut };
}

/** A line that ends in `…` and still fits. */
function ended(line, size, bold, limit) {
  const all = letters(line);
  while (all.length && width(all.join("") + "…", size, bold) > limit) all.pop();
  return all.join("").trimEnd() + "…";
}
