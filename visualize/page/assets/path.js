// SPDX-License-Identifier: Apache-2.0
// The path of a run: each step that changed something, its cause, who answered what and why, and how long it stayed.

const MOST_CHANGES = 2000; // beyond that the slider and its keys lead on

class Path {
  /** @param host element  @param data the page's data  @param player Player */
  constructor(host, data, player) {
    Object.assign(this, { host, data, player, drawn: null, index: 0 });
  }

  /** Marks the step that is shown; what is out of sight is drawn when it is looked at. */
  at(index) {
    this.index = index;
    if (this.host.hidden) return;
    if (this.drawn !== this.player.replay) this.draw();
    const items = [...this.host.querySelectorAll("[data-step]")];
    const here = items.filter((item) => Number(item.dataset.step) <= index).pop();
    for (const item of items) item.removeAttribute("aria-current");
    if (!here) return;
    here.setAttribute("aria-current", "step");
    here.scrollIntoView({ block: "nearest" });
  }

  draw() {
    this.drawn = this.player.replay;
    const run = this.data.runs[this.player.number];
    const changes = this.drawn.changes();
    const moves = changes.filter((index) => this.drawn.step(index).moves.length);
    const until = new Map(moves.map((index, place) => [index, moves[place + 1]]));
    this.host.replaceChildren(make("h2", {}, "Path ", make("small", {}, run.name)),
      make("p", { class: "muted" }, run.outcome ? `${run.outcome}: ${run.why}` : "it has not ended in this journal"),
      make("ol", { class: "path" },
        changes.slice(0, MOST_CHANGES).map((index) => this.change(run, index, until.get(index)))),
      changes.length > MOST_CHANGES
        ? make("p", { class: "muted" }, `and ${changes.length - MOST_CHANGES} more changes, by the slider`) : "");
  }

  change(run, index, next) {
    const step = this.drawn.step(index), { more } = step;
    const stay = next === undefined ? "" : `${(this.drawn.step(next).at - step.at).toFixed(2)} s there`;
    const answered = run.questions.find((each) => each.number === more.answers);
    const isCaused = answered || step.moves.some(([transitions]) => transitions.length);
    return make("li", { "data-step": String(index) },
      link({ run: this.player.number, step: index }, () => this.player.seek(index), `${step.at.toFixed(2)} s`),
      make("div", {}, make("small", {}, stay), this.player.ways(step).map((way) => make("div", {}, way)),
        isCaused ? "" : this.cause(step),
        answered ? make("div", { class: "verdict" }, this.player.proposal(answered), answered.verdict.join("; ")) : "",
        more.outcome ? make("b", {}, `ended ${more.outcome}: ${more.why || ""}`) : ""));
  }

  /** What a step without a transition was about: what it notes, else what happened; and what it had done. */
  cause({ event, more }) {
    return [make("div", {}, (more.notes || []).length ? more.notes.join("; ") : eventWords(event)),
      (more.does || []).map((each) => make("div", { class: "muted" }, each))];
  }
}
