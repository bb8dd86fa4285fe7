// SPDX-License-Identifier: Apache-2.0
// The page of a play put together: what the server reports is shown whole, and every choice is one order.

const TABS = ["choices", "path", "details"];
const ENTRY = "The command that serves it";

class PlayPage {
  constructor(token) {
    this.line = new Line(token, { message: () => {}, line: () => {} });
    this.isBusy = false;
  }

  async begin() {
    const answers = await Promise.all(["/mission", "/play"].map((path) => this.line.get(path)));
    const refused = answers.find((answer) => !answer.ok);
    if (refused) return needed((await refused.json().catch(() => ({}))).why || `the server answered ${refused.status}`,
      ENTRY);
    const [{ chart, holders }, state] = await Promise.all(answers.map((answer) => answer.json()));
    byId("entry").hidden = true;
    this.keys = chart.keys;
    this.holders = holders;
    this.chart = new Chart(byId("chart"), chart,
      { select: (kind, name, more) => this.select(kind, name, more), moved: () => {} });
    this.chart.svg.addEventListener("click", () => this.select("", ""));
    this.details = new Details(byId("details"), this.chart.model,
      { findings: [], coverage: {}, runs: [], go: (kind, name) => this.go(kind, name) });
    this.details.nothing();
    this.tabs = new Tabs(TABS);
    this.choices = new Choices(byId("choices"), { choose: (name, values) => this.order({ do: name, values }), notify });
    this.legend = new Legend(byId("legend"), { chart, runs: [{}] });
    byId("name").textContent = shown(chart.name);
    byId("version").textContent = shown(chart.version);
    document.title = shown(`play: ${chart.name}`);
    this.listen();
    this.chart.fit(READABLE);
    this.show(state);
  }

  listen() {
    const click = (id, act) => byId(id).addEventListener("click", act);
    click("fit", () => this.chart.fit());
    click("nearer", () => this.chart.zoom(1.25));
    click("farther", () => this.chart.zoom(0.8));
    click("theme", theme);
    click("undo", () => this.undo(1));
    click("save", () => this.order({ save: true }));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
    if (/^[1-9]$/.test(event.key)) this.choices.press(event.key);
    else if (event.key === "u") this.undo(1);
    else if (event.key === "s") this.order({ save: true });
    else return;
    event.preventDefault();
  }

  undo(count) {
    if (this.state.length) this.order({ undo: count });
  }

  /** Gives an order; one at a time, so that no click is carried out on another state than the one that was seen. */
  async order(order) {
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      const [status, state] = await this.line.post("/play",
        JSON.stringify({ ...order, revision: this.state.revision }));
      if (state.revision !== undefined) this.show(state);
      const why = state.why_not || (status === 200 ? "" : state.why);
      if (why) notify(why, "bad");
      else if ((state.saved || []).length) notify(state.saved.join("; "), "good");
      else byId("notice").hidden = true;
    } catch {
      notify("the play does not answer; was its command ended?", "bad");
    } finally {
      this.isBusy = false;
    }
  }

  show(state) {
    this.state = state;
    const { mode, control, active, taken, at, held_by: held, outcome, why, length } = state;
    byId("mode").textContent = mode;
    byId("mode").dataset.mode = mode;
    byId("control").textContent = held ? `${this.holders[control]}, the mission is held`
      : this.holders[control] || control;
    byId("control").dataset.control = control;
    byId("clock").textContent = `${valueText(at)} s`;
    byId("undo").disabled = !length;
    byId("save").disabled = !length;
    byId("ended").replaceChildren(
      outcome ? make("p", { class: "outcome" }, make("b", {}, `the mission ended ${outcome}: `), why) : "");
    this.happened(state.path[state.path.length - 1]);
    this.chart.show({ active: new Set(active), taken: new Set(taken) });
    this.follow(new Set(active));
    this.choices.show({ ...state, keys: this.keys });
    this.attend(state);
    this.path(state);
    document.documentElement.dataset.ready = "yes";
    document.documentElement.dataset.revision = String(state.revision);
  }

  /** What came of the last choice, in words. */
  happened(last) {
    byId("happened").replaceChildren(...(last ? [make("b", {}, `${last.words}: `), ...this.came(last)] : []));
  }

  came({ steps }) {
    if (!steps.length) return ["nothing else changed"];
    return steps.flatMap((step) => [
      ...way(step), ...[...(step.verdicts || []), ...(step.notes || [])]
        .map((note) => make("div", { class: "note" }, note)),
      ...(step.effects || []).map((each) => make("div", { class: "muted" }, `→ ${each.about}`)),
      step.outcome ? make("div", {}, `${step.outcome}: ${step.why}`) : "",
    ]);
  }

  path({ path, length, is_saved: saved, file }) {
    byId("tab-path").textContent = `Path (${length})`;
    byId("where").textContent = shown(saved ? `saved in ${file}` : `save writes ${file}`);
    byId("clicks").start = length - path.length + 1;
    byId("clicks").replaceChildren(...path.map((click, index) => make("li", {},
      make("button", { type: "button", title: "go back to before this",
        on: { click: () => this.undo(path.length - index) } }, "back to before"),
      make("small", {}, `${valueText(click.at)} s `), make("b", {}, click.words),
      Object.keys(click.values).length ? ` (${valueText(click.values)})` : "", make("div", {}, this.came(click)))));
  }

  /** Brings into view what is active, where it has changed. */
  follow(active) {
    const inner = [...active]
      .filter((name) => !(this.chart.model.children.get(name) || []).some((child) => active.has(child)));
    if (!inner[0] || inner[0] === this.followed) return;
    this.followed = inner[0];
    this.chart.reveal([inner[0]]);
    if (!this.chart.isSeen(inner[0], true)) this.chart.center(inner[0]);
  }

  /** Has a new question, or the end, in view: the choice that led there may be far below it. */
  attend({ questions, outcome }) {
    const news = `${questions.map((each) => each.number)} ${outcome}`;
    if (news !== this.news && news.trim()) document.querySelector("aside").scrollTop = 0;
    this.news = news;
  }

  select(kind, name, places) {
    this.details.show(kind, name, places);
    this.chart.select(kind, name);
    if (!kind) return;
    this.tabs.show("details");
    document.querySelector("aside").scrollTop = 0;
  }

  go(kind, name) {
    const state = this.chart.model.stateOf(kind, name);
    if (!state) return;
    this.chart.goTo(state);
    this.select(kind, name);
  }
}

/** The states that a step left and entered. */
function way({ exited = [], entered = [] }) {
  const left = exited.filter((name) => !entered.includes(name)).reverse();
  return entered.length || left.length ? [make("div", {}, `${left.join(", ")} → ${entered.join(", ")}`)] : [];
}

function open(token) {
  window.play = new PlayPage(token);
  return window.play.begin();
}

enter(open, "a play", ENTRY);
