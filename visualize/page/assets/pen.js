// SPDX-License-Identifier: Apache-2.0
// A laid out view drawn: each box, sign and arrow as an element that can be chosen.

/** Draws a view at a level of detail; what it makes is also in `made`: groups by state, arrows, the sign of every
 *  state. */
class Pen {
  constructor(chart, detail, made) {
    Object.assign(this, { chart, detail, made, model: chart.model, listener: chart.listener });
  }

  drawn(item) {
    const left = item.X - item.w / 2, top = item.Y;
    if (item.kind === "start") return draw("circle", { class: "start", cx: item.X, cy: top + 6, r: 6 });
    if (item.kind === "tab") return draw("rect",
      { class: "tab", x: left, y: top, width: item.w, height: item.h, rx: 4 },
      draw("title", {}, `from anywhere in ${item.name}, or back to it`));
    if (item.kind === "port") return null;
    if (item.kind === "any" || item.kind === "stub") return this.sign(item, left, top);
    return this.stateGroup(item, left, top);
  }

  sign(item, left, top) {
    const select = item.kind === "stub" ? () => this.listener.select("state", item.name)
      : () => this.listener.select("own", "");
    const group = draw("g", { class: `sign ${item.kind}`, transform: `translate(${left},${top})`,
      on: { click: select } },
      item.kind === "stub" ? draw("title", {}, `→ ${item.name}`) : "",
      draw("rect", { width: item.w, height: item.h, rx: item.kind === "stub" ? item.h / 2 : 3 }),
      texts(item.box.texts, 8, 4));
    if (item.kind === "stub") this.made.arrows.push(
      { group, transitions: item.bundle.transitions.map((transition) => transition.place), start: false });
    else this.made.anyGroup = group;
    return group;
  }

  stateGroup(item, left, top) {
    const state = this.model.states.get(item.name), [word, look] = lookOf(state);
    const holder = this.model.holds(item.name);
    const group = draw("g", {
      class: `state ${look}${item.inner ? " open" : ""}${state.region ? " region" : ""}${marks(state.mark)}`,
      "data-state": item.name,
      transform: `translate(${left},${top})`, role: holder ? "group" : "button", "aria-label": `${word} ${item.name}`,
      on: {
        click: (event) => { event.stopPropagation(); this.listener.select("state", item.name); },
        dblclick: (event) => { event.stopPropagation(); this.chart.toggle(item.name); },
      },
    }, draw("title", {}, [state.name, state.title, state.about, ...(state.lines || [])].filter(Boolean).join("\n")),
      outline(state, item));
    if (item.box.tree) group.append(...treeParts(item.box));
    for (const cell of item.box.cells || []) group.append(this.cell(cell));
    group.append(texts(item.box.texts, ...(item.box.at || [PAD, PAD - 3])));
    if (holder) group.append(this.knob(item));
    if (this.detail.triggers) group.append(
      draw("text", { class: "count", x: item.box.w - (holder ? KNOB + 6 : 6), y: PAD + NAME - 3,
        "text-anchor": "end" }));
    group.append(this.badge(item), item.unseen ? this.tip(item) : "");
    this.made.groups.set(item.name, group);
    return group;
  }

  /** The tip of the arrows that are left out. */
  tip(item) {
    const count = item.unseen === 1 ? "1 more transition leads" : `${item.unseen} more transitions lead`;
    return draw("g", { class: "unseen" }, draw("title", {}, `${count} to ${item.name}; zoom in`),
      draw("path", { d: tipAt(0, item.h / 2) }));
  }

  badge(item) {
    const found = this.made.faults.get(item.name);
    return found ? draw("g", { class: "badge", transform: `translate(${-4},${-4})` },
      draw("title", {}, found.join("\n")), draw("circle", { r: 9 }),
      draw("text", { y: 4, "text-anchor": "middle" }, "!")) : "";
  }

  knob(item) {
    const open = Boolean(item.inner);
    const turn = (event) => {
      event.stopPropagation();
      event.preventDefault();
      this.chart.toggle(item.name);
    };
    return draw("g", {
      class: "knob", transform: `translate(${item.w - 21},5)`, role: "button", tabindex: "0",
      "aria-expanded": String(open), "aria-label": `${open ? "close" : "open"} ${item.name}`, "data-knob": item.name,
      on: { click: turn, dblclick: (event) => event.stopPropagation(),
        keydown: (event) => ["Enter", " "].includes(event.key) && turn(event) },
    }, draw("title", {}, open ? "close" : "open"), draw("rect", { width: 16, height: 16, rx: 3 }),
      draw("path", { d: open ? "M4,8H12" : "M4,8H12M8,4V12" }));
  }

  cell(cell) {
    return draw("g", { class: `cell${cell.choice.fallback ? " fallback" : ""}${marks(cell.choice.mark)}`,
      "data-option": cell.choice.place, transform: `translate(${cell.x},${cell.y})` },
      draw("title", {}, `${cell.choice.name}: ${cell.choice.about || ""} `,
        cell.choice.guard && `when ${cell.choice.guard}`),
      draw("rect", { width: cell.w, height: cell.h }), texts(cell.texts, 6, 3));
  }

  arrowOf(bundle) {
    const d = pathOf(bundle.points, bundle.turned), { label } = bundle;
    const places = bundle.transitions.map((transition) => transition.place);
    const mark = bundle.transitions.every((transition) => transition.mark === (bundle.transitions[0] || {}).mark)
      ? (bundle.transitions[0] || {}).mark : "~";
    const select = (event) => {
      event.stopPropagation();
      if (places.length) this.listener.select("transition", places[0], places);
    };
    const group = draw("g", { class: `arrow${bundle.start ? " begin" : ""}${marks(mark)}`,
      "data-transitions": places.join(" "), on: { click: select } },
      draw("title", {}, bundle.start ? `begins with ${bundle.to.name}`
        : bundle.transitions.map((transition) =>
          `${transition.source || "every state"} → ${transition.target}: ${transitionWords(transition)}`).join("\n")),
      draw("path", { class: "grip", d }), draw("path", { class: "line", d, "marker-end": "url(#tip)" }));
    if (label) group.append(draw("g", { class: "label", transform: `translate(${label.x},${label.y})` },
      texts(label.texts, 0, 0)));
    if (label && label.counted) group.append(
      draw("text", { class: "count", x: label.x + label.counted, y: label.y + 10 }));
    this.made.arrows.push({ group, transitions: places, start: Boolean(bundle.start) });
    return group;
  }
}
