// SPDX-License-Identifier: Apache-2.0
// What the operator may do: each button an order, and what became of it in words.

const UNFINISHED = ["ready", "running", "paused", "canceling"];
const SURE_MS = 4000;

class Acts {
  /** @param host element
   *  @param stop element for the e-stop, which is never in a menu
   *  @param line Line
   *  @param listener {notify(words, kind)} */
  constructor(host, stop, line, listener) {
    Object.assign(this, { host, line, listener });
    const button = (id, words, title, order) =>
      make("button", { type: "button", "data-act": id, title, on: { click: () => order() } }, words);
    this.who = make("input",
      { id: "who", placeholder: "your name", "aria-label": "your name",
        title: "recorded in the journal with what you do", maxlength: "40", autocomplete: "off" });
    this.who.value = remembered("operator");
    this.who.addEventListener("input", () => remember("operator", this.who.value));
    this.buttons = {
      pause: button("pause", "pause", "timers keep the time left, goals are canceled and begun again",
        () => this.order({ command: "pause" })),
      resume: button("resume", "resume", "continue the mission", () => this.order({ command: "resume" })),
      cancel: button("cancel", "cancel", "leave everything in good order and end the mission",
        () => this.sure("cancel", "really cancel?", { command: "cancel" })),
      take: button("take", "take control", "commands of all others are refused until you give it back",
        () => this.order({ command: "control", to: "operator" })),
      autonomy: button("autonomy", "give to autonomy", "give control to the autonomy stack",
        () => this.order({ command: "control", to: "autonomy" })),
      agent: button("agent", "give to mission", "give control to the mission itself",
        () => this.order({ command: "control", to: "agent" })),
      stop: button("e_stop", "E-STOP", "e-stop: everything stops now, before it is even written down",
        () => this.order({ command: "e_stop" })),
    };
    const { stop: last, ...others } = this.buttons;
    host.replaceChildren(this.who, ...Object.values(others));
    stop.replaceChildren(last);
    host.hidden = stop.hidden = false;
  }

  /** Shows what may be done now. */
  show({ mode, control }, reached, wanted = new Set()) {
    const on = UNFINISHED.includes(mode), { pause, resume, cancel, take, autonomy, agent, stop } = this.buttons;
    pause.hidden = mode === "paused";
    resume.hidden = mode !== "paused";
    pause.disabled = !reached || (mode !== "running" && mode !== "ready");
    resume.disabled = !reached;
    cancel.disabled = !reached || !on || mode === "canceling";
    take.hidden = control === "operator";
    take.disabled = !reached || !on;
    for (const [to, give] of Object.entries({ autonomy, agent })) {
      give.hidden = control !== "operator" && !wanted.has(to);
      give.disabled = !reached || !on;
    }
    stop.disabled = !on;
    if (cancel.disabled) this.calm(cancel);
  }

  /** What cannot be taken back is asked twice. */
  sure(name, words, order) {
    const button = this.buttons[name];
    if (button.dataset.sure) {
      this.calm(button);
      this.order(order);
      return;
    }
    button.dataset.sure = "yes";
    button.dataset.words = button.textContent;
    button.textContent = words;
    this.timer = setTimeout(() => this.calm(button), SURE_MS);
  }

  calm(button) {
    clearTimeout(this.timer);
    if (!button.dataset.sure) return;
    delete button.dataset.sure;
    button.textContent = button.dataset.words;
  }

  async order(order) {
    const name = this.who.value.trim();
    const what = order.option ? `answer '${order.option}'`
      : order.command.replace("_", "-") + (order.to ? ` to ${holderWords(order.to)}` : "");
    this.listener.notify(`${what}: sent …`, "sent");
    const late = () => this.listener.notify(
      `${what}: NO ANSWER – it may or may not have arrived; use the robot's own stop`, "alarm");
    const given = { ...order, by: name ? `operator ${name} (page)` : "operator (page)" };
    const { fate, why } = await this.line.order(given, late);
    if (fate === "done") this.listener.notify(`${what}: done${why ? `, ${why}` : ""}`, "good");
    else if (fate === "refused") this.listener.notify(`${what}: refused. ${why}`, "bad");
    else if (fate === "waiting") this.listener.notify(`${what}: NOT TAKEN YET – ${why}`, "alarm");
    else if (fate === "undelivered") this.listener.notify(
      `${what}: not delivered; the run cannot be reached. Use the robot's own stop`, "alarm");
  }
}

function remembered(name) {
  try {
    return localStorage.getItem(`rai-missions ${name}`) || "";
  } catch {
    return "";
  }
}

function remember(name, value) {
  try {
    localStorage.setItem(`rai-missions ${name}`, value);
  } catch {
    return;
  }
}
