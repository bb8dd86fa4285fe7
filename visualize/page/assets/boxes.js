// SPDX-License-Identifier: Apache-2.0
// What is in the box of a state, measured: texts, the cells of a decision's options, and a tree.

const LOOKS = {
  "": ["wait", "plain"], action: ["action", "action"], call: ["call", "call"], decision: ["decision", "decision"],
  tree: ["tree", "tree"], mission: ["mission", "mission"], states: ["states", "group"], parallel: ["parallel", "group"],
  each: ["for each", "group"], history: ["history", "plain"], final: ["final", "final"],
};
const LINE = 210, CELL = 128, PAD = 10, LEAD = 1.28;

/** A column of texts: what is added is below what was. */
class Column {
  constructor(limit) {
    this.limit = limit;
    this.texts = [];
    this.w = 0;
    this.h = 0;
  }

  add(text, size, { bold = false, tone = "ink", most = 2, indent = 0 } = {}) {
    if (!text) return;
    const found = wrapped(text, size, { bold, limit: this.limit - indent, most });
    for (const line of found.lines) {
      this.h += size * LEAD;
      this.texts.push({ x: indent, y: this.h - size * 0.3, text: line, size, bold, tone, whole: found.cut ? text : "" });
    }
    this.w = Math.max(this.w, found.width + indent);
  }

  space(height) {
    this.h += height;
  }
}

function marked(mark, text) {
  return mark ? `${mark} ${text}` : text;
}

/** A transition in words: `on anomaly [guard] / effects`. */
function transitionWords(transition) {
  const on = transition.trigger && !transition.trigger.startsWith("after ") ? "on " : "";
  const guard = transition.guard ? (transition.trigger ? ` [${transition.guard}]` : ` ${transition.guard}`) : "";
  return marked(transition.mark, `${on}${transition.when}${guard}`) + ((transition.do || []).length ? ` / ${transition.do.join("; ")}` : "");
}

function lookOf(state) {
  if (state.kind === "final") return [state.outcome, `final ${state.outcome}`];
  return LOOKS[state.kind || ""] || LOOKS[""];
}

/** The words at the head of every state. */
function headed(column, state) {
  const was = state.was ? ` (was ${state.was})` : "";
  column.add(marked(state.mark, state.name) + was, 13, { bold: true });
  const [word] = lookOf(state);
  column.add(state.kind === "final" ? `final: ${word}` : state.title || word, 11, { most: 2 });
}

function footed(column, state, staying) {
  column.add(state.controlled, 10, { tone: "muted" });
  const lost = (transition) => (transition.target && transition.target !== state.name ? ` → ${transition.target}, which is not there` : "");
  staying.slice(0, 3).forEach((transition) => column.add(`↻ ${transitionWords(transition)}${lost(transition)}`, 10, { most: 2 }));
  if (staying.length > 3) column.add(`↻ ${staying.length - 3} more that stay`, 10);
}

function leafBox(state, staying) {
  if (state.kind === "history") return historyBox(state);
  const column = new Column(state.choices ? Math.max(LINE, Math.min(state.choices.length, 5) * (CELL + 14)) : LINE);
  headed(column, state);
  const lines = [...(state.about ? [state.about] : []), ...(state.lines || [])];
  lines.slice(0, 7).forEach((line) => column.add(line, 10, { tone: "muted", most: 3 }));
  if (lines.length > 7) column.add(`… ${lines.length - 7} more lines`, 10, { tone: "muted" });
  footed(column, state, staying);
  const box = { w: Math.max(column.w, 60) + 2 * PAD, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [], tree: null };
  if (state.choices) withCells(box, state.choices);
  return box;
}

function historyBox(state) {
  const column = new Column(120);
  column.add(state.outcome === "deep" ? "H*" : "H", 13, { bold: true });
  column.add(marked(state.mark, state.name), 10);
  return { w: Math.max(44, column.w + 2 * PAD), h: column.h + PAD, texts: column.texts, cells: [], tree: null };
}

