// SPDX-License-Identifier: Apache-2.0
// What changed between two missions, next to the chart of both: what a reviewer must not miss comes first.
// Rule: each change leads to its place in the chart, and the details of a state or transition list what changed in it.

const MARKED = { "+": "added", "-": "removed", "~": "changed" };

class Changes {
  /** @param page Page whose data has `changes`, `headline` and `versions` */
  constructor(page) {
    this.page = page;
    this.changes = page.data.changes;
    this.host = make("div", { id: "changes", role: "tabpanel", "aria-labelledby": "tab-changes" });
    this.button = make("button", { id: "tab-changes", type: "button", role: "tab", "aria-controls": "changes", on: { click: () => page.tab("changes") } }, "Changes");
    byId("tab-details").before(this.button);
    byId("details").before(this.host);
    this.dress();
    this.follow();
    this.draw();
    const chosen = page.at.transition ? ["transition", page.at.transition] : page.at.state ? ["state", page.at.state] : null;
    if (chosen) this.annotate(...chosen);
    page.tab(chosen ? "details" : "changes");
  }

  dress() {
    const { versions, headline, changes } = this.page.data;
    byId("version").textContent = shown(`${versions[0]} → ${versions[1]}`);
    byId("banner").hidden = !changes.some((each) => each.severity === "safety");
    byId("banner").replaceChildren(`⚠ ${headline}`);
    byId("keys").querySelector("dl").append(make("dt", {}, "s, d"), make("dd", {}, "what is safety-relevant, what changed"));
  }

  /** Adds to what the page does when something is chosen. */
  follow() {
    const { page } = this, tab = page.tab.bind(page), select = page.select.bind(page);
    page.tab = (name) => {
      this.host.hidden = name !== "changes";
      this.button.setAttribute("aria-selected", String(name === "changes"));
      tab(name);
    };
    page.select = (kind, name, places) => {
      select(kind, name, places);
      if (kind === "state" || kind === "transition") this.annotate(kind, name, places);
    };
  }

  draw() {
    const parts = [["safety", "Safety-relevant"], ["other", "Others"]].map(([severity, title]) => this.part(title, severity, this.changes.filter((each) => each.severity === severity)));
    this.host.replaceChildren(make("h2", {}, this.page.data.headline), ...parts);
  }

  part(title, severity, changes) {
    if (!changes.length) return "";
    const topics = new Map();
    for (const change of changes) push(topics, change.heading, change);
    return make("section", { class: `part ${severity}` }, make("h2", {}, `${severity === "safety" ? "⚠ " : ""}${title} (${changes.length})`),
      [...topics].map(([heading, found]) => make("section", {}, make("h3", {}, heading), make("ul", { class: "changes" }, found.map((change) => this.item(change))))));
  }

  item(change) {
    const [kind, name] = change.transition ? ["transition", change.transition] : ["state", change.state];
    const words = [make("b", { class: "mark", title: MARKED[change.mark] }, change.mark === "-" ? "−" : change.mark, make("span", { class: "away" }, ` ${MARKED[change.mark]} `)), change.sentence];
    const lead = name ? this.page.details.link(kind, name, words) : make("span", {}, words);
    return make("li", { class: change.severity, "data-place": change.place }, lead,
      change.before ? make("div", { class: "was" }, make("b", {}, "was "), change.before) : "",
      change.after ? make("div", { class: "now" }, make("b", {}, change.mark === "~" ? "now " : ""), change.after) : "",
      make("div", {}, make("code", { class: "muted" }, change.place || "/")));
  }

  /** What changed in what is chosen, above its other details. */
  annotate(kind, name, places) {
    const wanted = new Set(places || [name]);
    const found = this.changes.filter((each) => (kind === "state" ? each.state === name : wanted.has(each.transition)));
    if (found.length) byId("details").prepend(make("section", { class: "part" }, make("h3", {}, "What changed here"), make("ul", { class: "changes" }, found.map((change) => this.item(change)))));
  }
}

window.review.changes = new Changes(page);
