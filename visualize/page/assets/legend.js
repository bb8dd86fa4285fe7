// SPDX-License-Identifier: Apache-2.0
// What the chart's forms and colours mean, below it: those that this mission has, in the forms and colours of the
// chart.

const LEGEND = [
  [(state) => state.kind === "decision", { kind: "decision" }, "decision"],
  [(state) => (state.choices || []).some((choice) => choice.fallback), { kind: "", look: "fallback" },
    "fallback: without an answer"],
  [(state) => state.kind === "action", { kind: "action" }, "action"],
  [(state) => state.kind === "call", { kind: "call" }, "service call"],
  [(state) => state.kind === "tree", { kind: "tree" }, "tree"],
  [(state) => state.kind === "mission", { kind: "mission" }, "mission"],
  [(state) => !state.kind, { kind: "" }, "wait"],
  [(state) => ["states", "parallel", "each"].includes(state.kind), { kind: "states" }, "group of states"],
  [(state) => state.region, { kind: "states", region: true }, "region, side by side"],
  [(state) => state.outcome === "succeeded", { kind: "final", outcome: "succeeded" }, "end: succeeded"],
  [(state) => ["failed", "aborted"].includes(state.outcome), { kind: "final", outcome: "failed" },
    "end: failed, aborted"],
  [(state) => state.outcome === "canceled", { kind: "final", outcome: "canceled" }, "end: canceled"],
];

class Legend {
  /** @param host element  @param data the page's data */
  constructor(host, data) {
    const { states } = data.chart;
    const items = LEGEND.filter(([fits]) => states.some(fits)).map(([, state, words]) => this.item(state, words));
    for (const name of new Set(states.filter(({ kind }) => kind === "history").map(historyName))) items.push(
      make("li", {}, make("b", {}, name), " back to where it left"));
    if (data.changes) items.unshift(this.mark("+", "added"), this.mark("−", "removed"), this.mark("~", "changed"));
    if (data.runs.length) items.push(this.item({ kind: "", active: true }, "active"), this.line("taken"));
    const dot = draw("rect", { x: 16, y: 6, width: 8, height: 8, rx: 4 });
    items.push(make("li", { class: "dots" },
      draw("svg", { class: "key", width: 26, height: 20, "aria-hidden": "true" }, draw("path", { d: "M2,10H16" }), dot),
      "leads elsewhere; its name: zoom in"));
    if (new Model(data.chart).hasHubs) items.push(make("li", { class: "unseen" },
      draw("svg", { class: "key", width: 26, height: 20, "aria-hidden": "true" }, draw("path", { d: tipAt(16, 10) })),
      "many arrows lead here: zoom in"));
    host.replaceChildren(make("ul", {}, items));
  }

  mark(sign, word) {
    return this.item({ kind: "", look: word }, [make("b", {}, sign), ` ${word}`]);
  }

  item(state, words) {
    const w = 22, h = 14, look = state.look || lookOf(state)[1];
    const group = draw("g", { class: `swatch ${look}${state.region ? " region" : ""}${state.active ? " active" : ""}`,
      transform: `translate(2,4) scale(0.5)` }, outline(state, { w: 2 * w, h: 2 * h, inner: true }));
    return make("li", {}, draw("svg", { class: "key", width: w + 4, height: h + 6, "aria-hidden": "true" }, group),
      words);
  }

  line(words) {
    return make("li", {}, draw("svg", { class: "key playing", width: 26, height: 20, "aria-hidden": "true" },
      draw("g", { class: "arrow taken" }, draw("path", { class: "line", d: "M2,10H24" }))), words);
  }
}
