// SPDX-License-Identifier: Apache-2.0
// What is in the box of a state at a level of detail, measured: texts, the cells of a decision's options, and a tree.

const LOOKS = {
  "": ["wait", "plain"], action: ["action", "action"], call: ["call", "call"], decision: ["decision", "decision"],
  tree: ["tree", "tree"], mission: ["mission", "mission"], states: ["states", "group"], parallel: ["parallel", "group"],
  each: ["for each", "group"], history: ["history", "plain"], final: ["final", "final"],
};
const LINE = 210, CELL = 128, PAD = 10, LEAD = 1.28, KNOB = 20, COUNT = 34, SECOND = 3.5;

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
      this.texts.push({ x: indent, y: this.h - size * 0.3, text: line, size, bold, tone,
        whole: found.cut ? text : "" });
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
  return marked(transition.mark,
    `${on}${transition.when}${guard}`) + ((transition.do || []).length ? ` / ${transition.do.join("; ")}` : "");
}

/** The sign of a history, as UML writes it. */
function historyName(state) {
  return state.outcome === "deep" ? "H*" : "H";
}

function lookOf(state) {
  if (state.kind === "final") return [state.outcome, `final ${state.outcome}`];
  return LOOKS[state.kind || ""] || LOOKS[""];
}

/** The words at the head of every state, with room for a number behind the name. */
function headed(column, state, detail) {
  const was = state.was ? ` (was ${state.was})` : "";
  named(column, state, marked(state.mark, state.name) + was, detail);
  column.w += detail.counted ? COUNT : 0;
  const [word] = lookOf(state);
  column.add(state.kind === "final" ? `final: ${word}` : state.title || word, 11, { most: detail.all ? 2 : 1 });
}

/** From afar: the name alone. */
function nameBox(state, detail, more = 0) {
  const name = state.kind === "history" ? historyName(state) : state.name;
  const whole = marked(state.mark, name);
  const column = new Column(limitOf(name, detail) + (state.mark ? width(`${state.mark} `, NAME, true) : 0));
  named(column, state, whole, detail);
  const pad = (detail.lines > 1 && !detail.whole ? 8 : 5) + (state.kind === "final" ? SECOND / 2 : 0),
    w = column.w + 2 * pad + more;
  return { w: Math.max(w, 36 + more), h: column.h + 9, texts: column.texts, cells: [], tree: null, at: [pad, 3],
    words: w };
}

/** A name in the lines that there are for it; where others begin alike, the last has where it differs from them. */
function named(column, state, whole, { limit, lines = 2, alikeEnd }) {
  column.add(whole, NAME, { bold: true, most: lines });
  if (!column.texts.some((line) => line.whole)) return;
  column.texts.forEach((line) => Object.assign(line, { whole }));
  const alike = alikeEnd(state.name, limit, lines);
  if (alike !== null) column.texts.at(-1).text = tailOf(whole, column.limit, alike);
  column.w = Math.max(...column.texts.map(({ text }) => width(text, NAME, true)));  // an end may be the wider one
}

/** How wide a name may be: as wide as its widest part that is not broken, where the level leaves parts whole. */
function limitOf(name, { limit, whole }) {
  if (!whole) return limit;
  return Math.min(whole, Math.max(limit, ...name.split(/(?<=[_./])/).map((part) => width(part, NAME, true) + 1)));
}

/** The end of a name, as much as is in a line; where as many letters as another name ends with fill it, what is ahead
 *  of them, to the end of its part. */
function tailOf(name, limit, alike) {
  const all = letters(name);
  const fitting = (end, more) => {
    let begin = 0;
    while (begin < end - 1 && width(`…${all.slice(begin, end).join("")}${more}`, NAME, true) > limit) begin += 1;
    return begin;
  };
  let end = all.length;
  if (end - fitting(end, "") > alike) return `…${all.slice(fitting(end, "")).join("")}`;
  end -= alike;
  while (end < all.length && !"_./".includes(all[end])) end += 1;
  return `…${all.slice(fitting(end, "…"), end).join("")}…`;
}

function footed(column, state, staying) {
  column.add(state.controlled, 10, { tone: "muted" });
  const lost = (transition) =>
    (transition.target && transition.target !== state.name ? ` → ${transition.target}, which is not there` : "");
  staying.slice(0, 3).forEach((transition) =>
    column.add(`↻ ${transitionWords(transition)}${lost(transition)}`, 10, { most: 2 }));
  if (staying.length > 3) column.add(`↻ ${staying.length - 3} more that stay`, 10);
}

function leafBox(state, staying, detail) {
  if (!detail.triggers) return nameBox(state, detail);
  if (state.kind === "history") return historyBox(state);
  const across = detail.turned ? 1 : Math.min(5, Math.max(1, (state.choices || []).length));
  const column = new Column(Math.max(detail.limit, across * (CELL + 14)));
  headed(column, state, detail);
  if (detail.all) described(column, state, staying);
  const box = { w: Math.max(column.w, 60) + 2 * PAD, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [],
    tree: null };
  if (state.choices) withCells(box, state.choices, across, detail);
  return box;
}

