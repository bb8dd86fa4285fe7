// SPDX-License-Identifier: Apache-2.0
// How often each transition was taken over all the runs given, and which never was; sorted by any column.

class Coverage {
  /** @param host element  @param data the page's data  @param model Model  @param listener {go(kind, name)} */
  constructor(host, data, model, listener) {
    Object.assign(this, { host, data, model, link: linksTo(listener.go), by: "order", down: false, seen: false });
    this.transitions = [...model.transitions.values()].map(([transition, ...more], order) => {
      const counts = data.coverage.transitions[transition.place] || [];
      return { order, transition, from: transition.source || "every state",
        words: transitionWords({ ...transition, do: [] }),
        to: [transition, ...more].map((each) => each.target || "(stays)").join(", "), taken: sum(counts),
        runs: counts.filter(Boolean).length };
    });
  }

  draw() {
    const never = this.transitions.filter((each) => !each.taken),
      states = this.model.data.states.filter((state) => state.kind !== "history"); // a history is never active itself
    const unseen = states.filter((state) => !(state.name in this.data.coverage.states));
    const sorted = [...this.transitions].sort((a, b) => this.compare(a, b));
    const runs = this.data.runs.length;
    const head = [["order", "#"], ["from", "state"], ["words", "transition"], ["to", "to"],
      ...(runs ? [["taken", "taken"]] : []), ...(runs > 1 ? [["runs", `runs of ${runs}`]] : [])];
    const taken = `${this.transitions.length - never.length} of ${this.transitions.length} transitions were taken`;
    const entered = `${states.length - unseen.length} of ${states.length} states entered`;
    this.host.replaceChildren(
      make("h2", {}, runs ? "Coverage" : "Transitions"),
      runs ? make("p", {}, `${taken}, ${entered}, in ${runs === 1 ? "one run" : `${runs} runs`}.`) : "",
      make("table", { class: "sorted" },
        make("thead", {}, make("tr", {},
          head.map(([by, words]) =>
            make("th", { "aria-sort": this.by === by ? (this.down ? "descending" : "ascending") : "none" },
        make("button", { type: "button", "data-sort": by, on: { click: () => this.sort(by) } }, words,
          this.by === by ? (this.down ? " ▾" : " ▴") : ""))))),
      make("tbody", {}, sorted.map((each) =>
        make("tr", { class: !runs || each.taken ? "" : "never" }, make("td", {}, String(each.order + 1)),
          make("td", {}, each.from),
        make("td", {}, this.link("transition", each.transition.place, each.words)),
        make("td", {}, each.to),
        runs ? [make("td", { class: "number" }, each.taken ? String(each.taken) : "never"),
          runs > 1 ? make("td", { class: "number" }, String(each.runs)) : ""] : "")))));
    if (runs && unseen.length) this.host.append(
      listed("States never entered", unseen.map((state) => make("li", {}, state.name))));
    this.seen = true;
  }

  compare(a, b) {
    const [x, y] = [a[this.by], b[this.by]];
    const order = typeof x === "number" ? x - y : x < y ? -1 : x > y ? 1 : 0;
    return (this.down ? -order : order) || a.order - b.order;
  }

  sort(by) {
    this.down = this.by === by ? !this.down : by === "taken" || by === "runs";
    this.by = by;
    this.draw();
  }
}
