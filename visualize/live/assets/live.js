// SPDX-License-Identifier: Apache-2.0
// The live page put together: what comes over the line is kept as it is, and drawn at most once a frame.

const FADES_MS = 4000, TICK_MS = 200;
const HANDOVER_MS = 1000; // one that is acknowledged sooner is no news
const LATE_S = 10; // a person who listens is reminded when so little is left
const LOOSE = { orphaned: "its end was not confirmed", refused: "its server refuses to cancel it",
  lost: "its server is gone" };
const TABS = ["now", "talk", "journal", "details"];
const ACTIVE = new Set(["action", "call", "tree", "decision"]);

class Live {
  constructor(token) {
    this.line = new Line(token,
      { message: (kind, data) => this.message(kind, data), line: (word, why) => this.lineIs(word, why) });
    this.state = { mode: "ready", control: "", active: [], questions: [], closed: {}, board: {}, outcome: "", why: "",
      cut: "", paused_at: null, paused_by: "", e_stop_by: "", ended_at: null, faults: [] };
    this.announcer = new Announcer(byId("polite"), byId("urgent"));
    this.taken = new Map();
    this.dirty = new Set();
    this.reached = false;
    this.word = ["away", "connecting …"];
    this.clock = { now: 0, received: null };
    this.asked = new Map();
  }

  async begin() {
    const answer = await this.line.get("/mission");
    if (!answer.ok) return needed((await answer.json().catch(() => ({}))).why
      || `the server answered ${answer.status}`);
    this.data = await answer.json();
    byId("entry").hidden = true;
    this.build();
    this.line.run();
    setInterval(() => this.tick(), TICK_MS);
  }

  build() {
    const { chart, acts, holders, played } = this.data;
    this.state.played = Boolean(played);
    Object.assign(HOLDERS, holders);
    this.chart = new Chart(byId("chart"), chart, { select: (kind, name, more) => this.select(kind, name, more) });
    this.chart.svg.addEventListener("click", () => this.select("", ""));
    const go = (kind, name) => this.go(kind, name);
    this.details = new Details(byId("details"), this.chart.model, { findings: [], coverage: {}, runs: [], go });
    this.details.nothing();
    this.tabs = new Tabs(TABS);
    this.board = new Board(byId("board"), chart.keys);
    this.cameras = new Cameras(byId("cameras"), chart.keys, this.line);
    this.tail = new Tail(byId("steps"), { go });
    this.chat = new Chat(this.line, { notify, who: () => byId("acts").querySelector("#who")?.value.trim() || "" },
      Boolean(this.data.talks));
    byId("tab-talk").hidden = !this.data.talks;
    if (this.data.talks && this.data.listens) this.speak = new Speak(this.line, this.chat.listener, this.data.deaf);
    if (acts) this.acts = new Acts(byId("acts"), byId("stop"), this.line, { notify });
    this.strip = new StateStrip(byId("state"), this.announcer,
      acts ? () => this.acts.order({ command: "resume" }) : null);
    this.follower = new Follower(this.chart, byId("follow"));
    this.legend = new Legend(byId("legend"), { chart, runs: [{}] });
    byId("name").textContent = shown(chart.name);
    byId("version").textContent = shown(chart.version);
    byId("where").textContent =
      shown([this.data.run && `run ${this.data.run}`, this.data.journal].filter(Boolean).join(" · "));
    document.title = shown(chart.name);
    this.listen();
    this.chart.fit();
  }

  listen() {
    const click = (id, act) => byId(id).addEventListener("click", act);
    const keys = new LiveKeys(this);
    click("fit", () => keys.zoom(0));
    click("nearer", () => keys.zoom(1.25));
    click("farther", () => keys.zoom(0.8));
    click("theme", theme);
    click("help", () => byId("keys").showModal());
    click("keys-close", () => byId("keys").close());
    click("menu", () => keys.menu());
  }

  // -- what comes -------------------------------------------------------------------------------------------------

  message(kind, data) {
    this.clock = { now: data.now, received: performance.now() };
    if (kind === "end") {
      this.chat.close();
      return this.lineIs("over", "this page was closed; the run may continue");
    }
    if (kind === "state") this.restart(data);
    else if (kind === "change") this.change(data);
  }

  restart(data) {
    this.state = { ...this.state, ...data };
    this.taken.clear();
    if (data.where) byId("where").textContent = shown(data.where);
    this.tail.begin(data.steps);
    this.talked(data.talk || [], true);
    delete this.state.steps;
    delete this.state.talk;
    for (const each of ["active", "board", "status", "questions"]) this.mark(each);
  }

  /** Lines of the conversation; where there is one, its tab is shown, also on a page that takes no sentence. */
  talked(lines, isWhole) {
    if (!this.chat) return;
    if (isWhole) this.chat.begin(lines);
    else this.chat.add(lines);
    if (lines.length) byId("tab-talk").hidden = false;
  }

