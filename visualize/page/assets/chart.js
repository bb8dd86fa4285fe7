// SPDX-License-Identifier: Apache-2.0
// The chart: a mission's states and transitions, drawn from data, with states of highlight put over it.
// Rule: what is lit, dimmed, active or taken is set by `show`, and changes no place; opening and closing does.

const OPEN_AT_FIRST = 45, READABLE = 0.9; // the smallest text is 10 high, and must be 9 on the screen

class Chart {
  /** @param host element  @param data chart data  @param listener {select(kind, name, places)}  @param findings [{place, sentence}] */
  constructor(host, data, listener, findings = []) {
    this.host = host;
    this.listener = listener;
    this.model = new Model(data);
    this.open = new Set();
    this.faults = this.faulty(findings);
    this.state = { lens: null, active: new Set(), taken: new Set(), options: new Set(), counts: null, selected: null, found: new Set() };
    this.layer = draw("g", {});
    this.svg = draw("svg", { class: "chart", tabindex: "0", role: "application", "aria-label": `chart of ${data.name}` }, markers(), this.layer);
    host.append(this.svg);
    this.gestures = new Gestures(this.svg, this.layer, () => this.size);
    this.openFirst();
    this.draw();
  }

  /** Which states carry a fault, and its sentences. */
  faulty(findings) {
    const found = new Map();
    for (const { place, sentence } of findings) {
      const around = this.model.data.states.filter((state) => place === state.place || place.startsWith(`${state.place}/`));
      if (around.length) push(found, around[around.length - 1].name, sentence);
    }
    return found;
  }

  /** Outer before inner, as many as stay readable. */
  openFirst() {
    let seen = this.model.children.get("").length;
    let wave = this.model.children.get("");
    while (wave.length) {
      const next = [];
      for (const name of wave) {
        const inside = this.model.children.get(name);
        if (!inside.length || seen + inside.length > OPEN_AT_FIRST) continue;
        this.open.add(name);
        seen += inside.length;
        next.push(...inside);
      }
      wave = next;
    }
  }

  /** Opens or closes states; what `still` names stays where it is on the screen. */
  change(act, still) {
    const before = still ? this.place(still) : null;
    act(this.open);
    this.draw();
    const after = still ? this.place(still) : null;
    if (before && after) this.gestures.shift(before.x - after.x, before.y - after.y);
    else this.fit(READABLE);
  }

  toggle(name) {
    if (this.model.holds(name)) this.change((open) => (open.has(name) ? open.delete(name) : open.add(name)), name);
  }

  openAll() {
    this.change((open) => this.model.states.forEach((_, name) => this.model.holds(name) && open.add(name)));
  }

  closeAll() {
    this.change((open) => open.clear());
  }

  /** Opens what is around a state, so that it is seen. */
  reveal(name) {
    const around = this.model.chain(name).slice(0, -1).filter((each) => !this.open.has(each));
    if (around.length) this.change((open) => around.forEach((each) => open.add(each)), around[0]);
  }

  draw() {
    this.view = viewOf(this.model, this.open);
    this.size = layOut(this.view, this);
    this.groups = new Map();
    this.arrows = [];
    const borders = [], boxes = [];
    for (const item of allItems(this.view.root)) {
      const made = this.drawn(item);
      if (made) (item.inner ? borders : boxes).push(made);
    }
    const arrows = this.view.bundles.map((bundle) => this.arrowOf(bundle));
    this.layer.replaceChildren(...borders, ...arrows, ...boxes);
    this.show({});
  }

  staying(name) {
    return (this.model.away.get(name) || []).filter((transition) => !transition.target || transition.target === name || !this.model.states.has(transition.target));
  }

  // What the layout asks for: the boxes of what is seen.
  leaf(name) {
    const state = this.model.states.get(name);
    if (this.model.holds(name)) return closedBox(state, this.staying(name), this.model.summary(name));
    const box = leafBox(state, this.staying(name));
    return state.twigs ? grownBox(box, treeBox(state.twigs)) : box;
  }

  head(name) {
    return openHead(this.model.states.get(name), this.staying(name));
  }

  anywhere() {
    return anywhereBox(this.model.away.get("") || []);
  }

  stub(name) {
    const column = new Column(150);
    column.add(`→ ${name}`, 11, { most: 1 });
    return { w: column.w + 16, h: column.h + 8, texts: column.texts, cells: [], tree: null };
  }

  arrow(bundle, quiet) {
    return arrowBox(bundle.transitions, quiet);
  }

