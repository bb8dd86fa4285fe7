// SPDX-License-Identifier: Apache-2.0
// The switches: each dims all but what answers one question, and gives the answer in words next to the chart.

class Lenses {
  /** @param bar element  @param host element  @param lenses data  @param listener {show(lens), go(kind, name)} */
  constructor(bar, host, lenses, listener) {
    Object.assign(this, { bar, host, lenses, listener, link: linksTo(listener.go), on: "" });
    this.buttons = new Map(lenses.map((lens) => [lens.name, make("button", {
      type: "button", "aria-pressed": "false", title: `${lens.title} (${lens.key})`, "data-lens": lens.name,
      on: { click: () => this.turn(lens.name) },
    }, lens.label)]));
    bar.append(make("span", { class: "muted" }, "Show"), ...this.buttons.values());
  }

  /** Turns a switch on, or off where it is on. */
  turn(name, keep = false) {
    this.on = this.on === name && !keep ? "" : this.buttons.has(name) ? name : "";
    for (const [each, button] of this.buttons) button.setAttribute("aria-pressed", String(each === this.on));
    const lens = this.lenses.find((each) => each.name === this.on);
    this.host.hidden = !lens || !lens.sections.length;
    this.host.replaceChildren(...(lens ? this.words(lens) : []));
    this.listener.show(lens ? { states: new Set(lens.states), transitions: new Set(lens.transitions),
      options: new Set(lens.options), focus: lens.focus } : null);
  }

  byKey(key) {
    const lens = this.lenses.find((each) => each.key === key);
    if (lens) this.turn(lens.name);
    return Boolean(lens);
  }

  words(lens) {
    return [make("h2", {}, lens.title),
      ...lens.sections.map((section) => listed(section.heading, section.items.map((item) => make("li", {},
      item.transition ? this.link("transition", item.transition, item.text)
        : item.state ? this.link("state", item.state, item.text)
        : item.text))))];
  }
}