  change({ steps, board, talk, ...fields }) {
    if (talk) this.talked(talk, false);
    Object.assign(this.state, fields);
    if (board) {
      this.state.board = { ...this.state.board, ...board };
      this.mark("board");
    }
    for (const each of (steps || []).flatMap((step) => step.taken || [])) this.taken.set(each, performance.now());
    if (steps) {
      this.tail.add(steps);
      this.mark("active");
    }
    if (fields.active) this.mark("active");
    if (fields.questions) this.mark("questions");
    this.mark("status");
  }

  lineIs(word, why) {
    this.reached = word === "live";
    this.word = [word, why];
    if (word === "refused") needed(why);
    this.mark("status");
  }

  /** Nothing more comes of the run. */
  get isOver() {
    return Boolean(this.state.outcome || this.state.cut);
  }

  /** Seconds since the last message. */
  get silent() {
    return this.clock.received === null ? 0 : (performance.now() - this.clock.received) / 1000;
  }

  /** The run's clock now, as far as it is known here; it counts on while the line is away, for the run may continue. */
  get now() {
    return this.clock.now + (UNFINISHED.includes(this.state.mode) && !this.isOver ? this.silent : 0);
  }

  // -- what is shown ----------------------------------------------------------------------------------------------

  mark(what) {
    if (!this.dirty.size) requestAnimationFrame(() => this.draw());
    this.dirty.add(what);
  }

  draw() {
    const dirty = this.dirty;
    this.dirty = new Set();
    if (!this.chart) return;
    if (dirty.has("active")) this.light();
    if (dirty.has("board")) {
      this.board.write(this.state.board);
      this.cameras.look(this.state.board);
    }
    if (dirty.has("questions")) this.ask();
    if (dirty.has("status") || dirty.has("active")) this.status();
    this.tick();
    document.documentElement.dataset.ready = "yes";
  }

  light() {
    const active = new Set(this.state.active), recent = performance.now() - FADES_MS;
    for (const [transition, at] of this.taken) if (at < recent) this.taken.delete(transition);
    this.chart.show({ active, taken: new Set(this.taken.keys()) });
    for (const { group, transitions } of this.chart.arrows) {
      const at = Math.max(0, ...transitions.map((transition) => this.taken.get(transition) || 0));
      if (at) for (const fading of group.getAnimations({ subtree: true })) fading.currentTime = performance.now() - at;
    }
    if (this.taken.size) {
      clearTimeout(this.fading);
      this.fading = setTimeout(() => this.mark("active"), FADES_MS + 50);
    }
    this.follower.go(this.state.active);
  }

  status() {
    const { mode, control, outcome, cut, faults, open_goals: loose } = this.state;
    const away = !this.reached && !this.isOver;
    this.lineWord();
    byId("mode").textContent = cut ? (this.state.played ? "played" : "cut short")
      : away && UNFINISHED.includes(mode) ? `${mode}?`
      : mode;
    byId("mode").dataset.mode = cut ? "cut" : mode;
    byId("control").textContent = holderWords(control).replace(/^the /, "");
    byId("control").dataset.control = control;
    byId("control-here").textContent = `control is with ${holderWords(control)}`;
    this.strip.show(this.state);
    const moving = (loose || [])
      .map(({ number, action, reason }) => `goal ${number} of '${action}' (${LOOSE[reason] || reason})`);
    const warnings = [...(moving.length ? [`the robot may still move: ${moving.join(", ")}`] : []), ...faults];
    this.warn(warnings.slice(0, 4));
    document.body.classList.toggle("disconnected", away);
    document.body.classList.toggle("over", this.isOver);
    const asked = !this.isOver && [...this.asked.values()].some((each) => each.mine);
    const news = asked ? "you are asked" : outcome || byId("mode").textContent;
    document.title = shown(`${news} – ${this.data ? this.data.chart.name : ""}`);
    const waiting = this.waiting();
    this.waits(waiting);
    if (this.acts) this.acts.show(this.state, this.reached, new Set(waiting.map(([, wanted]) => wanted)));
  }

  /** Faults of the run; those that are the same are not written again, so that they are read aloud once. */
  warn(warnings) {
    const text = warnings.join("\n");
    if (text === this.warned) return;
    this.warned = text;
    byId("banner").hidden = !warnings.length;
    byId("banner").replaceChildren(...warnings.map((fault) => make("div", {}, "⚠ ", fault)));
  }