  drawn(item) {
    const left = item.X - item.w / 2, top = item.Y;
    if (item.kind === "start") return draw("circle", { class: "start", cx: item.X, cy: top + 6, r: 6 });
    if (item.kind === "tab") return draw("rect", { class: "tab", x: left, y: top, width: item.w, height: item.h, rx: 4 }, draw("title", {}, `from anywhere in ${item.name}, or back to it`));
    if (item.kind === "port") return null;
    if (item.kind === "any" || item.kind === "stub") return this.sign(item, left, top);
    return this.stateGroup(item, left, top);
  }

  sign(item, left, top) {
    const select = item.kind === "stub" ? () => this.listener.select("state", item.name) : () => this.listener.select("own", "");
    const group = draw("g", { class: `sign ${item.kind}`, transform: `translate(${left},${top})`, on: { click: select } },
      draw("rect", { width: item.w, height: item.h, rx: item.kind === "stub" ? item.h / 2 : 3 }), texts(item.box.texts, 8, 4));
    if (item.kind === "stub") this.arrows.push({ group, transitions: item.bundle.transitions.map((transition) => transition.place), start: false });
    else this.anyGroup = group;
    return group;
  }

  stateGroup(item, left, top) {
    const state = this.model.states.get(item.name), [word, look] = lookOf(state);
    const holder = this.model.holds(item.name);
    const group = draw("g", {
      class: `state ${look}${item.inner ? " open" : ""}${state.region ? " region" : ""}${marks(state.mark)}`, "data-state": item.name,
      transform: `translate(${left},${top})`, role: "button", "aria-label": `${word} ${item.name}`,
      on: {
        click: (event) => { event.stopPropagation(); this.listener.select("state", item.name); },
        dblclick: (event) => { event.stopPropagation(); this.toggle(item.name); },
      },
    }, draw("title", {}, [state.name, state.title, state.about, ...(state.lines || [])].filter(Boolean).join("\n")), outline(state, item));
    if (item.box.tree) group.append(...treeParts(item.box));
    for (const cell of item.box.cells || []) group.append(this.cell(cell));
    group.append(texts(item.box.texts, PAD, PAD - 3));
    if (holder) group.append(this.knob(item));
    group.append(draw("text", { class: "count", x: item.w - 6, y: item.h - 6, "text-anchor": "end" }), this.badge(item));
    this.groups.set(item.name, group);
    return group;
  }

  badge(item) {
    const found = this.faults.get(item.name);
    return found ? draw("g", { class: "badge", transform: `translate(${-4},${-4})` }, draw("title", {}, found.join("\n")), draw("circle", { r: 9 }), draw("text", { y: 4, "text-anchor": "middle" }, "!")) : "";
  }

  knob(item) {
    const open = Boolean(item.inner);
    return draw("g", {
      class: "knob", transform: `translate(${item.w - 21},5)`, role: "button", "aria-label": `${open ? "close" : "open"} ${item.name}`, "data-knob": item.name,
      on: { click: (event) => { event.stopPropagation(); this.toggle(item.name); }, dblclick: (event) => event.stopPropagation() },
    }, draw("title", {}, open ? "close" : "open"), draw("rect", { width: 16, height: 16, rx: 3 }), draw("path", { d: open ? "M4,8H12" : "M4,8H12M8,4V12" }));
  }

  cell(cell) {
    return draw("g", { class: `cell${cell.choice.fallback ? " fallback" : ""}${marks(cell.choice.mark)}`, "data-option": cell.choice.place, transform: `translate(${cell.x},${cell.y})` },
      draw("title", {}, `${cell.choice.name}: ${cell.choice.about || ""} ${cell.choice.guard ? "when " + cell.choice.guard : ""}`),
      draw("rect", { width: cell.w, height: cell.h }), texts(cell.texts, 6, 3));
  }

  arrowOf(bundle) {
    const d = pathOf(bundle.points), first = bundle.segments[0];
    const places = bundle.transitions.map((transition) => transition.place);
    const mark = bundle.transitions.every((transition) => transition.mark === (bundle.transitions[0] || {}).mark) ? (bundle.transitions[0] || {}).mark : "~";
    const select = (event) => { event.stopPropagation(); if (places.length) this.listener.select("transition", places[0], places); };
    const group = draw("g", { class: `arrow${bundle.start ? " begin" : ""}${marks(mark)}`, "data-transitions": places.join(" "), on: { click: select } },
      draw("title", {}, bundle.start ? `begins with ${bundle.to.name}` : bundle.transitions.map((transition) => `${transition.source || "every state"} → ${transition.target}: ${transitionWords(transition)}`).join("\n")),
      draw("path", { class: "grip", d }), draw("path", { class: "line", d, "marker-end": "url(#tip)" }));
    const label = first.way.find((bend) => bend.kind === "label");
    if (label) group.append(draw("g", { class: "label", transform: `translate(${label.X - label.w / 2 + 9},${label.Y})` }, texts(label.texts, 0, 0)));
    const [x, y] = label ? [label.X - label.w / 2 + 1, label.Y - 2] : bundle.points[0].map((value, axis) => value + (axis ? 11 : 4));
    group.append(draw("text", { class: "count", x, y }));
    this.arrows.push({ group, transitions: places, start: Boolean(bundle.start) });
    return group;
  }

