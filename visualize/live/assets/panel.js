// SPDX-License-Identifier: Apache-2.0
// Next to the chart: the blackboard with its ages, the cameras, and the journal's tail.

const MOST_STEPS = 100, LOOK_MS = 250;

class Board {
  constructor(host, keys) {
    this.keys = keys;
    this.cells = new Map();
    host.replaceChildren(...Object.entries(keys).map(([name, key]) => {
      const cells = { value: make("td", {}, "unknown"), age: make("td", {}, "never received") };
      cells.row = make("tr", { class: "unknown", "data-key": name, title: key.about || "" },
        make("td", {}, make("code", {}, name)), cells.value, cells.age);
      this.cells.set(name, cells);
      return cells.row;
    }));
  }

  write(board) {
    for (const [name, cells] of this.cells) {
      const entry = board[name];
      if (cells.entry === entry) continue;
      cells.entry = entry;
      const view = entry ? valueView(entry[0]) : "unknown";
      replaceView(cells.value, view instanceof Node ? view : shown(view));
      if (!entry) [cells.row.className, cells.age.textContent] = ["unknown", "not received"];
    }
  }

  /** Ages count on here between two messages of the run. */
  tick(now) {
    for (const [name, cells] of this.cells) {
      if (!cells.entry) continue;
      const age = Math.max(0, now - cells.entry[1]), most = this.keys[name].max_age_s;
      const stale = most !== undefined && most !== null && age >= most;
      const robot = this.keys[name].source === "robot";
      cells.row.className = stale ? "stale" : "fresh";
      const words = robot || stale ? `${stale ? "stale, " : ""}${age.toFixed(age < 10 ? 1 : 0)} s old` : "";
      if (cells.age.textContent !== words) cells.age.textContent = words;
    }
  }
}

/** Pictures, asked for when there is a new one, and never two at once. */
class Cameras {
  constructor(host, keys, line) {
    this.line = line;
    this.seen = new Map();
    const names = Object.keys(keys).filter((name) => keys[name].type === "image");
    host.replaceChildren(...names.map((name) => {
      const canvas = make("canvas",
        { class: "shot", "data-camera": name, width: "0", height: "0", role: "img", "aria-label": name });
      const words = make("figcaption", {}, name, ": nothing seen yet");
      this.seen.set(name, { canvas, words, ref: "", busy: false });
      return make("figure", {}, canvas, words);
    }));
  }

  look(board) {
    for (const [name, each] of this.seen) {
      const value = (board[name] || [])[0], ref = value ? value.picture : "";
      if (!ref || ref === each.ref || each.busy || document.hidden) continue;
      each.busy = true;
      each.ref = ref;
      this.picture(each.canvas, { key: name }).then((why) => {
        each.words.textContent = shown(why ? `${name}: ${why}` : name);
        setTimeout(() => { each.busy = false; }, LOOK_MS);
      });
    }
  }

  /** Draws a picture; why not, where it cannot be. Only what the browser reads as pixels gets in. */
  async picture(canvas, query) {
    try {
      const answer = await this.line.get(`/picture?${new URLSearchParams(query)}`);
      if (!answer.ok) return (await answer.json()).why;
      const kind = answer.headers.get("Content-Type");
      if (kind !== "image/png" && kind !== "image/jpeg") return "no picture";
      const bitmap = await createImageBitmap(await answer.blob());
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
      canvas.getContext("2d").drawImage(bitmap, 0, 0);
      bitmap.close();
      return "";
    } catch {
      return "no picture";
    }
  }
}

class Tail {
  /** @param host element  @param listener {go(kind, name)} */
  constructor(host, listener) {
    Object.assign(this, { host, link: linksTo(listener.go) });
  }

  begin(steps) {
    this.host.replaceChildren(...steps.map((step) => this.item(step)).reverse());
  }

  add(steps) {
    this.host.prepend(...steps.map((step) => this.item(step)).reverse());
    while (this.host.childElementCount > MOST_STEPS) this.host.lastElementChild.remove();
  }

  item(step) {
    return make("li", { value: String(step.seq), class: step.outcome ? "outcome" : "" },
      make("small", {}, `${step.at.toFixed(2)} s `), make("b", {}, happened(step.event)), ...this.way(step),
      [...(step.verdicts || []), ...(step.notes || [])].map((note) => make("div", { class: "note" }, note)),
      step.why ? make("div", { class: step.outcome ? "" : "fault" },
        step.outcome ? `${step.outcome}: ${step.why}` : `refused: ${step.why}`) : "",
      (step.effects || []).map((each) => make("div", { class: "muted" }, each.about)));
  }

  way(step) {
    const left = (step.exited || []).filter((name) => !(step.entered || []).includes(name));
    const into = step.entered || [];
    if (!left.length && !into.length) return [""];
    return [" ", left.reverse().join(", "), " → ",
      ...into.flatMap((name, index) => [index ? ", " : "", this.link("state", name)])];
  }
}

const HOLDERS = {};

/** Who holds control, for a reader: the format's `agent` is the mission itself there. */
function holderWords(name) {
  return Object.hasOwn(HOLDERS, name) ? HOLDERS[name] : name;
}

/** What a step was about, and who did it. */
function happened({ kind, name, number, who, data = {} }) {
  const by = data.by ? ` by ${valueText(data.by)}` : "";
  if (kind === "command") return name === "start" ? "start" : `${name === "kill" ? "e-stop" : name}${by}`;
  if (kind === "proposal") {
    const answer = data.option ? `: ${valueText(data.option)}` : data.absent ? " not: absent" : "";
    return `${data.by && data.by !== name ? valueText(data.by) : who || name} answers question ${number}${answer}`;
  }
  if (kind === "control") return `control to ${holderWords(name)}${by}`;
  if (kind === "accepted" || kind === "result" || kind === "feedback") return `${name} (number ${number})`;
  if (kind === "tick") return "time";
  return name;
}
