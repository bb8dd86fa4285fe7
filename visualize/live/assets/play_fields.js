// SPDX-License-Identifier: Apache-2.0
// The inputs of a choice's values, each by its type.
// Rule: what was typed and not given yet stays, whatever else happens meanwhile.

const NUMBERS = ["number", "integer"];
const TYPED = new Map();

/** @param choice data  @param field data */
function inputOf(choice, field) {
  const key = `${choice.name}|${field.name}`;
  const suggested = field.suggested === null ? "" : textOf(field.suggested);
  const more = { name: field.name, "data-type": field.type, "data-field": field.name,
    title: [field.about, `type ${field.type}`].filter(Boolean).join(", ") };
  const input = field.among.length
    ? make("select", more, field.is_required ? "" : make("option", { value: "" }, "–"),
      field.among.map((each) => make("option", { value: textOf(each) }, valueText(each))))
    : make("input", { ...more, type: "text", autocomplete: "off",
      inputmode: NUMBERS.includes(field.type) ? "decimal" : null, placeholder: field.is_required ? "" : "none" });
  input.value = TYPED.has(key) ? TYPED.get(key) : suggested;
  input.addEventListener("input", () => TYPED.set(key, input.value));
  const examples = field.examples.map((each) => make("option", { value: textOf(each) }));
  const list = examples.length && !field.among.length
    ? make("datalist", { id: `examples ${key}`.replace(/[^a-z0-9_]/g, "-") }, examples) : "";
  if (list) input.setAttribute("list", list.id);
  const label = choice.name === `key ${field.name}` ? "" : field.name.slice(field.name.lastIndexOf(".") + 1);
  if (!label) input.setAttribute("aria-label", field.name);
  return { element: make("label", {},
    field.type === "image" ? make("span", {}, `${label} a test picture`) : [label, input],
    list), read: () => read(field, input), forget: () => TYPED.delete(key) };
}

/** A value as it is typed. */
function textOf(value) {
  return typeof value === "string" ? value : JSON.stringify(value);
}

/** What was typed, as a value; nothing where the input is empty and may be. */
function read(field, input) {
  if (field.type === "image") return field.suggested;
  const text = input.value;
  if (field.among.length) return field.among.find((each) => textOf(each) === text) ?? null;
  if (text === "" && !field.is_required) return null;
  if (field.type === "string") return text;
  if (NUMBERS.includes(field.type)) {
    const number = Number(text);
    if (text.trim() === "" || !Number.isFinite(number)) throw new Error(
      `'${field.name}' is a number, and '${text}' is none`);
    return number;
  }
  try {
    return JSON.parse(text);
  } catch {
    if (field.type === "json") return text;
    throw new Error(`'${field.name}' is JSON of type ${field.type}, such as ${field.type === "list" ? "[]" : "{}"}`);
  }
}
