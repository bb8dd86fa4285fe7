// SPDX-License-Identifier: Apache-2.0
// The keys of the live page. Rule: no key moves, pauses or stops the robot; these are buttons.

class LiveKeys {
  constructor(live) {
    this.live = live;
    document.addEventListener("keydown", (event) => this.key(event));
    byId("acts").addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button && !button.dataset.sure) this.menu(false); // one that is asked twice keeps it open
    });
  }

  get chart() {
    return this.live.chart;
  }

  key(event) {
    if (event.key === "Escape" && event.target.id === "talk-text") return event.target.blur();
    if ((event.target.closest("input, select, textarea") && event.key !== "Escape") || event.target.closest("dialog")
      || event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (event.key === "Enter" && event.target.closest("button, a, summary")) return;
    const pan = PANS[event.key];
    const acts = {
      q: () => this.question(), c: () => this.live.chat && !byId("tab-talk").hidden && this.live.chat.focus(),
      l: () => byId("follow").click(), n: () => this.walk(1), p: () => this.walk(-1),
      f: () => this.zoom(0), "+": () => this.zoom(1.25), "=": () => this.zoom(1.25), "-": () => this.zoom(0.8),
      t: theme, "?": () => byId("keys").showModal(), Escape: () => this.clear(),
      Enter: () => this.live.selected && this.chart.toggle(this.live.selected),
    };
    if (pan && event.target.closest("#asked, #panel")) return; // there they scroll
    if (pan) this.pan(pan);
    else if (acts[event.key]) acts[event.key]();
    else return;
    event.preventDefault();
  }

  /** To the question that waits for an answer here, else to the first that is open. */
  question() {
    const open = [...this.live.asked.values()], found = open.find((each) => each.mine) || open[0];
    if (found) found.focus();
  }

  pan(way) {
    this.live.follower.turn(false);
    this.chart.gestures.pan(...way);
  }

  /** Larger or smaller, and it stays so; 0 fits the chart into the window. */
  zoom(by) {
    if (by) this.chart.zoom(by);
    else this.chart.fit();
    this.live.follower.zoomed = true;
  }

  walk(way) {
    const names = [...this.chart.model.states.keys()], at = names.indexOf(this.live.selected);
    this.live.go("state", names[at < 0 ? (way > 0 ? 0 : names.length - 1) : (at + way + names.length) % names.length]);
  }

  /** Opens or closes the bar's menu, on a narrow screen. */
  menu(open = byId("menu").getAttribute("aria-expanded") !== "true") {
    const left = !open && byId("more").contains(document.activeElement) && byId("menu").checkVisibility();
    byId("menu").setAttribute("aria-expanded", String(open));
    if (left) byId("menu").focus();
  }

  clear() {
    const open = byId("menu").getAttribute("aria-expanded") === "true";
    this.menu(false);
    if (!open) this.live.select("", "");
  }
}