/** All that is written of a state. */
function described(column, state, staying) {
  const lines = [...(state.about ? [state.about] : []), ...(state.lines || [])];
  lines.slice(0, 7).forEach((line) => column.add(line, 10, { tone: "muted", most: 3 }));
  if (lines.length > 7) column.add(`… ${lines.length - 7} more lines`, 10, { tone: "muted" });
  footed(column, state, staying);
}

function historyBox(state) {
  const column = new Column(120);
  column.add(historyName(state), 13, { bold: true });
  column.add(marked(state.mark, state.name), 10);
  return { w: Math.max(44, column.w + 2 * PAD), h: column.h + PAD, texts: column.texts, cells: [], tree: null };
}

/** The options below the question, so many side by side. */
function withCells(box, choices, across, detail) {
  let top = box.h - 2;
  for (let from = 0; from < choices.length; from += across) {
    const columns = choices.slice(from, from + across).map((choice) => cellOf(choice, detail));
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

function cellOf(choice, detail) {
  const column = new Column(detail.turned ? LINE : CELL);
  column.add(marked(choice.mark, choice.name), 11, { bold: true });
  if (!detail.all) return { choice, column };
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
function closedBox(state, staying, inside, detail) {
  if (!detail.triggers) return nameBox(state, detail, KNOB);
  const column = new Column(LINE);
  headed(column, state, detail);
  column.add(inside, 10, { tone: "muted", most: 3 });
  if (detail.all) (state.lines || []).slice(0, 3).forEach((line) => column.add(line, 10, { tone: "muted" }));
  if (detail.all) footed(column, state, staying);
  return { w: Math.max(column.w, 60) + 2 * PAD + KNOB, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [],
    tree: null };
}

/** The head of an open one. */
function openHead(state, staying, detail) {
  if (!detail.triggers) return nameBox(state, detail, KNOB);
  const column = new Column(340);
  headed(column, state, detail);
  if (detail.all && state.about) column.add(state.about, 10, { tone: "muted" });
  if (detail.all) (state.lines || []).slice(0, 4).forEach((line) => column.add(line, 10, { tone: "muted" }));
  if (detail.all) footed(column, state, staying);
  const w = column.w + 2 * PAD + KNOB;
  return { w, h: column.h + PAD, texts: column.texts, words: w };
}

/** The transitions of an arrow, with room for a number; those with the same words are counted. */
function arrowBox(transitions, quiet, detail) {
  if (!detail.triggers) return { w: 0, h: 0, texts: [] };
  const column = new Column(150);
  const same = new Map();
  for (const transition of transitions) push(same, transitionWords(transition), transition);
  [...same.values()].slice(0, 3).forEach(([transition, ...more], index) => {
    if (index) column.space(3);
    const trigger = transition.trigger && !transition.trigger.startsWith("after ") ? `on ${transition.trigger}`
      : transition.when;
    column.add(marked(transition.mark, quiet ? "" : trigger) + (more.length ? ` (${more.length + 1} transitions)` : ""),
      10, { bold: true, most: 2 });
    if (detail.all && transition.guard) column.add(transition.trigger ? `[${transition.guard}]` : transition.guard, 10,
      { most: 3 });
    if (detail.all && (transition.do || []).length) column.add(`/ ${transition.do.join("; ")}`, 10,
      { tone: "muted", most: 2 });
  });
  if (same.size > 3) column.add(`and ${same.size - 3} more kinds of transition`, 10, { bold: true });
  const counted = detail.counted ? column.w + 4 : 0, w = column.w + (detail.counted ? COUNT : 0);
  return { w: w + (w ? 10 : 0), h: w ? Math.max(column.h, 13) + 4 : 0, texts: column.texts, counted };
}

/** The mission's own transitions, tried from everywhere. */
function anywhereBox(transitions, detail) {
  const column = new Column(detail.triggers ? 250 : detail.limit);
  column.add("From every state", NAME, { bold: true, most: 3 });
  const words = (transition) =>
    (detail.all ? transitionWords(transition)
      : transition.trigger && !transition.trigger.startsWith("after ") ? `on ${transition.trigger}`
      : transition.when);
  if (!detail.triggers) return { w: column.w + 16, h: column.h + 9, texts: column.texts, cells: [], tree: null };
  transitions.forEach((transition) =>
    column.add(`• ${words(transition)}${transition.target ? ` → ${transition.target}` : " (stays)"}`, 10, { most: 3 }));
  return { w: column.w + 2 * PAD, h: column.h + 2 * PAD - 4, texts: column.texts, cells: [], tree: null };
}

/** An arrow's end that is elsewhere: a sign with the name of its target, from afar a dot. */
function stubBox(name, detail) {
  if (!detail.triggers) return { w: 8, h: 8, texts: [], cells: [], tree: null };
  const column = new Column(150);
  column.add(`→ ${name}`, 11, { most: 1 });
  return { w: column.w + 16, h: column.h + 8, texts: column.texts, cells: [], tree: null };
}
