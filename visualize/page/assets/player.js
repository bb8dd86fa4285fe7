// SPDX-License-Identifier: Apache-2.0
// A run played step by step: what happened, what was known and how fresh, what was asked, answered and judged.

const PLAYED = "a person was the robot (rai-missions try), so it is no evidence of what a robot does";
const TRUTH = [["✗", "false", "no"], ["✓", "true", "yes"], ["?", "unknown", "maybe"]];

class Player {
  /** @param bar element
   *  @param host element
   *  @param data the page's data
   *  @param model Model
   *  @param listener {step(frame), go(kind, name)} */
  constructor(bar, host, data, model, listener) {
    Object.assign(this, { bar, host, data, model, listener, link: linksTo(listener.go), index: 0, number: 0,
      due: false });
    this.replays = new Map();
    this.choice = make("select",
      { "aria-label": "run", on: { change: () => this.use(() => this.turn(Number(this.choice.value), null)) } },
      data.runs.map((run, index) =>
        make("option", { value: String(index) },
          `${run.name}${run.head.played ? " – played" : ""}${run.outcome ? ` – ${run.outcome}` : ""}`)));
    this.slider = make("input",
      { type: "range", min: "0", value: "0", "aria-label": "step",
        on: { input: () => this.use(() => this.seek(Number(this.slider.value))) } });
    this.now = make("output", {});
    this.mark = make("b", { class: "played", hidden: true, title: PLAYED }, "▷ played, no evidence");
    const button = (words, title, act) =>
      make("button", { type: "button", title, "aria-label": title, on: { click: () => this.use(act) } }, words);
    bar.append(this.choice,
      button("|◀", "the change before (shift ,)", () => this.jump(-1)),
      button("◁", "one step back (,)", () => this.seek(this.index - 1)),
      button("▷", "one step on (.)", () => this.seek(this.index + 1)),
      button("▶|", "the next change (shift .)", () => this.jump(1)), this.mark, this.slider, this.now);
  }

  get replay() {
    if (!this.replays.has(this.number)) this.replays.set(this.number,
      new Replay(this.data.runs[this.number], this.model.data.keys));
    return this.replays.get(this.number);
  }

  /** Does what a reader asked of the player, and has the step shown. */
  use(act) {
    this.listener.used();
    act();
  }

  /** To a run and its step; without one to the first step that did something. */
  turn(number, index) {
    this.number = Math.min(Math.max(0, number || 0), this.data.runs.length - 1);
    this.choice.value = String(this.number);
    this.mark.hidden = !this.data.runs[this.number].head.played;
    this.slider.max = String(Math.max(0, this.replay.length - 1));
    this.seek(index ?? this.replay.first());
  }

  jump(way) {
    this.seek(this.replay.moved(this.index, way));
  }

