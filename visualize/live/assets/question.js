// SPDX-License-Identifier: Apache-2.0
// A question that is open: what is known, what is offered, how long there is, and the fields that an answer needs.
// Rule: it is built once a question, so that nothing typed is lost while the run continues.

const SETTLES_MS = 500;

class Asked {
  /** @param question data  @param can whether it may be answered here  @param listener {answer(question, option, parameters), picture(canvas, query), go(name)} */
  constructor(question, can, listener) {
    Object.assign(this, { question, listener, since: performance.now() });
    this.left = make("b", {});
    this.shown = [];
    this.offered = make("p", { class: "muted" });
    this.offers = make("div", {});
    this.mine = can && question.asked === "operator";
    const mine = this.mine;
    this.bar = make("progress", { max: "1", value: "1", "aria-label": "time left" });
    this.buttons = [];
    this.element = make("section", { class: `question${mine ? " mine" : ""}`, "data-question": String(question.number) },
      make("h3", {}, mine ? "You are asked" : `${question.asked} is asked`, make("small", {}, ` question ${question.number}${question.attempt > 1 ? `, attempt ${question.attempt}` : ""}, `, this.state(), " ", this.left)),
      make("p", { class: "text" }, question.text || ""), this.bar,
      make("table", { class: "board" }, make("tbody", {}, question.evidence.map((each) => this.evidence(each)))),
      (question.refused || []).length ? listed("Refused before", question.refused.map((each) => make("li", {}, each))) : "",
      this.offered, this.offers);
    this.offerAll();
  }

  /** What the run reports of it now; fields that a person is filling in stay as they are unless the options have changed. */
  update(question) {
    const same = JSON.stringify(question.options) === JSON.stringify(this.question.options);
    this.question = question;
    if (!same) this.offerAll();
  }

  offerAll() {
    const { options } = this.question;
    this.buttons = [];
    this.offers.replaceChildren(...(this.mine ? options.map((option) => this.offer(option)) : [make("p", {}, "offered: ", options.map((option) => option.name).join(", "))]));
  }

  state() {
    return make("a", { href: hashOf({ state: this.question.state }), on: { click: (event) => { event.preventDefault(); this.listener.go(this.question.state); } } }, this.question.state);
  }

  evidence(each) {
    const picture = each.picture ? make("canvas", { class: "shot", width: "0", height: "0", role: "img", "aria-label": `${each.key} as it was shown` }) : null;
    if (picture) this.listener.picture(picture, { key: each.key, question: String(this.question.number) });
    const then = make("td", {}), now = make("div", { class: "present" });
    this.shown.push({ each, then, now, text: each.fresh ? valueText(each.value) : "unknown" });
    return make("tr", { class: each.fresh ? "fresh" : "stale", "data-evidence": each.key }, make("td", {}, make("code", {}, each.key)),
      make("td", {}, picture || (each.fresh ? valueText(each.value) : "unknown"), now), then);
  }

  /** How long ago it was shown so, and what is so now where that is newer. */
  tickEvidence(now, board) {
    const asked = ago(now - this.question.at);
    for (const { each, then, now: present, text } of this.shown) {
      const unreceived = each.age_s === null, entry = board[each.key];
      write(then, `${unreceived ? "never received" : `${Number(each.age_s).toFixed(1)} s old`} as asked, ${asked}`);
      const isNewer = entry && (unreceived || entry[1] > this.question.at - each.age_s + 0.01);
      const value = !isNewer ? "" : each.picture ? "a newer picture" : valueText(entry[0]);
      const words = !isNewer ? "" : value === text ? `the same ${ago(now - entry[1])}` : `now ${value} (${ago(now - entry[1])})`;
      write(present, words);
      present.className = value === text ? "present muted" : "present changed";
    }
    write(this.offered, `as offered ${asked}`);
  }

  offer(option) {
    const fields = fieldsOf(option.parameters);
    const button = make("button", { type: fields.length ? "submit" : "button", "data-option": option.name }, make("b", {}, option.name), option.about ? ` – ${option.about}` : "");
    const reason = make("div", { class: "reason", role: "status" });
    this.buttons.push({ button, reason, name: option.name });
    if (!fields.length) {
      button.addEventListener("click", () => this.listener.answer(this.question, option.name, {}));
      return make("div", { class: "offer" }, button, reason);
    }
    const send = (event) => {
      event.preventDefault();
      const parameters = {};
      try {
        for (const field of fields) field.read(parameters);
      } catch (error) {
        this.listener.notify(error.message);
        return;
      }
      this.listener.answer(this.question, option.name, parameters);
    };
    return make("form", { class: "offer", on: { submit: send } }, fields.map((field) => field.element), button, reason);
  }

  /** The time left; `now` is the run's, and does not advance while it is paused, as `clock` does not. */
  tick(now, reached, clock, board, closed) {
    this.tickEvidence(clock, board);
    const { at, until } = this.question;
    if (until === null) {
      this.left.textContent = "no deadline";
      this.bar.hidden = true;
    } else {
      const left = Math.max(0, until - now);
      this.left.textContent = `${left.toFixed(left < 10 ? 1 : 0)} s left`;
      this.bar.value = until > at ? Math.min(1, left / (until - at)) : 0;
    }
    const settled = performance.now() - this.since > SETTLES_MS; // who was about to click elsewhere has not answered
    for (const { button, reason, name } of this.buttons) {
      const why = closed[name];
      button.disabled = !reached || !settled || why !== undefined;
      write(reason, why === undefined ? "" : `not now, ${why}`);
    }
  }
}

function ago(seconds) {
  return `${Math.max(0, seconds).toFixed(0)} s ago`;
}

/** Text that is the same is not written again, so that a selection in it stays. */
function write(element, words) {
  const text = shown(words);
  if (element.textContent !== text) element.textContent = text;
}

/** A field for each parameter that a JSON Schema names. */
function fieldsOf(schema) {
  if (!schema) return [];
  const needed = schema.required || [];
  return Object.entries(schema.properties || {}).map(([name, of]) => fieldOf(name, of || {}, needed.includes(name)));
}

function fieldOf(name, of, needed) {
  const choices = Array.isArray(of.enum) ? of.enum : of.type === "boolean" ? [true, false] : null;
  const input = choices
    ? make("select", { name }, needed ? "" : make("option", { value: "" }, "–"), choices.map((each, index) => make("option", { value: String(index) }, valueText(each))))
    : make("input", { name, type: "text", autocomplete: "off", placeholder: of.default !== undefined ? valueText(of.default) : "" });
  const read = (parameters) => {
    if (input.value === "") {
      if (needed && of.default === undefined) throw new Error(`'${name}' is needed`);
      if (of.default !== undefined) parameters[name] = of.default;
      return;
    }
    parameters[name] = choices ? choices[Number(input.value)] : valueOf(name, of, input.value);
  };
  return { element: make("label", {}, `${name}${of.description ? ` (${valueText(of.description)})` : ""} `, input), read };
}

function valueOf(name, of, text) {
  const kinds = [of.type].flat();
  if (kinds.includes("string") || of.type === undefined) return text;
  if (kinds.includes("number") || kinds.includes("integer")) {
    const number = Number(text);
    if (!Number.isFinite(number)) throw new Error(`'${name}' is a number`);
    return number;
  }
  try {
    return JSON.parse(text);
  } catch {
    throw new Error(`'${name}' is JSON (${kinds.join(" or ")})`);
  }
}
