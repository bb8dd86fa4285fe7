// SPDX-License-Identifier: Apache-2.0
// The strip below the bar that stays while a run waits for its robot, is paused, is being canceled, or has ended,
// with the reason.

/** The state in which a run does not simply continue: {state, sign, title, words}; null where it does. */
function lasting({ mode, outcome, why, cut, played, paused_at: since, paused_by: by, e_stop_by: stopped,
  ended_at: at, awaited_facts: facts }) {
  const when = (seconds) => (typeof seconds === "number" ? ` at ${seconds.toFixed(1)} s` : "");
  if (stopped) return { state: "e_stop", sign: "■", title: "E-stop",
    words: `by ${stopped}${when(at)}: the mission ended ${outcome}, and no one has control.` };
  if (outcome) return { state: outcome, sign: outcome === "succeeded" ? "✓" : "■",
    title: `${played ? "Played, ended" : "Ended"}: ${outcome}`,
    words: `${when(at).trim()}${at === null || at === undefined ? "" : ": "}${why}` };
  if (cut) return { state: "cut", sign: "■", title: played ? "Played" : "Cut short", words: cut };
  const until = facts ? ` It waits for the robot: ${facts}.` : "";
  if (mode === "paused") return { state: "paused", sign: "‖", title: "Paused",
    words: `${by ? `by ${by}` : ""}${when(since)}: timers and events wait.${until}`.trim() };
  if (mode === "canceling") return { state: "canceling", sign: "…", title: "Canceling",
    words: `what runs is brought to its end.${until}` };
  if (facts) return { state: "awaiting", sign: "…", title: "Waiting for the robot",
    words: mode === "ready" ? `${facts}: the mission starts after that.`
      : `${facts}: the mission continues after that. Cancel and E-stop act at once, other orders wait.` };
  return null;
}

class StateStrip {
  /** @param host element
   *  @param announcer Announcer
   *  @param resume function that resumes the run; null where it may not be resumed here */
  constructor(host, announcer, resume) {
    Object.assign(this, { host, announcer, resume, text: "", count: 0 });
  }

  show(state) {
    const found = lasting(state), text = found ? `${found.title} ${found.words}` : "";
    if (text === this.text) return;
    const before = this.state;
    this.text = text;
    this.state = found ? found.state : "";
    this.host.hidden = !found;
    this.host.dataset.state = this.state;
    this.host.replaceChildren(
      ...(found ? [make("span", { "aria-hidden": "true" }, found.sign), make("b", {}, found.title),
        make("span", { class: "why" }, found.words), this.button(found)] : []));
    if (this.host.scrollHeight > this.host.clientHeight) this.host.tabIndex = 0; // so that it is scrolled by keys
    else this.host.removeAttribute("tabindex");
    if (found) this.announcer.once(`state ${text}`, text, { urgent: !["canceling", "awaiting"].includes(found.state) });
    else if (before === "paused") this.announcer.once(`resumed ${++this.count}`, "The mission continues.");
  }

  button({ state }) {
    return state === "paused" && this.resume
      ? make("button", { type: "button", "data-act": "resume-here", on: { click: this.resume } }, "resume")
        : make("span", {});
  }
}