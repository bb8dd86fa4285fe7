// SPDX-License-Identifier: Apache-2.0
// The mission in half a minute, next to its chart: what it is for, where a model is asked, and how it may end.
// Rule: the sentences come from the page's data; here they are only set, and lead to their places.

const CAUSES = 6; // as many as a reader takes in; the others are folded

class Summary {
  /** @param host element  @param data the page's data  @param details Details, for what both show */
  constructor(host, data, details) {
    Object.assign(this, { host, data, details, given: data.summary });
  }

  draw() {
    const { given, data } = this, { chart } = data;
    this.host.replaceChildren(
      make("h2", { class: "purpose" }, given.purpose),
      chart.notes.length ? listed("Note", chart.notes.map((note) => make("li", {}, note))) : "",
      runList(data.runs),
      this.details.faults(data.findings),
      this.invariants(given.invariants),
      make("section", {}, make("h3", {}, "Where a model is asked"), make("p", {}, given.asked),
        given.decisions.map((each) => this.decision(each))),
      make("section", {}, make("h3", {}, "How it may end"),
        make("ul", {}, given.outcomes.map((each) => make("li", {}, each))),
        given.ends.length ? given.ends.map((each) => this.end(each))
          : make("p", { class: "muted" }, "no final: it runs until it is canceled or stopped")),
      listed("What ends it from any state", given.interruptions.map((each) => make("li", {}, each))),
      given.controllers.length
        ? listed("Who commands the actuators", given.controllers.map((each) => make("li", {}, this.fact(each)))) : "",
      this.words(),
    );
  }

  fact(fact) {
    const [kind, name] = fact.transition ? ["transition", fact.transition] : ["state", fact.state];
    return name ? this.details.link(kind, name, fact.text) : fact.text;
  }

  invariants(given) {
    return listed("What must never be false", given.length
      ? given.map((each) => make("li", {}, make("b", {}, each.name), `: ${each.guard}`))
        : [make("li", { class: "muted" }, "nothing is declared: no invariant ends it at once")]);
  }

  decision(given) {
    return make("div", { class: `card decision${given.by_model ? " model" : ""}` },
      make("p", {}, this.details.link("state", given.state, given.state),
        given.by_model ? "" : make("span", { class: "muted" }, " (no model)"), `: “${given.question}”`),
      make("p", {}, given.asked),
      make("p", { class: "silence" }, make("b", {}, given.silence)),
      make("ul", {}, given.options.map((each) => make("li", { title: each.about || null },
        make("b", {}, each.name), " → ",
        each.transition ? this.details.link("transition", each.transition, each.leads) : each.leads,
        make("span", { class: "muted" }, `, ${each.bound}`)))));
  }

  end(given) {
    return make("div", { class: `card end ${given.outcome}` },
      make("p", {}, make("b", { class: "outcome-word" }, given.outcome), " ",
        this.details.link("state", given.state, given.state), given.about ? ` – ${given.about}` : ""),
      given.by_answer ? make("p", {}, "A model's answer alone may lead here.") : "",
      given.causes.length ? this.facts(given.causes.slice(0, CAUSES))
        : make("p", { class: "muted" }, "nothing leads here"),
      given.causes.length > CAUSES
        ? this.folded(`and ${given.causes.length - CAUSES} more transitions`, given.causes.slice(CAUSES)) : "",
      given.does.length ? make("p", {}, make("span", { class: "muted" }, "done there: "), given.does.join("; ")) : "",
      given.proof.length ? make("p", {}, make("span", { class: "muted" }, "proved by: "), given.proof.join("; ")) : "",
      given.before.length ? this.folded("what comes before", given.before) : "");
  }

  facts(given) {
    return make("ul", {}, given.map((each) => make("li", {}, this.fact(each))));
  }

  folded(title, given) {
    return make("details", {}, make("summary", {}, title), this.facts(given));
  }

  words() {
    const words = [
      ["model", "the model",
        "the language model that a run is given; it proposes an option, and may set nothing itself. In the file: "
        + 'ask "agent"'],
      ["rules", "the fixed rules",
        "answers by condition, written in the robot's profile; no model is part of them. In the file: ask \"rules\""],
      ["mission", "controlled by the mission itself",
        "this program commands the actuators there; whether a model is asked is another matter. In the file: "
        + 'control "agent"'],
    ].filter(([key]) => this.given.words.includes(key));
    if (!words.length) return "";
    return make("section", {}, make("h3", {}, "Words"),
      make("dl", { class: "words" }, words.map(([, word, sense]) => [make("dt", {}, word), make("dd", {}, sense)])));
  }
}
