// SPDX-License-Identifier: Apache-2.0
// What can happen now: a button each, in groups; with the inputs of what it takes.

const GROUPS = [["What runs", ["goal", "call", "behaviour"]], ["Events", ["event"]], ["Time", ["time"]],
  ["Facts", ["key", "stale"]], ["The operator, and control", ["command", "control"]]];
const SHORT = ["command", "control"];
const MOST_DIGITS = 9;

class Choices {
  /** @param host element  @param listener {choose(name, values), notify(words)} */
  constructor(host, listener) {
    Object.assign(this, { host, listener, open: new Set() });
  }

  show(state) {
    const focused = document.activeElement?.closest("[data-choice]")?.dataset.choice;
    this.digits = 0;
    const { choices } = state, common = choices.filter((each) => !each.is_rare && !each.is_awaited);
    const sections = [this.awaited(state, choices.filter((each) => each.is_awaited)),
      ...GROUPS.map(([title, kinds]) => this.group(title, common.filter((each) => kinds.includes(each.kind)), state))];
    const rare = choices.filter((each) => each.is_rare);
    this.host.replaceChildren(...sections.flat(),
      ...(rare.length ? [this.folded(`Seldom (${rare.length})`, rare.map((each) => this.one(each)))] : []));
    if (focused) this.host.querySelector(`[data-choice="${CSS.escape(focused)}"]`)?.focus();
  }

  awaited(state, choices) {
    if (!choices.length) return [];
    const asked = state.questions.map((each) => make("div", { "data-question": String(each.number) },
      make("p", { class: "text" }, make("b", {}, `A question to ${each.who}: `), each.text || "",
        make("small", {}, each.until === null ? "" : ` (${(each.until - state.at).toFixed(1)} s left)`)),
      make("table", { class: "board" },
        make("tbody", {}, each.evidence.map((shown) =>
          make("tr", { class: shown.fresh ? "fresh" : "stale" }, make("td", {}, make("code", {}, shown.key)),
            make("td", {}, shown.fresh ? valueView(shown.value) : "unknown")))))));
    return [make("section", { class: "awaited", "data-group": "awaited" }, make("h2", {}, "The mission waits for"),
      asked, choices.map((each) => this.one(each)))];
  }

  group(title, choices, state) {
    if (!choices.length) return [];
    const kind = choices[0].kind;
    const made = kind === "key" ? this.facts(choices, state)
      : make("div", { class: SHORT.includes(kind) ? "short" : "" }, choices.map((each) => this.one(each)));
    return [make("section", { "data-group": kind }, make("h2", {}, title), made)];
  }

  folded(title, children) {
    return make("details", { open: this.open.has(title),
      on: { toggle: (event) => { if (event.target.open) this.open.add(title); else this.open.delete(title); } } },
      make("summary", {}, title), children);
  }

  /** One choice: a button, or a form where it takes values. */
  one(choice) {
    if (choice.fields.length) return this.form(choice, this.words(choice));
    return make("button", { type: "button", class: "choice", "data-choice": choice.name, title: choice.about,
      on: { click: () => this.listener.choose(choice.name, {}) } }, this.words(choice));
  }

  words(choice) {
    const digit = this.digits < MOST_DIGITS && !choice.is_rare ? String((this.digits += 1)) : "";
    return [digit ? make("kbd", { "data-digit": digit }, digit) : "", choice.words,
      choice.about && choice.about.length < 160 ? make("small", {}, choice.about) : "",
      choice.refused ? make("small", { class: "refusal" }, `would be refused now: ${choice.refused}`) : ""];
  }

  form(choice, words) {
    const inputs = choice.fields.map((field) => inputOf(choice, field));
    const send = (event) => {
      event.preventDefault();
      const values = {};
      try {
        inputs.forEach((input, index) => { values[choice.fields[index].name] = input.read(); });
      } catch (error) {
        this.listener.notify(error.message, "bad");
        return;
      }
      inputs.forEach((input) => input.forget());
      this.listener.choose(choice.name, values);
    };
    const button = make("button", { type: "submit", class: "choice", "data-choice": choice.name, title: choice.about },
      words);
    const elements = inputs.map((input) => input.element),
      isOptional = choice.fields.every((field) => !field.is_required);
    return make("form", { class: "given", on: { submit: send } }, isOptional ? [button, elements] : [elements, button]);
  }

  facts(choices, state) {
    const stale = new Map(choices.filter((each) => each.kind === "stale").map((each) => [each.key, each]));
    return choices.filter((each) => each.kind === "key").map((choice) => {
      const name = choice.key, entry = state.board[name], fades = stale.get(name);
      const age = entry ? Math.max(0, state.at - entry[1]) : 0, most = (state.keys[name] || {}).max_age_s;
      const isStale = entry && most && age >= most;
      return make("div", { class: `known${isStale ? " stale" : ""}`, "data-key": name, title: choice.about },
        make("code", {}, name), " ",
        make("span", {}, entry ? `${valueWords(entry[0])}, ${valueText(age)} s old` : "unknown"),
        this.form(choice, "report"),
        fades ? make("button", { type: "button", "data-choice": fades.name, title: fades.about,
          on: { click: () => this.listener.choose(fades.name, {}) } }, "let it go stale") : "");
    });
  }

  press(digit) {
    this.host.querySelector(`[data-digit="${digit}"]`)?.closest("button")?.click();
  }
}
