// SPDX-License-Identifier: Apache-2.0
// Elements, made without ever reading a text as markup.
// Rule: whatever a mission, a model or a robot reports becomes a text node or an attribute's value, and passes `shown`.

const SVG = "http://www.w3.org/2000/svg";
const UNDRAWN = /[\u0000-\u0008\u000b-\u001f\u007f-\u009f\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;
const PICTURE = /^data:image\/(png|jpeg);base64,[A-Za-z0-9+/=]*$/;

/** A text as it may be shown: nothing in it turns the reading direction of what follows. */
function shown(text) {
  return String(text).replace(UNDRAWN, "\ufffd");
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === "on") {
      for (const [event, act] of Object.entries(value)) element.addEventListener(event, act);
    } else if (value !== undefined && value !== null && value !== false) {
      element.setAttribute(name, value === true ? "" : shown(value));
    }
  }
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === "") continue;
    element.append(child instanceof Node ? child : shown(child));
  }
  return element;
}

function make(tag, attributes, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

function draw(tag, attributes, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function byId(id) {
  return document.getElementById(id);
}

/** The address of what is chosen in a page. */
function hashOf(parts) {
  return "#" + Object.entries(parts).filter(([, value]) => value !== "" && value !== null && value !== undefined)
    .map(([name, value]) => `${name}=${encodeURIComponent(value)}`).join("&");
}

function link(parts, act, words) {
  return make("a", { href: hashOf(parts), on: { click: (event) => { event.preventDefault(); act(); } } }, words);
}

/** What makes links to states and transitions: they call `go(kind, name)`, and have an address for a window of its
 *  own. */
function linksTo(go) {
  return (kind, name, words) => link({ [kind]: name }, () => go(kind, name), words || name);
}

/** From light to dark, or back; until then the page is as the reader's system is. */
function theme() {
  const root = document.documentElement, systemIsDark = matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = (root.dataset.theme || (systemIsDark ? "dark" : "light")) === "dark" ? "light" : "dark";
}

/** A picture that the page holds; anything but a PNG or JPEG is replaced by words. */
function pictured(entry, words) {
  if (!entry || !PICTURE.test(entry.uri || "")) return make("p", { class: "muted" }, "no picture: ",
    (entry || {}).why || "it is not in the page");
  const image = make("img", { alt: words, title: words });
  image.src = entry.uri;
  return image;
}

/** A value in a line, in words. */
function valueText(value, places = 3) {
  if (value === null || value === undefined) return "unknown";
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toFixed(places)));
  if (typeof value === "boolean" || typeof value === "string") return String(value);
  if (Array.isArray(value)) {
    const isObject = (each) => each !== null && typeof each === "object" && !Array.isArray(each);
    return "[" + value.map((each) => valueText(each, places)).join(value.some(isObject) ? "; " : ", ") + "]";
  }
  if (value.picture !== undefined) return `picture ${value.picture}`;
  return Object.entries(value).map(([name, each]) => `${name} ${valueText(each, places) || "none"}`).join(", ");
}

/** Parts of a page of which one is shown, each by the tab that is called as it is. */
class Tabs {
  /** @param names of the parts  @param chosen what is done where a tab is pressed */
  constructor(names, chosen = (name) => this.show(name)) {
    this.names = names;
    for (const name of names) byId(`tab-${name}`).addEventListener("click", () => chosen(name));
    byId(`tab-${names[0]}`).parentElement.addEventListener("keydown", (event) => this.key(event));
  }

  show(name) {
    for (const each of this.names) {
      byId(each).hidden = each !== name;
      byId(`tab-${each}`).setAttribute("aria-selected", String(each === name));
      byId(`tab-${each}`).tabIndex = each === name ? 0 : -1;
    }
  }

  /** The arrows move along the tabs. */
  key(event) {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    const all = [...event.currentTarget.querySelectorAll("[role=tab]:not([hidden])")];
    const next = all[(all.indexOf(event.target) + way + all.length) % all.length];
    next.click();
    next.focus();
    event.preventDefault();
    event.stopPropagation();
  }
}