  /** The active states that do nothing until another has control, and who. */
  waiting() {
    if (this.state.mode !== "running" || this.isOver) return [];
    const { states } = this.chart.model;
    return this.state.active.filter((name) => ACTIVE.has((states.get(name) || {}).kind))
      .map((name) => [name, this.chart.model.wanted(name)])
      .filter(([, wanted]) => wanted && wanted !== this.state.control);
  }

  waits(waiting) {
    const words = waiting.map(([name, wanted]) => `${name} waits until control is with ${holderWords(wanted)}`)
      .join(", ");
    const { held_by: by, held_since: since, control } = this.state;
    const seconds = Number(since || 0).toFixed(1);
    const held = `held by ${by} since ${seconds} s, until the operator gives control back with the buttons above`;
    const waits = `${words}; ${holderWords(control)} has it. The mission does not ask for it back:`;
    const text = by && !this.isOver ? `${held}${words ? `: ${words}` : ""}.`
      : words ? `${waits} give it with the buttons above.`
      : "";
    if (text === this.waitText) return;
    this.waitText = text;
    clearTimeout(this.waitTimer);
    const write = () => { byId("waits").textContent = shown(text); };
    if (text && !byId("waits").textContent) this.waitTimer = setTimeout(write, HANDOVER_MS);
    else write();
  }

  lineWord() {
    const [word, why] = this.word, over = this.isOver && word !== "refused";
    byId("line").dataset.line = over ? "over" : word;
    byId("line").textContent = over ? "ended" : word === "live" ? "live" : shown(why);
  }

  ask() {
    const { run } = this.state,
      asked = run === this.askedIn ? this.state.questions : []; // another run has the same numbers
    const open = new Set(asked.map((each) => each.number));
    for (const [number, each] of this.asked) {
      if (open.has(number)) continue;
      this.close(each, number);
    }
    this.askedIn = run;
    for (const question of this.state.questions) {
      const known = this.asked.get(question.number);
      if (known) known.update(question);
      else this.put(question);
    }
  }

  put(question) {
    const run = this.state.run || "", made = new Asked(question, Boolean(this.acts) && this.data.answers, {
      answer: (to, option, parameters) =>
        this.acts.order({ command: "answer", question: to.number, run, option, parameters }),
      notify, go: (kind, name) => this.go(kind, name),
    });
    made.evidence = new Evidence(question,
      { picture: (canvas, query) => this.cameras.picture(canvas, query), now: () => this.present() });
    this.asked.set(question.number, made);
    byId("asked").append(made.element);
    byId("evidence").append(made.evidence.element);
    const { number, text, options, who } = question, answers = options.map((option) => option.name).join(", ");
    const words = made.mine ? `You are asked: ${text} Answers: ${answers}. Press q to answer.`
      : `A question to ${who}: ${text}`;
    this.announcer.once(`asked ${run} ${number}`, words, { urgent: made.mine });
  }

  /** A question is not open any more; the keyboard does not fall out of the page with it. */
  close(asked, number) {
    const had = asked.element.contains(document.activeElement)
      || asked.evidence.element.contains(document.activeElement);
    asked.element.remove();
    asked.evidence.element.remove();
    this.asked.delete(number);
    this.announcer.once(`closed ${this.askedIn || ""} ${number}`, `Question ${number} is closed.`);
    if (had) byId("asked").focus();
  }

  /** What the cameras see now. */
  present() {
    this.tabs.show("now");
    byId("cameras").scrollIntoView({ block: "start" });
  }

  tick() {
    if (!this.board) return;
    this.board.tick(this.now);
    const silence = this.reached || this.isOver || this.clock.received === null ? ""
      : `last message ${this.silent.toFixed(0)} s ago`;
    if (byId("silence").textContent !== silence) byId("silence").textContent = silence;
    const paused = this.state.mode === "paused" && this.state.paused_at !== null,
      now = paused ? this.state.paused_at : this.now;
    for (const each of this.asked.values()) {
      each.tick(now, this.reached && !this.isOver, paused, this.state.closed[each.question.number] || {});
      each.evidence.tick(this.now, this.state.board);
      if (each.mine && !paused && each.seconds < LATE_S && each.long) this.announcer.once(
        `late ${each.question.number}`, `${LATE_S} s left to answer question ${each.question.number}.`,
        { urgent: true });
    }
    if (this.reached) this.cameras.look(this.state.board);
  }

  select(kind, name, places) {
    this.details.show(kind, name, places);
    this.selected = kind === "state" ? name : "";
    this.chart.select(kind, name);
    if (kind) this.tabs.show("details");
  }

  go(kind, name) {
    const state = this.chart.model.stateOf(kind, name);
    if (!state) return;
    if (!this.state.active.includes(state)) this.follower.turn(false);
    this.chart.goTo(state);
    this.select(kind, name);
  }
}

function open(token) {
  window.live = new Live(token);
  return window.live.begin();
}

enter(open, "a run");
