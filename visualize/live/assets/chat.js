// SPDX-License-Identifier: Apache-2.0
// The conversation with the robot: who wrote or spoke what, and by which way the robot's text was made.
// Rule: a line is text and never markup. A model's text is labelled, for it is no statement of the robot's rules.

const MOST_LINES = 200;
const WAYS = {
  rules: "by rule", model: "the model thinks, unchecked", documents: "a quotation", unknown: "no answer known",
};
const UNHEARD = { cut: "interrupted", failed: "not spoken: no one could be reached" };

class Chat {
  /** @param line Line  @param listener {notify(words, kind), who()}  @param talks whether this page takes sentences */
  constructor(line, listener, talks) {
    Object.assign(this, { line, listener, items: new Map(), unread: 0 });
    this.host = byId("talk-lines");
    this.tab = byId("tab-talk");
    this.input = byId("talk-text");
    this.form = byId("talk-form");
    this.form.hidden = !talks;
    byId("talk-none").hidden = talks;
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.send();
    });
    this.tab.addEventListener("click", () => this.read());
    this.follows = true;
    this.host.addEventListener("scroll", () => {
      const { scrollTop } = this.host; // a window made smaller since `end` has more below it
      this.follows = scrollTop === this.top || this.near;
    });
    new ResizeObserver(() => {
      if (this.follows) this.end(); // a window made smaller, or a telephone turned
    }).observe(this.host);
  }

  /** Whether the newest line is in view, or nearly. */
  get near() {
    return this.host.scrollHeight - this.host.scrollTop - this.host.clientHeight < 60;
  }

  get open() {
    return !byId("talk").hidden;
  }

  begin(lines) {
    this.items.clear();
    this.host.replaceChildren();
    for (const each of lines) this.put(each);
    this.end();
  }

  add(lines) {
    const near = this.near;
    for (const each of lines) {
      if (!this.items.has(each.number) && each.by === "robot" && !this.open) this.unread += 1;
      this.put(each);
    }
    if (near) this.end();
    this.count();
  }

  put(line) {
    const made = this.item(line), known = this.items.get(line.number);
    if (known) known.replaceWith(made);
    else this.host.append(made);
    this.items.set(line.number, made);
    while (this.items.size > MOST_LINES) {
      const [first, element] = this.items.entries().next().value;
      element.remove();
      this.items.delete(first);
    }
  }

  item({ by, text, author, channel, way, priority, spoken, repeated }) {
    const robot = by === "robot", name = robot ? "robot" : [by, author].filter(Boolean).join(" ");
    const about = [robot ? WAYS[way] || way : channel, repeated && "repeated", UNHEARD[spoken]].filter(Boolean)
      .join(", ");
    return make("div", { class: `line ${robot ? "robot" : "person"}`, "data-way": way, "data-spoken": spoken,
      "data-priority": priority },
      make("p", { class: "who" }, make("b", {}, name), about ? make("small", {}, ` ${about}`) : ""),
      make("p", { class: "text" }, text));
  }

  async send() {
    const text = this.input.value.trim();
    if (!text) return;
    this.input.value = "";
    const { sent, why } = await this.line.talk(text, this.listener.who());
    if (sent) return;
    if (!this.input.value) this.input.value = text;
    this.listener.notify(`not sent: ${why}`, "bad");
  }

  /** The page is closed: what would be written reaches no one. */
  close() {
    this.form.hidden = true;
    byId("talk-none").textContent = "This page is closed: it takes no more sentences.";
    byId("talk-none").hidden = false;
  }

  /** To the newest line. */
  end() {
    this.host.scrollTop = this.host.scrollHeight;
    this.top = this.host.scrollTop;
  }

  read() {
    this.unread = 0;
    this.count();
    requestAnimationFrame(() => this.end()); // its tab is only being opened
  }

  count() {
    if (this.open) this.unread = 0;
    const words = this.unread ? `Talk (${this.unread})` : "Talk";
    if (this.tab.textContent !== words) this.tab.textContent = words;
  }

  /** Opens the conversation and moves the keyboard to where a sentence is written. */
  focus() {
    this.tab.click();
    if (!this.form.hidden) this.input.focus();
    else this.host.focus();
  }
}
