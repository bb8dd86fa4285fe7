// SPDX-License-Identifier: Apache-2.0
// A question that is open: how long there is, what is asked, and the answers with the fields that they need.
// Rule: it is built once a question, so that nothing typed is lost while the run continues. It stays in view whatever
// is scrolled; what was known when it was asked is in `evidence.js`, beneath.

const SETTLES_MS = 500;

class Asked {
  /** @param question data
   *  @param can whether it may be answered here
   *  @param listener {answer(question, option, parameters), notify(words, kind), go(kind, name)} */
  constructor(question, can, listener) {
    Object.assign(this, { question, listener, since: performance.now() });
    this.left = make("b", { class: "left", role: "timer", "aria-live": "off" });
    this.offers = make("div", { class: "offers" });
    this.mine = can && question.asked === "operator";
    const mine = this.mine, title = `asked-${question.number}`;
    this.bar = make("progress", { max: "1", value: "1", "aria-label": "time left" });
    this.buttons = [];
    this.element = make("section",
      { class: `question${mine ? " mine" : ""}`, "data-question": String(question.number), "aria-labelledby": title,
        tabindex: "-1" },
      make("p", { class: "head" }, this.left,
        make("span", {}, make("b", {}, mine ? "You are asked" : `A question to ${question.who}`),
        make("small", {}, make("span", { class: "which" },
          ` question ${question.number}${question.attempt > 1 ? `, attempt ${question.attempt}` : ""},`), " ",
          linksTo(listener.go)("state", question.state)))),
      this.bar, make("h2", { class: "text", id: title, tabindex: "0" }, question.text || `question ${question.number}`),
      this.offers);
    this.offerAll();
  }

  /** What the run reports of it now; fields that a person is filling in stay as they are unless the options have
   *  changed. */
  update(question) {
    const same = JSON.stringify(question.options) === JSON.stringify(this.question.options);
    this.question = question;
    if (!same) this.offerAll();
  }

  offerAll() {
    const { options } = this.question;
    this.buttons = [];
    this.offers.classList.toggle("many", options.length > 6);
    this.offers.replaceChildren(
      ...(this.mine ? options.map((option) => this.offer(option))
        : [make("p", { class: "muted" }, "offered: ", options.map((option) => option.name).join(", "))]));
  }

  /** There was so much time that a reminder near its end is none right after the question. */
  get long() {
    return this.question.until !== null && this.question.until - this.question.at >= 2 * LATE_S;
  }

  /** Moves the keyboard to the first answer that can be given. */
  focus() {
    const first = this.buttons.find(({ button }) => !isOff(button)) || this.buttons[0];
    (first ? first.button : this.element).focus();
  }

  offer(option) {
    const fields = fieldsOf(option.parameters), named = `why-${this.question.number}-${option.name}`;
    const button = make("button",
      { type: "button", "data-option": option.name, "aria-describedby": named, title: option.about || null },
      make("b", {}, option.name, fields.length ? " …" : ""),
      option.about ? make("span", { class: "about" }, option.about) : "");
    const reason = make("div", { class: "reason", id: named }), offer = make("div", { class: "offer" }, button, reason);
    this.buttons.push({ button, reason, name: option.name });
    const answer = (parameters) => isOff(button) || this.listener.answer(this.question, option.name, parameters);
    if (!fields.length) {
      button.addEventListener("click", () => answer({}));
      return offer;
    }
    offer.append(this.form(option, fields, button, answer));
    return offer;
  }

  /** The fields that an answer needs; they are there once the answer is pressed, so that all answers stay in view. */
  form(option, fields, button, answer) {
    const send = (event) => {
      event.preventDefault();
      const parameters = {};
      try {
        for (const field of fields) field.read(parameters);
      } catch (error) {
        this.listener.notify(error.message, "bad");
        return;
      }
      answer(parameters);
    };
    const form = make("form", { hidden: true, on: { submit: send } }, fields.map((field) => field.element),
      make("button", { type: "submit", "data-send": option.name }, "answer ", make("b", {}, option.name)));
    button.setAttribute("aria-expanded", "false");
    button.addEventListener("click", () => {
      form.hidden = !form.hidden;
      button.setAttribute("aria-expanded", String(!form.hidden));
      button.parentElement.classList.toggle("wide", !form.hidden);
      if (!form.hidden) form.querySelector("input, select").focus();
    });
    return form;
  }

  /** The time left; `now` is the run's, and does not advance while it is paused. */
  tick(now, reached, paused, closed) {
    const { at, until } = this.question;
    if (until === null) {
      write(this.left, "no deadline");
      this.bar.hidden = true;
    } else {
      const left = Math.max(0, until - now), part = until > at ? Math.min(1, left / (until - at)) : 0;
      write(this.left, `${left.toFixed(left < 10 ? 1 : 0)} s left${paused ? ", paused" : ""}`);
      this.left.classList.toggle("short", left < 10 && !paused);
      this.bar.value = part;
      this.seconds = left;
    }
    const settled = performance.now() - this.since > SETTLES_MS; // who was about to click elsewhere has not answered
    for (const { button, reason, name } of this.buttons) {
      const why = closed[name];
      turnOff(button, !reached || !settled || why !== undefined);
      write(reason, why === undefined ? "" : `not now, ${why}`);
    }
  }
}

/** A button that may not be pressed now keeps the keyboard's place: it is not disabled, it only does nothing. */
function turnOff(button, off) {
  if (isOff(button) !== off) button.setAttribute("aria-disabled", String(off));
}

function isOff(button) {
  return button.getAttribute("aria-disabled") === "true";
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
    ? make("select", { name }, needed ? "" : make("option", { value: "" }, "–"),
      choices.map((each, index) => make("option", { value: String(index) }, valueText(each))))
    : make("input", { name, type: "text", autocomplete: "off",
      placeholder: of.default !== undefined ? valueText(of.default) : "" });
  const read = (parameters) => {
    if (input.value === "") {
      if (needed && of.default === undefined) throw new Error(`'${name}' is needed`);
      if (of.default !== undefined) parameters[name] = of.default;
      return;
    }
    parameters[name] = choices ? choices[Number(input.value)] : valueOf(name, of, input.value);
  };
  return { element: make("label", {}, `${name}${of.description ? ` (${valueText(of.description)})` : ""} `, input),
    read };
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
