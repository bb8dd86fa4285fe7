// SPDX-License-Identifier: Apache-2.0
// The wrong answers of a campaign: filtered, sorted, and each opened with its picture, facts, prompt and rollout.

const DATA = JSON.parse(byId("data").textContent);
const AT_ONCE = 40;
const FILTERS = ["mission", "model", "embodiment", "kind", "option", "outcome"];
const SORTS = {
  "what matters most": null,
  model: (each) => each.model,
  kind: (each) => each.kind,
  scene: (each) => each.scene,
  option: (each) => each.option || "",
  "slowest first": (each) => -(each.latency_s || 0),
  "most tokens first": (each) => -(each.tokens || 0),
};
const NO_ANSWER = "no answer";
let limit = AT_ONCE;

/** What came of an answer, in words. */
function outcome(each) {
  if (each.status === "no_answer") return NO_ANSWER;
  if (!each.verdict) return "not offered, refused by the rules";
  if (each.verdict === "harms") return each.refused ? "harms, refused by the rules" : "harms, permitted by the rules";
  return each.refused ? `${each.verdict}, refused by the rules` : each.verdict;
}

function field(each, name) {
  if (name === "outcome") return outcome(each);
  return each[name] || (name === "option" ? NO_ANSWER : "");
}

function chosen() {
  const wanted = FILTERS.map((name) => [name, byId(`filter-${name}`).value]).filter(([, value]) => value !== "");
  const words = byId("filter-text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const found = DATA.answers.filter((each) =>
    wanted.every(([name, value]) => `=${field(each, name)}` === value)
    && words.every((word) => searched(each).includes(word)));
  const key = SORTS[byId("sort").value];
  if (!key) return found;
  const keyed = found.map((each) => [key(each), each]);
  keyed.sort(([a], [b]) => (a < b ? -1 : a > b ? 1 : 0));
  return keyed.map(([, each]) => each);
}

const TEXTS = new Map();

function searched(each) {
  if (!TEXTS.has(each)) {
    const parts = [each.cell, each.scene, each.kind, each.model, each.embodiment, each.option, each.reason, each.error];
    TEXTS.set(each, parts.filter(Boolean).join("\n").toLowerCase());
  }
  return TEXTS.get(each);
}

function show() {
  const found = chosen();
  byId("found").textContent = `${found.length} of ${DATA.answers.length} are shown by these filters`;
  byId("answers").replaceChildren(...found.slice(0, limit).map(card));
  byId("more").hidden = found.length <= limit;
}

function again() {
  limit = AT_ONCE;
  show();
}

function card(each) {
  const harm = each.verdict === "harms";
  const summary = make("summary", {}, make("span", { class: "short" },
    make("strong", {}, each.kind), make("span", {}, each.model), make("span", {}, each.embodiment),
    make("span", {}, "named ", make("strong", {}, each.option || NO_ANSWER)),
    make("span", { class: harm ? "harm" : "muted" }, outcome(each)),
    make("span", {}, `best: ${each.best.join(", ")}`)));
  const made = make("details", { class: "answer" }, summary);
  made.addEventListener("toggle", () => {
    if (made.open && made.childNodes.length === 1) made.append(opened(each));
  });
  return made;
}

function opened(each) {
  const scene = DATA.scenes[each.scene] || { labels: {}, rollouts: {}, pictures: [] };
  const question = DATA.questions[`${each.scene}\n${each.embodiment}`];
  const pictures = scene.pictures.map((entry) =>
    make("figure", {}, pictured(entry, entry.name), make("figcaption", {}, entry.name)));
  return make("div", { class: "body" },
    make("div", {}, pictures.length ? pictures : make("p", { class: "muted" }, "no picture of this scene is stored"),
      make("p", { class: "muted" }, `scene ${each.scene}, seed ${scene.seed}, cell ${each.cell}`),
      make("p", { class: "muted" },
        `options in the order ${each.order}; ${valueText(each.latency_s || 0)} s, ${each.tokens || 0} tokens`)),
    make("div", {}, answerOf(each), rollouts(each, scene, question), facts(question), prompt(question),
      more(each, scene)));
}

function answerOf(each) {
  return [each.reason ? make("p", {}, "The model's reason: ", make("q", {}, each.reason)) : null,
    each.error ? make("p", {}, "Error: ", make("code", {}, each.error)) : null];
}

function rollouts(each, scene, question) {
  const names = Object.keys(scene.labels).sort();
  const permitted = question && Array.isArray(question.permitted) ? question.permitted.map(nameOf) : null;
  return [make("h3", {}, "What physics finds of each option"),
    make("table", {}, make("tbody", {}, names.map((name) => make("tr", {},
      make("td", {}, name === each.option ? make("strong", {}, `${name} (named)`) : name),
      make("td", {}, scene.labels[name], each.best.includes(name) ? " ✓" : ""),
      make("td", {}, permitted === null ? "" : permitted.includes(name) ? "permitted" : "refused by the rules"),
      make("td", {}, valueText(scene.rollouts[name]))))))];
}

function nameOf(option) {
  return option && typeof option === "object" ? String(option.name) : String(option);
}

function facts(question) {
  if (!question) return make("p", { class: "muted" }, "the question is not stored");
  const known = question.facts;
  if (!known || typeof known !== "object") return [make("h3", {}, "Facts"), make("p", {}, valueText(known))];
  return [make("h3", {}, "Facts"), make("table", {}, make("tbody", {}, Object.entries(known).map(([name, value]) =>
    make("tr", {}, make("td", {}, name), make("td", {}, valueText(value))))))];
}

function prompt(question) {
  if (!question) return null;
  const text = Array.isArray(question.prompt) ? question.prompt.map((number) => DATA.pool[number]).join("\n\n")
    : question.prompt;
  return make("details", {}, make("summary", {}, "Prompt"), make("pre", { tabindex: "0" }, text));
}

function more(each, scene) {
  return make("details", {}, make("summary", {}, "Scene and answer as they are stored"),
    make("pre", { tabindex: "0" }, JSON.stringify(scene.spec, null, 1)),
    each.raw ? make("pre", { tabindex: "0" }, each.raw) : null);
}

function begin() {
  const choices = FILTERS.map((name) => {
    const values = [...new Set(DATA.answers.map((each) => field(each, name)))].sort();
    const options = values.map((value) => make("option", { value: `=${value}` }, value));
    return make("label", {}, name, make("select", { id: `filter-${name}`, on: { change: again } },
      make("option", { value: "" }, "all"), options));
  });
  const sort = make("select", { id: "sort", on: { change: again } },
    Object.keys(SORTS).map((name) => make("option", { value: name }, name)));
  const text = make("input",
    { id: "filter-text", type: "search", placeholder: "scene, reason, …", on: { input: again } });
  byId("filters").append(...choices, make("label", {}, "text", text), make("label", {}, "sorted by", sort));
  byId("filters").addEventListener("submit", (event) => event.preventDefault());
  byId("more").addEventListener("click", () => { limit += AT_ONCE; show(); });
  show();
  document.documentElement.dataset.ready = "yes";
}

begin();