  /** Puts a state of highlights over the chart; what is not given stays as it was. */
  show(given) {
    const state = Object.assign(this.state, given);
    const { lens, active, taken, counts, found } = state;
    this.svg.classList.toggle("dimming", Boolean(lens));
    this.svg.classList.toggle("playing", Boolean(counts));
    const lit = lens ? this.closure(lens.states) : null;
    for (const [name, group] of this.groups) {
      const inside = !this.open.has(name) && this.model.holds(name) ? this.model.inside(name) : [];
      group.classList.toggle("lit", Boolean(lit && lit.has(name)));
      group.classList.toggle("active", active.has(name));
      group.classList.toggle("found", found.has(name) || inside.some((each) => found.has(each)));
      group.classList.toggle("selected", state.selected === `state ${name}`);
      const times = counts ? sum(counts.states[name]) : 0;
      group.classList.toggle("visited", times > 0);
      if (!this.open.has(name)) group.querySelector(":scope > .count").textContent = times ? `${times}×` : "";
    }
    for (const cell of this.layer.querySelectorAll("[data-option]")) cell.classList.toggle("lit", Boolean(lens && lens.options.has(cell.dataset.option)));
    for (const { group, transitions } of this.arrows) {
      group.classList.toggle("lit", Boolean(lens && transitions.some((transition) => lens.transitions.has(transition))));
      group.classList.toggle("taken", transitions.some((transition) => taken.has(transition)));
      group.classList.toggle("selected", transitions.some((transition) => state.selected === `transition ${transition}`));
      const times = counts ? transitions.reduce((all, transition) => all + sum(counts.transitions[transition]), 0) : 0;
      group.classList.toggle("visited", times > 0);
      const count = group.querySelector(":scope > .count");
      if (count) count.textContent = times ? `${times}×` : "";
    }
    if (this.anyGroup) this.anyGroup.classList.toggle("lit", Boolean(lens && (this.model.away.get("") || []).some((transition) => lens.transitions.has(transition.place))));
  }

  /** States and all that is around them. */
  closure(names) {
    const found = new Set();
    for (const name of names) for (const each of this.model.chain(name)) found.add(each);
    return found;
  }

  /** Where a state is seen, on the screen's measure; of the empty name, the sign of what leads away from every state. */
  place(name) {
    const item = name ? this.view.seen(name) : [...allItems(this.view.root)].find((each) => each.kind === "any");
    return item ? { x: item.X, y: item.Y, w: item.w, h: item.h, item } : null;
  }

  center(name) {
    const place = this.place(name);
    if (place) this.gestures.center(place.x, place.y + Math.min(place.h, 200) / 2);
  }

  /** The part of the chart that holds these states: the longest beginning of the list that stays readable. */
  frame(names, least = 0) {
    const box = this.svg.getBoundingClientRect();
    let around = null;
    for (const place of names.map((name) => this.place(name)).filter(Boolean)) {
      const left = place.x - place.w / 2, [l, t, r, b] = around || [left, place.y, left + place.w, place.y + place.h];
      const more = [Math.min(l, left), Math.min(t, place.y), Math.max(r, left + place.w), Math.max(b, place.y + place.h)];
      if (around && Math.min((box.width - 60) / (more[2] - more[0]), (box.height - 60) / (more[3] - more[1])) < least) break;
      around = more;
    }
    if (around) this.gestures.frame({ x: around[0], y: around[1], w: around[2] - around[0], h: around[3] - around[1] });
  }

  /** All of it; with a least scale, where the mission begins if not all can be seen. */
  fit(least) {
    this.gestures.fit(least, least ? this.place(this.first()) : null);
  }

  /** The innermost state that the mission begins with. */
  first() {
    const begins = new Map([...this.model.data.initials].reverse());
    let name = begins.get("");
    for (let deep = 0; begins.has(name) && deep < 100; deep += 1) name = begins.get(name);
    return name;
  }
}

function sum(numbers) {
  return (numbers || []).reduce((all, each) => all + each, 0);
}

function* allItems(scope) {
  for (const item of scope.items) {
    yield item;
    if (item.inner) yield* allItems(item.inner);
  }
}
