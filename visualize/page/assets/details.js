// SPDX-License-Identifier: Apache-2.0
// All that is written of a state or a transition: its definition, what leads here and away, its keys and its times.

const FOUND = 5; // as many as leave the rest of a page in sight

class Details {
  /** @param host element  @param model Model  @param more {findings, coverage, runs, go(kind, name)} */
  constructor(host, model, more) {
    Object.assign(this, { host, model, link: linksTo(more.go) }, more);
  }

  /** What is chosen: a state, the transitions of an arrow, or neither. */
  show(kind, name, places) {
    if (kind === "state") this.state(name);
    else if (kind === "transition") this.transitions(places || [name]);
    else this.nothing();
  }

  nothing() {
    const { data } = this.model;
    const places = new Set(data.transitions.map((transition) => transition.place));
    const count = (kind) => counted(data.states.filter((state) => state.kind === kind).length, kind);
    const parts = [counted(data.states.length, "state"), counted(places.size, "transition"), count("decision"),
      count("final"), counted(data.invariants.length, "invariant")];
    this.host.replaceChildren(
      make("h2", {}, data.name, " ", make("small", {}, versionOf(data))),
      make("p", {}, data.about || ""),
      data.notes.length ? listed("Note", data.notes.map((note) => make("li", {}, note))) : "",
      make("p", { class: "muted" }, `${parts.join(", ")}. Choose a state or a transition.`),
      this.faults(this.findings),
      runList(this.runs),
      this.own(),
      this.keyTable(Object.keys(data.keys), "Blackboard"),
    );
  }

  /** What the check found, errors first; what is more than a reader takes in is folded. */
  faults(found) {
    const sorted = [...found].sort((a, b) => (b.severity === "error") - (a.severity === "error"));
    const items = sorted.map((each) => make("li", { class: each.severity === "error" ? "fault" : "warning" },
      make("b", {}, each.severity === "error" ? "⚠ error " : "△ warning "), make("code", {}, each.place || "/"), " ",
      each.sentence));
    const more = items.splice(FOUND);
    if (!items.length) return "";
    const section = listed("Found by the check", items);
    if (more.length) {
      section.append(make("details", {}, make("summary", {}, `and ${more.length} more`), make("ul", {}, more)));
    }
    return section;
  }

  own() {
    const transitions = this.model.away.get("") || [];
    return transitions.length ? this.transitionList("From every state", transitions) : "";
  }

  state(name) {
    const state = this.model.states.get(name);
    if (!state) return this.nothing();
    const away = this.model.away.get(name) || [], here = this.model.here.get(name) || [], begins = this.begins(name);
    const times = sum((this.coverage.states || {})[name]), around = this.model.chain(name).slice(0, -1);
    this.host.replaceChildren(
      make("h2", {}, marked(state.mark, state.name), " ", make("small", {}, lookOf(state)[0])),
      around.length
        ? make("p", { class: "crumbs" }, around.map((each) => [this.link("state", each), " › "]), name) : "",
      make("p", { class: "muted" }, make("code", {}, state.place)),
      state.about ? make("p", {}, state.about) : "",
      state.title ? make("p", {}, make("b", {}, state.title)) : "",
      this.faults(this.findings.filter((each) => each.place === state.place
        || (each.place.startsWith(`${state.place}/`) && !this.inside(name, each.place)))),
      state.lines || state.controlled
        ? listed("What holds here",
          [...(state.lines || []), state.controlled].filter(Boolean).map((line) => make("li", {}, line))) : "",
      state.choices ? this.choices("Options", state.choices) : "",
      ...(state.twigs || []).filter((twig) => twig.choices).map((twig) => this.choices(twig.text, twig.choices)),
      this.transitionList("Leads away, tried in this order", away),
      this.above(name),
      this.transitionList("Leads here", here),
      begins.length ? listed("Begins here",
        begins.map((parent) => make("li", {}, parent ? this.link("state", parent) : "the mission"))) : "",
      this.times(state),
      this.keyTable([...new Set([...(state.reads || []), ...(state.writes || [])])], "Keys", state),
      this.runs.length ? make("p", {},
        times ? `entered ${times}× in the runs given` : "never entered in the runs given") : "",
      defined(state.definition),
    );
  }

  inside(name, place) {
    return this.model.children.get(name)
      .some((child) => place.startsWith(`${this.model.states.get(child).place}/`)
        || place === this.model.states.get(child).place);
  }

  begins(name) {
    return this.model.data.initials.filter(([, target]) => target === name).map(([parent]) => parent);
  }

  /** Transitions of the states around, which are tried after its own. */
  above(name) {
    const transitions = [...this.model.chain(name).slice(0, -1).reverse(), ""]
      .flatMap((each) => this.model.away.get(each) || []);
    return this.transitionList("Tried after those, from the states around", transitions);
  }

  transitionList(title, transitions) {
    if (!transitions.length) return "";
    return listed(title, transitions.map((transition) => make("li", {},
      this.link("transition", transition.place, transitionWords(transition)),
      transition.target ? [" → ", this.link("state", transition.target)] : " (stays)",
      transition.source ? "" : make("span", { class: "muted" }, " from every state"),
      transition.source && title.startsWith("Leads here") ? [" from ", this.link("state", transition.source)] : "",
      this.taken(transition.place))));
  }

  taken(place) {
    if (!this.runs.length) return "";
    const times = sum((this.coverage.transitions || {})[place]);
    return make("span", { class: times ? "taken" : "never" }, times ? ` ${times}×` : " never taken");
  }

