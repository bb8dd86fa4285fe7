// SPDX-License-Identifier: Apache-2.0
// Keeps what is active in view. Moving the chart by hand ends it; a zoom by hand is kept.

class Follower {
  /** @param chart Chart  @param button element that shows whether it follows, and is pressed to change that */
  constructor(chart, button) {
    Object.assign(this, { chart, button, active: [], at: "", zoomed: false });
    button.addEventListener("click", () => this.turn(!this.on));
    chart.svg.addEventListener("wheel", () => { this.zoomed = true; }, { passive: true });
    chart.svg.addEventListener("pointerup", () => { if (chart.gestures.dragged) this.turn(false); }, true);
  }

  get on() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  turn(on) {
    this.button.setAttribute("aria-pressed", String(on));
    this.at = "";
    this.zoomed = false;
    if (on) this.go(this.active);
  }

  /** To the innermost states of those that are active. */
  go(active) {
    this.active = active;
    const { children } = this.chart.model;
    const inner = active.filter((name) => children.has(name)
      && !children.get(name).some((child) => active.includes(child)));
    const at = inner.join(" ");
    if (!this.on || !inner.length || at === this.at) return;
    this.at = at;
    this.chart.reveal(inner);
    if (this.zoomed) this.chart.center(inner[0]);
    else this.chart.frame(inner);
  }
}
