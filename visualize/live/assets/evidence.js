// SPDX-License-Identifier: Apache-2.0
// What was known when a question was asked: pictures large, values in a table, and next to each what is so now.
// Rule: that something has changed is marked once; the present value follows quietly.

class Evidence {
  /** @param question data  @param listener {picture(canvas, query), now()} */
  constructor(question, listener) {
    Object.assign(this, { question, listener, lines: [] });
    this.ago = make("small", {});
    const pictures = question.evidence.filter((each) => each.picture),
      values = question.evidence.filter((each) => !each.picture);
    this.element = make("section",
      { class: "evidence", "data-question-evidence": String(question.number),
        "aria-label": `evidence of question ${question.number}` },
      make("h2", {}, "As it was when asked ", this.ago),
      pictures.map((each) => this.picture(each)),
      values.length ? make("table", { class: "facts" },
        make("thead", {}, make("tr", {},
          ["what", "as asked", "now"].map((words) => make("th", { scope: "col" }, words)))),
        make("tbody", {}, values.flatMap((each) => this.values(each)))) : "",
      (question.refused || []).length ? listed("Refused before", question.refused.map((each) => make("li", {}, each)))
        : "",
      this.meanings(question.options));
  }

  /** What each answer means, in full: a narrow button has room for its beginning. */
  meanings(options) {
    const found = options.filter((option) => option.about);
    return found.length ? make("details", { class: "meanings" }, make("summary", {}, "The answers in full"),
      make("dl", {}, found.flatMap((option) => [make("dt", {}, option.name), make("dd", {}, option.about)]))) : "";
  }

  picture(each) {
    const canvas = make("canvas",
      { class: "shot", width: "0", height: "0", role: "img", "aria-label": `${each.key} as it was when asked` });
    const now = make("span", { class: "present" });
    this.listener.picture(canvas, { key: each.key, question: String(this.question.number) });
    this.lines.push({ each, then: "", now, read: () => "", picture: true });
    return make("figure", { "data-evidence": each.key }, canvas,
      make("figcaption", {}, make("code", {}, each.key), ` ${oldness(each)} `, now));
  }

  /** A line, or one for each field of an object. */
  values(each) {
    const { value } = each;
    const known = each.fresh && value !== null && typeof value === "object" && !Array.isArray(value)
      && Object.keys(value).length > 0 && movesOf(value) === null;
    const fields = known ? Object.keys(value) : [""];
    return fields.map((field, index) => {
      const read = (given) => (field ? (given === null || given === undefined ? "unknown" : valueText(given[field]))
        : valueWords(given));
      const then = each.fresh ? read(value) : "unknown", now = make("td", { class: "present" });
      this.lines.push({ each, then, now, read });
      return make("tr", { class: each.fresh ? "fresh" : "stale", "data-evidence": index ? null : each.key,
        "data-field": `${each.key}${field ? `.${field}` : ""}` },
        make("td", {}, make("code", {}, `${each.key}${field ? `.${field}` : ""}`),
          index ? "" : make("small", {}, ` ${oldness(each)}`)), make("td", {},
          each.fresh && !field ? valueView(value) : then), now);
    });
  }

  tick(now, board) {
    write(this.ago, ago(now - this.question.at));
    for (const line of this.lines) this.compare(line, board[line.each.key]);
  }

  compare(line, entry) {
    const { each, then, now, read, picture } = line;
    const unreceived = each.age_s === null || each.age_s === undefined;
    if (!entry || !(unreceived || entry[1] > this.question.at - each.age_s + 0.01)) return;
    const present = picture ? null : read(entry[0]);
    if (!line.changed && present !== then) {
      line.changed = true;
      line.text = make("span", {});
      now.replaceChildren(make("mark", {}, picture ? "newer" : "changed"), " ", picture ? this.newer() : line.text);
    }
    if (line.changed && !picture) write(line.text, present === then ? "as asked again" : present);
  }

  newer() {
    return make("button", { type: "button", class: "link", on: { click: () => this.listener.now() } },
      "show the present picture");
  }
}

/** How old a value was when the question was asked; empty where that means nothing. */
function oldness({ age_s: age, fresh }) {
  if (age === null || age === undefined) return "never received";
  return fresh && age < 0.05 ? "" : `${Number(age).toFixed(1)} s old${fresh ? "" : ", too old"}`;
}

function ago(seconds) {
  return `${Math.max(0, seconds).toFixed(0)} s ago`;
}

/** Text that is the same is not written again, so that a selection in it stays. */
function write(element, words) {
  const text = shown(words);
  if (element.textContent !== text) element.textContent = text;
}