  choices(title, choices) {
    return make("section", {}, make("h3", {}, title),
      make("table", {}, make("thead", {},
        make("tr", {}, ["option", "offered when", "means"].map((each) => make("th", {}, each)))),
      make("tbody", {}, choices.map((choice) =>
        make("tr", {}, make("td", {}, make("b", {}, marked(choice.mark, choice.name))),
        make("td", {}, choice.guard || "always", choice.fallback ? make("b", {}, " (fallback)") : ""),
        make("td", {}, choice.about || "",
          (choice.parameters || []).length ? ` with ${choice.parameters.join(", ")}` : ""))))));
  }

  times(state) {
    const found = [];
    const look = (value, path) => {
      if (Array.isArray(value)) value.forEach((each, index) => look(each, `${path}/${index}`));
      else if (value && typeof value === "object") for (const [word, each] of Object.entries(value)) {
        if (/(_s|attempts)$/.test(word) && typeof each === "number") found.push([`${path}/${word}`.slice(1), each]);
        else look(each, `${path}/${word}`);
      }
    };
    look(state.definition || {}, "");
    return found.length ? listed("Times and limits",
      found.map(([word, value]) =>
        make("li", {}, make("code", {}, word), ` ${value}${word.endsWith("_s") ? " s" : ""}`))) : "";
  }

  keyTable(names, title, state) {
    if (!names.length) return "";
    const keys = this.model.data.keys;
    return make("section", {}, make("h3", {}, title),
      make("table", {}, make("thead", {},
        make("tr", {}, ["key", "type", "source", "believed for", state ? "here" : "about"]
          .map((each) => make("th", {}, each)))),
      make("tbody", {}, names.map((name) => {
        const key = keys[name] || {};
        const use = state ? [(state.reads || []).includes(name) ? "read" : "",
          (state.writes || []).includes(name) ? "written" : ""].filter(Boolean).join(", ") : key.about || "";
        return make("tr", {}, make("td", {}, make("code", {}, name)), make("td", { class: "short" }, key.type || ""),
          make("td", { class: "short" }, key.source || "mission", key.optional ? make("div", {}, "optional") : ""),
          make("td", { class: "short" }, key.max_age_s ? `${key.max_age_s} s` : "ever"), make("td", {}, use));
      }))));
  }

  transition(place) {
    const transitions = this.model.transitions.get(place);
    if (!transitions) return this.nothing();
    const [transition] = transitions, source = transition.source ? this.model.states.get(transition.source) : null;
    const number = Number(place.split("/").pop());
    const written = transition.source ? ((source || {}).definition || {}).transitions : this.model.data.own;
    const option = (transition.options || [])
      .map((name) => ((source || {}).choices || []).find((choice) => choice.name === name)).filter(Boolean);
    this.host.replaceChildren(
      make("h2", {}, transitionWords({ ...transition, do: [] }), " ", make("small", {}, "transition")),
      make("p", { class: "muted" }, make("code", {}, place)),
      make("p", {}, transition.source ? ["from ", this.link("state", transition.source)] : "from every state",
        transitions.some((each) => each.target)
          ? [" to ", transitions.map((each, index) => [index ? ", " : "", this.link("state", each.target)])]
            : ", which is not left"),
      transition.about ? make("p", {}, transition.about) : "",
      listed("What must hold", [
        make("li", {}, make("b", {}, "trigger: "), transition.trigger || "none: as soon as its guard holds"),
        make("li", {}, make("b", {}, "guard: "), transition.guard || "none"),
        ...option.map((choice) =>
          make("li", {}, make("b", {}, `option ${choice.name}: `),
            choice.guard ? `offered when ${choice.guard}` : "always open")),
        transition.internal ? make("li", {}, "internal: the state is neither left nor entered") : "",
      ]),
      (transition.do || []).length ? listed("On the way", transition.do.map((each) => make("li", {}, each))) : "",
      this.faults(this.findings.filter((each) => each.place === place || each.place.startsWith(`${place}/`))),
      this.runs.length ? make("p", {}, "In the runs given:", this.taken(place)) : "",
      defined(transition.definition || (written || [])[number]),
    );
  }

  /** Several transitions that one arrow represents. */
  transitions(places) {
    if (places.length === 1) return this.transition(places[0]);
    const transitions = places.map((place) => this.model.transitions.get(place)[0]);
    this.host.replaceChildren(make("h2", {}, `${transitions.length} transitions `, make("small", {}, "one arrow")),
      this.transitionList("Leads here by", transitions));
  }
}

/** Each run given, how it ended, and what is wrong with its journal. */
function runList(runs) {
  if (!runs.length) return "";
  return listed("Runs", runs.map((run) =>
    make("li", {}, make("b", {}, run.name), `: ${run.outcome || "not ended"}, ${counted(run.count, "step")}`,
      run.why ? ` – ${run.why}` : "",
    run.faults.map((fault) => make("div", { class: "fault" }, "⚠ ", fault)))));
}

/** Of two missions that are compared, both. */
function versionOf(chart) {
  return chart.compared ? `${chart.compared} → ${chart.version}` : chart.version;
}

function listed(title, items) {
  return make("section", {}, make("h3", {}, title), make("ul", {}, items));
}

function counted(number, word) {
  return `${number} ${word}${number === 1 ? "" : "s"}`;
}

function defined(written) {
  return written ? make("details", { open: true }, make("summary", {}, "Definition"),
    make("pre", { tabindex: "0" }, JSON.stringify(written, null, 2))) : "";
}