  /** Goes to a step; drawn once a frame, however fast the slider moves. */
  seek(index) {
    this.index = Math.min(Math.max(0, index || 0), Math.max(0, this.replay.length - 1));
    this.slider.value = String(this.index);
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw();
    });
  }

  draw() {
    const run = this.data.runs[this.number];
    if (!this.replay.length) return this.host.replaceChildren(
      make("p", { class: "fault" }, "this journal has no steps"), this.faults(run));
    const step = this.replay.step(this.index), frame = this.replay.at(this.index);
    this.now.textContent = shown(`step ${step.seq} of ${run.count} · ${step.at.toFixed(2)} s`);
    this.now.dataset.index = this.index;
    this.slider.setAttribute("aria-valuetext", this.now.textContent);
    this.host.replaceChildren(this.faults(run), this.event(step), this.asked(step), this.ended(step), this.moves(step),
      this.guards(step), this.board(step, frame), this.does(step), this.questions(run));
    this.listener.step({ active: frame.active, taken: new Set(step.moves.flatMap(([transitions]) => transitions)),
      index: this.index, run: this.number });
  }

  faults(run) {
    return make("div", {}, run.head.played ? make("p", { class: "played" }, `▷ Played: ${PLAYED}.`) : "",
      run.faults.map((fault) => make("p", { class: "fault" }, "⚠ ", fault)));
  }

  event(step) {
    return make("section", {}, make("h2", {}, `Step ${step.seq} `, make("small", {}, `${step.at.toFixed(2)} s`)),
      make("p", {}, eventWords(step.event)));
  }

  ended(step) {
    const { more } = step;
    return make("div", {},
      more.outcome
        ? make("p", { class: "outcome" }, make("b", {}, `the mission ended ${more.outcome}: `), more.why || "")
        : more.why ? make("p", {}, `ignored: ${more.why}`) : "",
      (more.notes || []).map((note) => make("p", { class: "note" }, note)));
  }

  moves(step) {
    if (!step.moves.length) return make("p", { class: "muted" }, "no transition was taken");
    return listed("Taken", this.ways(step).map((way) => make("li", {}, way)));
  }

  /** What a step left and entered, and by which transitions. */
  ways(step) {
    return step.moves.map(([transitions, exited, entered, trigger]) => [
      trigger ? [make("b", {}, trigger), ": "] : "", exited.length ? [exited.join(", "), " → "] : "",
      entered.map((name, index) => [index ? ", " : "", this.link("state", name)]),
      transitions.map((place) => make("div", { class: "muted" }, this.link("transition", place, this.named(place))))]);
  }

  /** A guard's place in words. */
  named(place) {
    const transitions = this.model.transitions.get(place);
    if (!transitions) return place;
    return `${transitions[0].source || "every state"}: ${transitionWords({ ...transitions[0], do: [] })}`;
  }

  guards(step) {
    if (!step.guards.length) return "";
    return make("section", {}, make("h3", {}, "Guards that were looked at"),
      make("ul", { class: "guards" }, step.guards.map(([place, value]) =>
      make("li", { class: TRUTH[value][2] },
        make("b", { title: TRUTH[value][1] }, `${TRUTH[value][0]} ${TRUTH[value][1]} `),
        this.model.transitions.has(place) ? this.link("transition", place, this.named(place)) : place))));
  }

  board(step, frame) {
    const names = Object.keys(this.model.data.keys), written = new Set(step.writes.map(([name]) => name));
    const rows = names.map((name) => {
      const entry = frame.board.get(name);
      if (!entry) return make("tr", { class: "unknown" }, make("td", {}, make("code", {}, name)),
        make("td", {}, "unknown"), make("td", {}, "never received"));
      const [value, stamp] = entry, stale = this.replay.stale(name, stamp, step.at), age = Math.max(0, step.at - stamp);
      return make("tr", { class: `${stale ? "stale" : "fresh"}${written.has(name) ? " written" : ""}`,
        "data-key": name }, make("td", {}, make("code", {}, name)),
        make("td", {}, valueView(value)),
        make("td", { class: "short" }, stale ? make("b", {}, "stale, ") : "",
          `${age.toFixed(age < 10 ? 2 : 0)} s old`));
    });
    return make("section", {}, make("h3", {}, "Blackboard"),
      make("table", { class: "board" }, make("tbody", {}, rows)));
  }

  does(step) {
    return (step.more.does || []).length ? listed("Had done", step.more.does.map((each) => make("li", {}, each))) : "";
  }

  /** The question that is open at this step, or was answered in it. */
  asked(step) {
    const run = this.data.runs[this.number];
    const numbers = [...(step.more.answers ? [step.more.answers] : []), ...(step.more.asks || [])];
    const found = numbers.map((number) => run.questions.find((each) => each.number === number)).filter(Boolean);
    if (!found.length) {
      const open = run.questions.filter((each) => each.step < this.index && each.answered !== undefined
        && each.answered > this.index);
      found.push(...open.slice(-1));
    }
    return make("div", {}, found.map((question) => this.question(question)));
  }

  question(question) {
    const judged = question.answered !== undefined && question.answered <= this.index;
    return make("section", { class: "question" },
      make("h3", {}, `Question ${question.number} to ${question.whom}`,
        question.attempt > 1 ? `, attempt ${question.attempt}` : ""),
      make("p", {}, this.link("state", question.owner.split("#")[0]), " asks “", question.text || "", "”"),
      make("table", { class: "board" },
        make("tbody", {}, question.evidence.map((each) =>
          make("tr", { class: each.fresh ? "fresh" : "stale" }, make("td", {}, make("code", {}, each.key)),
        make("td", {}, each.picture ? pictured(this.data.images[each.picture], `${each.key} as it was shown`)
          : each.fresh ? valueView(each.value)
          : "unknown"),
        make("td", { class: "short" },
          each.age_s === null ? "never received" : `${Number(each.age_s).toFixed(2)} s old`))))),
      this.offered(question),
      (question.refused || []).length ? listed("Refused before", question.refused.map((each) => make("li", {}, each)))
        : "",
      judged ? make("p", { class: "verdict" }, this.proposal(question), question.verdict.join("; "))
        : make("p", { class: "muted" }, `until ${valueText(question.until, 2)} s`));
  }

  offered(question) {
    const state = this.model.states.get(question.owner.split("#")[0]) || {};
    const path = question.owner.split("#")[1];
    const all = path === undefined ? state.choices || []
      : ((state.twigs || []).find((twig) => twig.path === path) || {}).choices || [];
    const offers = new Set(question.options.map((offer) => offer.name));
    const listed_ = all.length ? all : question.options;
    const withheld = question.withheld || {};
    return make("ul", { class: "guards" }, listed_.map((choice) => {
      const why = offers.has(choice.name) ? "" : withheld[choice.name] || "";
      const [mark, look] = offers.has(choice.name) ? ["✓ offered ", "yes"]
        : why === "unknown" ? ["? not offered ", "maybe"]
        : ["✗ not offered ", "no"];
      return make("li", { class: look }, make("b", {}, mark), choice.name,
        choice.guard ? ` – when ${choice.guard}` : " – always open", why ? make("b", {}, `, which was ${why}`) : "");
    }));
  }

  /** What was proposed, ahead of its verdict; where there is no option, the verdict has all that is known. */
  proposal({ whom, proposal }) {
    const { option, why, parameters } = proposal || {};
    if (option === undefined) return make("b", {}, "no answer: ");
    const values = parameters && Object.keys(parameters).length ? ` (${valueText(parameters)})` : "";
    return [make("b", {}, `${whom} answered: `), `${valueText(option)}${values}${why ? ` – “${valueText(why)}”` : ""}`,
      make("br", {}), make("b", {}, "verdict: ")];
  }

  questions(run) {
    if (!run.questions.length) return "";
    return make("details", {}, make("summary", {}, `All ${run.questions.length} questions of this run`),
      make("ol", {}, run.questions.map((each) => make("li", {},
      link({ run: this.number, step: each.answered ?? each.step }, () => this.seek(each.answered ?? each.step),
        `${each.number} to ${each.whom}: ${each.verdict ? each.verdict[0] : "not answered"}`)))));
  }
}

/** What happened, before anything came of it. */
function eventWords({ kind, name, number, data }) {
  return [make("b", {}, kind === "event" ? "event " : kind === "tick" ? "" : `${kind} `),
    kind === "tick" ? "time has passed" : name, number ? ` (number ${number})` : "",
    data && Object.keys(data).length ? `: ${valueText(data)}` : ""];
}
