// SPDX-License-Identifier: Apache-2.0
// The review page put together: what the keys, the search and the address ask for, and which part shows it.

const TABS = ["summary", "path", "step", "changes", "details", "transitions"];

class Page {
  constructor(data) {
    this.data = data;
    this.at = {};
    this.findings = data.findings || [];
    this.legend = new Legend(byId("legend"), data);  // ahead of the chart, which fits in the room that is left
    this.chart = new Chart(byId("chart"), data.chart, { select: (kind, name, more) => this.select(kind, name, more) },
      this.findings);
    this.model = this.chart.model;
    const go = (kind, name) => this.go(kind, name);
    this.details = new Details(byId("details"), this.model,
      { findings: this.findings, coverage: data.coverage, runs: data.runs, go });
    this.player = data.runs.length
      ? new Player(byId("player"), byId("step"), data, this.model,
        { step: (frame) => this.played(frame), used: () => byId("path").hidden && this.tab("step"), go }) : null;
    this.path = this.player ? new Path(byId("path"), data, this.player) : null;
    this.summary = data.summary ? new Summary(byId("summary"), data, this.details) : null;
    this.changes = data.changes ? new Changes(byId("changes"), data, this.details) : null;
    this.coverage = new Coverage(byId("transitions"), data, this.model, { go });
    this.lenses = new Lenses(byId("lenses"), byId("lens"), data.lenses, { show: (lens) => this.lit(lens), go });
    this.tabs = new Tabs(TABS, (name) => this.tab(name));
    this.dress();
    this.listen();
    this.chart.fit();
    this.details.nothing();
    if (this.changes) this.tab("changes");
    this.follow();
  }

  dress() {
    const { chart, runs, lenses } = this.data;
    byId("name").textContent = shown(chart.name);
    byId("version").textContent = shown(versionOf(chart));
    byId("player").hidden = !this.player;
    for (const name of ["path", "step"]) byId(`tab-${name}`).hidden = !this.player;
    byId("tab-summary").hidden = !this.summary;
    byId("tab-changes").hidden = !this.changes;
    if (this.changes) this.changes.draw();
    byId("keys").querySelector("dl").append(
      ...lenses.flatMap(({ key, title }) => [make("dt", {}, key), make("dd", {}, title)]));
    if (this.summary) this.summary.draw();
    byId("tab-transitions").textContent = runs.length ? "Coverage" : "Transitions";
    if (runs.length) this.chart.show({ counts: this.data.coverage });
    const faults = [...(this.changes ? this.changes.alarms : []),
      ...this.findings.filter((each) => each.severity === "error").map((each) => each.sentence),
      ...runs.flatMap((run) => run.faults.map((fault) => `${run.name}: ${fault}`))];
    byId("banner").hidden = !faults.length;
    byId("banner").replaceChildren(...faults.slice(0, 3).map((fault) => make("div", {}, "⚠ ", fault)),
      faults.length > 3 ? make("div", {}, `and ${faults.length - 3} more; see the details`) : "");
  }

  listen() {
    const click = (id, act) => byId(id).addEventListener("click", act);
    click("fit", () => this.chart.fit());
    click("nearer", () => this.chart.zoom(1.25));
    click("farther", () => this.chart.zoom(0.8));
    click("open-all", () => this.chart.openAll());
    click("close-all", () => this.chart.closeAll());
    click("theme", theme);
    click("help", () => byId("keys").showModal());
    click("keys-close", () => byId("keys").close());
    click("menu", () => this.menu(byId("menu").getAttribute("aria-expanded") !== "true"));
    document.addEventListener("click", (event) => event.target.closest("#menu, #more") || this.menu(false), true);
    byId("more").addEventListener("click",
      (event) => event.target.closest("button") && !event.target.closest(".tools") && this.menu(false));
    this.chart.svg.addEventListener("click", () => this.select("", ""));
    byId("search").addEventListener("input", () => this.search(byId("search").value));
    byId("search").addEventListener("keydown", (event) => this.searched(event));
    document.addEventListener("keydown", (event) => this.key(event));
    addEventListener("hashchange", () => this.follow());
    addEventListener("beforeprint", () => this.chart.toPaper());
    addEventListener("afterprint", () => this.chart.toScreen());
  }

  key(event) {
    if (event.target.closest("input[type=search], select, dialog") || event.ctrlKey || event.metaKey
      || event.altKey) return;
    const pan = PANS[event.key];
    const acts = {
      "/": () => byId("search").focus(), f: () => this.chart.fit(), "+": () => this.chart.zoom(1.25),
      "=": () => this.chart.zoom(1.25), "-": () => this.chart.zoom(0.8),
      a: () => this.chart.openAll(), c: () => this.chart.closeAll(), t: theme, "?": () => byId("keys").showModal(),
      Escape: () => this.clear(),
      ",": () => this.play((player) => player.seek(player.index - 1)),
      ".": () => this.play((player) => player.seek(player.index + 1)),
      "<": () => this.play((player) => player.jump(-1)), ">": () => this.play((player) => player.jump(1)),
      n: () => this.walk(1), p: () => this.walk(-1), Enter: () => this.at.state && this.chart.toggle(this.at.state),
    };
    if (event.key === "Enter" && event.target.closest("button, a, summary")) return;
    if (pan && event.target.matches("input")) return;
    if (pan) this.chart.gestures.pan(...pan);
    else if (acts[event.key]) acts[event.key]();
    else if (!this.lenses.byKey(event.key)) return;
    event.preventDefault();
  }