/** The options, side by side below the question, at most five in a row. */
function withCells(box, choices) {
  const across = Math.min(5, choices.length);
  let top = box.h - 2;
  for (let from = 0; from < choices.length; from += across) {
    const columns = choices.slice(from, from + across).map(cellOf);
    const height = Math.max(...columns.map((each) => each.column.h)) + 10;
    let left = 0;
    columns.forEach(({ choice, column }) => {
      const w = Math.max(column.w + 12, 60);
      box.cells.push({ choice, x: left, y: top, w, h: height, texts: column.texts });
      left += w;
    });
    box.w = Math.max(box.w, left);
    top += height;
  }
  spread(box, across);
  box.h = top;
}

function cellOf(choice) {
  const column = new Column(CELL);
  column.add(marked(choice.mark, choice.name), 11, { bold: true });
  column.add(choice.about, 10, { tone: "muted", most: 2 });
  column.add(choice.guard ? `when ${choice.guard}` : choice.fallback ? "" : "always open", 10, { most: 4 });
  if (choice.fallback) column.add("fallback, always open", 10, { bold: true });
  if ((choice.parameters || []).length) column.add(`with ${choice.parameters.join(", ")}`, 10, { tone: "muted" });
  return { choice, column };
}

/** Cells fill the width of their box. */
function spread(box, across) {
  for (let from = 0; from < box.cells.length; from += across) {
    const row = box.cells.slice(from, from + across);
    const more = (box.w - row.reduce((sum, cell) => sum + cell.w, 0)) / row.length;
    let left = 0;
    for (const cell of row) {
      cell.x = left;
      cell.w += more;
      left += cell.w;
    }
  }
}

/** A state that holds others, closed: what is inside is given in numbers. */
function closedBox(state, staying, inside) {
  const column = new Column(LINE);
  headed(column, state);
  column.add(inside, 10, { tone: "muted", most: 3 });
  (state.lines || []).slice(0, 3).forEach((line) => column.add(line, 10, { tone: "muted" }));
  footed(column, state, staying);
  return { w: Math.max(column.w, 60) + 2 * PAD + 16, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [], tree: null };
}

/** The head of an open one. */
function openHead(state, staying) {
  const column = new Column(340);
  headed(column, state);
  if (state.about) column.add(state.about, 10, { tone: "muted" });
  (state.lines || []).slice(0, 4).forEach((line) => column.add(line, 10, { tone: "muted" }));
  footed(column, state, staying);
  return { w: column.w + 2 * PAD + 18, h: column.h + PAD, texts: column.texts };
}

/** The transitions of an arrow; those with the same words are counted. */
function arrowBox(transitions, quiet) {
  const column = new Column(150);
  const same = new Map();
  for (const transition of transitions) push(same, transitionWords(transition), transition);
  [...same.values()].slice(0, 3).forEach(([transition, ...more], index) => {
    if (index) column.space(3);
    const trigger = transition.trigger && !transition.trigger.startsWith("after ") ? `on ${transition.trigger}` : transition.when;
    column.add(marked(transition.mark, quiet ? "" : trigger) + (more.length ? ` (${more.length + 1} transitions)` : ""), 10, { bold: true, most: 2 });
    if (transition.guard) column.add(transition.trigger ? `[${transition.guard}]` : transition.guard, 10, { most: 3 });
    if ((transition.do || []).length) column.add(`/ ${transition.do.join("; ")}`, 10, { tone: "muted", most: 2 });
  });
  if (same.size > 3) column.add(`and ${same.size - 3} more kinds of transition`, 10, { bold: true });
  return { w: column.w + (column.w ? 8 : 0), h: column.h + (column.h ? 4 : 0), texts: column.texts };
}

/** The mission's own transitions, tried from everywhere. */
function anywhereBox(transitions) {
  const column = new Column(250);
  column.add("From every state", 12, { bold: true });
  transitions.forEach((transition) => column.add(`• ${transitionWords(transition)}${transition.target ? ` → ${transition.target}` : " (stays)"}`, 10, { most: 3 }));
  return { w: column.w + 2 * PAD, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [], tree: null };
}
