// SPDX-License-Identifier: Apache-2.0
// What changed between two missions, next to the chart of both: what a reviewer must not miss comes first.
// Rule: each change leads to its place in the chart, and the details of a state or transition list what changed in it.

const MARKED = { "+": "added", "-": "removed", "~": "changed" };

class Changes {
  /** @param host element  @param data the page's data  @param details Details, above which they are put */
  constructor(host, data, details) {
    Object.assign(this, { host, details, headline: data.headline, changes: data.changes });
  }

  /** What a reviewer must not miss, for the page's banner. */
  get alarms() {
    return this.changes.some((each) => each.severity === "safety") ? [this.headline] : [];
  }

  draw() {
    const parts = [["safety", "Safety-relevant"], ["other", "Others"]]
      .map(([severity, title]) =>
        this.part(title, severity, this.changes.filter((each) => each.severity === severity)));
    this.host.replaceChildren(make("h2", {}, this.headline), ...parts);
  }

  part(title, severity, changes) {
    if (!changes.length) return "";
    const topics = new Map();
    for (const change of changes) push(topics, change.heading, change);
    return make("section", { class: `part ${severity}` },
      make("h2", {}, `${severity === "safety" ? "⚠ " : ""}${title} (${changes.length})`),
      [...topics].map(([heading, found]) =>
        make("section", {}, make("h3", {}, heading),
          make("ul", { class: "changes" }, found.map((change) => this.item(change))))));
  }

  item(change) {
    const [kind, name] = change.transition ? ["transition", change.transition] : ["state", change.state];
    const words = [make("b", { class: "mark", title: MARKED[change.mark] }, change.mark === "-" ? "−" : change.mark,
      make("span", { class: "away" }, ` ${MARKED[change.mark]} `)), change.sentence];
    const lead = name ? this.details.link(kind, name, words) : make("span", {}, words);
    return make("li", { class: change.severity, "data-place": change.place }, lead,
      change.before ? make("div", { class: "was" }, make("b", {}, "was "), change.before) : "",
      change.after ? make("div", { class: "now" }, make("b", {}, change.mark === "~" ? "now " : ""), change.after) : "",
      make("div", {}, make("code", { class: "muted" }, change.place || "/")));
  }

  /** What changed in what is chosen, above its other details. */
  annotate(kind, name, places) {
    if (kind !== "state" && kind !== "transition") return;
    const wanted = new Set(places || [name]);
    const found = this.changes.filter((each) => (kind === "state" ? each.state === name : wanted.has(each.transition)));
    if (found.length) this.details.host.prepend(
      make("section", { class: "part" }, make("h3", {}, "What changed here"),
        make("ul", { class: "changes" }, found.map((change) => this.item(change)))));
  }
}