  play(act) {
    if (this.player) this.player.use(() => act(this.player));
  }

  /** The bar's menu, on a narrow screen. */
  menu(open) {
    byId("menu").setAttribute("aria-expanded", String(open));
  }

  /** To the next state, or the one before, in the order in which they are written. */
  walk(way) {
    const names = [...this.model.states.keys()];
    const next = (names.indexOf(this.at.state) + way + names.length) % names.length;
    this.go("state", names[this.at.state ? next : way > 0 ? 0 : names.length - 1]);
  }

  clear() {
    this.menu(false);
    byId("search").value = "";
    this.search("");
    if (this.lenses.on) this.lenses.turn(this.lenses.on);
    else this.select("", "");
  }

  tab(name) {
    if (byId(name).hidden) document.querySelector("aside").scrollTop = 0;
    this.tabs.show(name);
    if (name === "path") this.path.at(this.path.index);
    if (name === "transitions" && !this.coverage.seen) this.coverage.draw();
  }

  lit(lens) {
    if (lens && !this.before) this.before = this.chart.viewpoint;
    if (lens && this.model.states.size <= OPEN_AT_FIRST[0]) this.chart.reveal([...lens.states]);
    this.chart.show({ lens });
    this.look(lens);
    this.write({ lens: this.lenses ? this.lenses.on : "" });
  }

  /** Moves to what a switch shows; back to where the reader was when it is turned off. */
  look(lens) {
    const anywhere = lens && (this.model.away.get("") || [])
      .some((transition) => lens.transitions.has(transition.place));
    if (lens) this.chart.frame([...lens.focus, ...(anywhere ? [""] : [])]);
    else if (this.before) {
      this.chart.viewpoint = this.before;
      this.before = null;
    }
  }

  played({ active, taken, index, run }) {
    this.chart.show({ active, taken });
    this.path.at(index);
    this.write({ run: run || "", step: index });
  }

  /** What was chosen in the chart. */
  select(kind, name, places) {
    this.details.show(kind, name, places);
    if (this.changes) this.changes.annotate(kind, name, places);
    this.chart.select(kind, name);
    this.write({ state: kind === "state" ? name : "", transition: kind === "transition" ? name : "" });
    if (!kind) return;
    this.tab("details");
    document.querySelector("aside").scrollTop = 0;
  }

  /** To a state or transition that is named: it is opened, shown and chosen. */
  go(kind, name) {
    const state = this.model.stateOf(kind, name);
    if (!state) return;
    this.chart.goTo(state);
    this.select(kind, name);
  }

  search(words) {
    const wanted = words.trim().toLowerCase();
    const texts_ = (state) =>
      [state.name, state.title, state.about, state.kind, state.outcome, ...(state.lines || []),
        ...(state.choices || []).flatMap((each) => [each.name, each.about, each.guard]),
        ...(state.twigs || []).map((each) => each.text),
        ...(this.model.away.get(state.name) || []).map(transitionWords)];
    const hits = wanted ? [...this.model.states.values()]
      .filter((state) => texts_(state).some((text) => (text || "").toLowerCase().includes(wanted))) : [];
    this.hits = hits.map((state) => state.name);
    this.hit = -1;
    byId("hits").textContent = wanted ? `${hits.length} found` : "";
    this.chart.show({ found: new Set(this.hits) });
  }

  searched(event) {
    if (event.key === "Escape") {
      this.clear();
      byId("search").blur();
    } else if (event.key === "Enter" && (this.hits || []).length) {
      this.hit = (this.hit + (event.shiftKey ? -1 : 1) + this.hits.length) % this.hits.length;
      this.go("state", this.hits[this.hit]);
      byId("search").focus();
    }
  }

  /** Keeps the address such that it leads back here. */
  write(parts) {
    Object.assign(this.at, parts);
    if (this.following) return;
    const hash = hashOf(this.at);
    if (location.hash !== hash) history.replaceState(null, "",
      hash === "#" ? location.pathname + location.search : hash);
  }

  /** Goes where the address leads. */
  follow() {
    const asked = new URLSearchParams(location.hash.slice(1));
    this.following = true;
    if (asked.get("lens")) this.lenses.turn(asked.get("lens"), true);
    if (this.player) this.player.turn(Number(asked.get("run")), asked.has("step") ? Number(asked.get("step")) : null);
    if (asked.get("transition")) this.go("transition", asked.get("transition"));
    else if (asked.get("state")) this.go("state", asked.get("state"));
    else if (this.player && asked.has("step")) this.tab("step");
    this.following = false;
  }
}

const page = new Page(JSON.parse(byId("data").textContent));
window.review = page;
document.documentElement.dataset.ready = "yes";
