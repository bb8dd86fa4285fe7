// SPDX-License-Identifier: Apache-2.0
// The chart: a mission's states and transitions, drawn from data, with states of highlight put over it.
// Rule: what is lit, dimmed, active or taken is set by `show`, and changes no place; opening and closing does.

const OPEN_AT_FIRST = [45, 20, 0], READABLE = LEAST_NAME / NAME, LARGE = 700, MARGIN = 40, MARGIN_NARROW = 16;

class Chart {
  /** @param host element
   *  @param data chart data
   *  @param listener {select(kind, name, places)}
   *  @param findings [{place, sentence}] */
  constructor(host, data, listener, findings = []) {
    this.host = host;
    this.listener = listener;
    this.model = new Model(data);
    this.open = new Set();
    this.faults = this.faulty(findings);
    this.state = { lens: null, active: new Set(), taken: new Set(), counts: null, selected: null, found: new Set() };
    this.layer = draw("g", {});
    this.svg = draw("svg", { class: "chart", tabindex: "0", role: "application",
      "aria-label": `chart of ${data.name}` }, markers(), this.layer);
    this.crumb = make("div", { class: "crumb", "aria-hidden": "true" });
    host.append(this.svg, this.crumb);
    this.gestures = new Gestures(this.svg, this.layer,
      { size: () => this.size, zoomed: (x, y) => this.refine(x, y), moved: () => this.within() });
    Object.assign(this, { view: null, size: { w: 1, h: 1 }, groups: new Map(), arrows: [], level: 0, turned: false,
      plans: null, plan: null, work: null, sight: null });
    this.openFirst();
    new ResizeObserver(() => this.resized()).observe(this.svg);
  }

  /** Which states carry a fault, and its sentences. */
  faulty(findings) {
    const found = new Map();
    for (const { place, sentence } of findings) {
      const around = this.model.data.states.filter((state) => place === state.place
        || place.startsWith(`${state.place}/`));
      if (around.length) push(found, around[around.length - 1].name, sentence);
    }
    return found;
  }

  /** As many open states as leave all names whole and readable in the window; on a phone none. */
  openFirst() {
    for (const most of this.isNarrow() ? [0] : OPEN_AT_FIRST) {
      this.open = this.outermost(most);
      this.plans = this.planned();
      if (!this.open.size || this.plans.seen > LARGE) break;
      const plan = finished(this.plans.fitting(this.room()));
      if (areWhole(plan.view) && scaleOf(plan, this.room()) >= READABLE) break;
    }
    this.draw((plans, room) => plans.fitting(room));
  }

  /** Open states, outer before inner, such that no more than so many states are seen. */
  outermost(most) {
    const open = new Set();
    let wave = this.model.children.get(""), seen = wave.length;
    while (wave.length) {
      const next = [];
      for (const name of wave) {
        const inside = this.model.children.get(name);
        if (!inside.length || seen + inside.length > most) continue;
        open.add(name);
        seen += inside.length;
        next.push(...inside);
      }
      wave = next;
    }
    return open;
  }

  isNarrow() {
    return innerWidth < NARROW;
  }

  /** What the window has room for, on the screen's measure. */
  room() {
    const box = this.svg.getBoundingClientRect(), margin = this.isNarrow() ? MARGIN_NARROW : MARGIN;
    return { w: Math.max(box.width - margin, 200), h: Math.max(box.height - margin, 100), margin,
      narrow: this.isNarrow() };
  }

  planned() {
    const alikeEnd = this.model.sharing();  // for all levels: what is cut alike is counted once
    return new Plans(this.model, this.open,
      (level, turned) => this.content({ ...level, turned, counted: Boolean(this.state.counts), alikeEnd }));
  }

  /** Opens or closes states; what `still` names stays where it is on the screen. */
  change(act, still, then = () => {}) {
    const before = still ? this.place(still) : null;
    act(this.open);
    this.plans = this.planned();
    if (before) this.draw((plans, room) => plans.making(this.level, this.turned, room), () => {
      this.held(still, before);
      then();
    });
    else this.fit(READABLE);
  }

  held(name, before) {
    const after = this.place(name);
    if (after) this.gestures.shift(before.x - after.x, before.y - after.y);
  }

  toggle(name) {
    if (!this.model.holds(name)) return;
    const focused = document.activeElement && document.activeElement.closest("[data-knob]");
    this.change((open) => (open.has(name) ? open.delete(name) : open.add(name)), name);
    if (focused) this.focus(name);
  }

  focus(name) {
    const knob = [...this.layer.querySelectorAll("[data-knob]")].find((each) => each.dataset.knob === name);
    if (knob) knob.focus();
  }

  openAll() {
    this.change((open) => this.model.states.forEach((_, name) => this.model.holds(name) && open.add(name)));
  }

  closeAll() {
    this.change((open) => open.clear());
  }

  /** Opens what is around states, so that they are seen. */
  reveal(names, then = () => {}) {
    const closed = new Set(names.flatMap((name) => this.model.chain(name).slice(0, -1))
      .filter((each) => !this.open.has(each)));
    const [first] = closed;
    if (first) this.change((open) => closed.forEach((each) => open.add(each)), first, then);
  }

  /** On a phone, where little is open: reveals what is active, and the innermost stays in the window. */
  revealActive() {
    const active = [...this.state.active], last = active[active.length - 1];
    this.reveal(active, () => this.isSeen(last) || this.gestures.bring(this.place(last), this.room().margin / 2));
  }

  /** Draws the layout that `plan` makes; a large one in parts, with its progress shown, while the page is used. */
  draw(plan, then = () => {}) {
    if (this.work && this.work.plans === this.plans) {
      this.work.then = this.finish(then);
      return;
    }
    if (this.work) this.work.stop();
    this.work = null;
    const parts = this.drawing(plan(this.plans, this.room()));
    if (this.plans.seen <= LARGE) {
      finished(parts);
      then();
      return;
    }
    this.work = new Work(this.host, `drawing ${this.plans.seen} states`);
    this.work.plans = this.plans;
    this.work.run(parts, this.finish(then));
  }

  finish(then) {
    return () => {
      this.work = null;
      then();
    };
  }

  *drawing(planning) {
    const plan = yield* planning, { view } = plan;
    if (plan === this.plan) return;
    const groups = new Map(), arrows = [], borders = [], boxes = [], lines = [];
    const made = { groups, arrows, faults: this.faults, anyGroup: null };
    const pen = new Pen(this, LEVELS[plan.level], made);
    let count = 0;
    for (const item of allItems(view.root)) {
      const drawn = pen.drawn(item);
      if (drawn) (item.inner ? borders : boxes).push(drawn);
      if ((count += 1) % 20 === 0) yield 0.8 + (0.1 * boxes.length) / this.plans.seen;
    }
    for (const bundle of view.bundles) {
      lines.push(pen.arrowOf(bundle));
      if ((count += 1) % 20 === 0) yield 0.9 + (0.1 * lines.length) / view.bundles.length;
    }
    Object.assign(this, made, { plan, view, size: plan.size, level: plan.level, turned: plan.turned });
    this.svg.dataset.detail = LEVELS[plan.level].word;
    this.svg.toggleAttribute("data-dots",
      !LEVELS[plan.level].triggers && [...allItems(view.root)].some((item) => item.kind === "stub"));
    this.svg.toggleAttribute("data-unseen", [...allItems(view.root)].some((item) => item.unseen));
    this.layer.replaceChildren(...borders, ...lines, ...boxes);
    this.show({});
  }

  /** Nearer, more is drawn, and farther less; what is at a point of the window stays there. */
  refine(x, y) {
    if (!this.view || this.work) return;
    const { scale } = this.gestures;
    const finer = this.level < FINEST && this.plans.seen <= LARGE
      && (scale >= LARGEST || this.scaleAt(this.level + 1) >= LEVELS[this.level + 1].readable * HYSTERESIS);
    const coarser = this.level > 0 && scale < LEVELS[this.level].readable / HYSTERESIS
      && this.scaleAt(this.level - 1) > scale;
    const level = finer ? this.level + 1 : coarser ? this.level - 1 : this.level;
    if (level === this.level) return;
    const to = Math.max(this.scaleAt(level), finer ? LEVELS[level].readable : 0), near = this.nearest(x, y),
      point = this.gestures.outside(this.place(near));
    this.draw((plans, room) => plans.making(level, this.turned, room),
      () => this.gestures.hold(to, this.place(near), point));
  }

  /** Larger or smaller by a button or key: the chosen state stays where it is, else the active one, and neither is
   *  pushed out. */
  zoom(by) {
    const name = this.kept(), place = name && this.place(name);
    if (!place) return this.gestures.zoom(by);
    this.gestures.zoom(by, ...this.gestures.outside(place));
    const now = this.place(name);
    if (now) this.gestures.bring(now, this.room().margin / 2);
  }

  /** The chosen state, or the innermost active one, where it is seen in the window. */
  kept() {
    const [kind, name] = (this.state.selected || "").split(" "),
      source = ((this.model.transitions.get(name) || [])[0] || {}).source;
    const wanted = [kind === "state" ? name : kind === "transition" ? source : "", ...[...this.state.active].reverse()];
    return wanted.find((each) => each && this.isSeen(each)) || "";
  }

  /** Whether a state is in the window: all of it, or a part of one; that which is folded away is seen as what it is
   *  folded into. */
  isSeen(name, whole = false) {
    const place = this.place(name);
    return Boolean(place) && this.gestures.isSeen(place, whole);
  }

  /** Names the groups around the middle of the window, where the head of one is out of it. */
  within() {
    if (!this.view) return;
    const { width, height } = this.svg.getBoundingClientRect(), at = this.gestures.inside(width / 2, height / 2);
    const around = [...this.view.items]
      .filter(([, { inner, X, Y, w, h }]) => inner && Math.abs(at.x - X) < w / 2 && at.y > Y && at.y < Y + h);
    const last = around.findLastIndex(([, { X, Y, w, box }]) =>
      !this.gestures.isSeen({ x: X - w / 2 + (box.words || w) / 2, y: Y, w: box.words || w, h: NAME }, true));
    this.crumb.textContent = shown(around.slice(0, last + 1).map(([name]) => name).join(" › "));
  }

  /** The scale at which another level is as large as this one is now. */
  scaleAt(level) {
    if (this.plans.seen > LARGE) return 0; // another layout of so many takes too long
    const { size } = this.plans.at(level, this.turned, this.room());
    return this.gestures.scale * Math.sqrt((this.size.w * this.size.h) / (size.w * size.h));
  }

  /** The state whose middle is nearest to a point of the window. */
  nearest(x, y) {
    const at = this.gestures.inside(x, y);
    let found = "", least = Infinity;
    for (const [name, item] of this.view.items) {
      const away = Math.hypot(item.X - at.x, item.Y + item.h / 2 - at.y) + (item.inner ? item.h : 0);
      if (away < least) [found, least] = [name, away];
    }
    return found;
  }

  staying(name) {
    return (this.model.away.get(name) || [])
      .filter((transition) => !transition.target || transition.target === name
        || !this.model.states.has(transition.target));
  }

  /** What the layout asks for: the boxes of what is seen. */
  content(detail) {
    const state = (name) => this.model.states.get(name);
    return {
      leaf: (name) => {
        if (this.model.holds(name)) return closedBox(state(name), this.staying(name), this.model.summary(name), detail);
        const box = leafBox(state(name), this.staying(name), detail);
        return detail.all && state(name).twigs ? grownBox(box, treeBox(state(name).twigs)) : box;
      },
      head: (name) => openHead(state(name), this.staying(name), detail),
      anywhere: () => anywhereBox(this.model.away.get("") || [], detail),
      stub: (name) => stubBox(name, detail),
      arrow: (bundle, quiet) => arrowBox(bundle.transitions, quiet, detail),
    };
  }

  /** Puts a state of highlights over the chart; what is not given stays as it was. */
  show(given) {
    const counted = Boolean(this.state.counts);
    const state = Object.assign(this.state, given);
    if (Boolean(state.counts) !== counted) this.recount();
    if (given.active && this.isNarrow()) this.revealActive();
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
      visit(group, counts ? sum(counts.states[name]) : 0);
    }
    for (const cell of this.layer.querySelectorAll("[data-option]")) {
      cell.classList.toggle("lit", Boolean(lens && lens.options.has(cell.dataset.option)));
    }
    for (const { group, transitions } of this.arrows) {
      group.classList.toggle("lit",
        Boolean(lens && transitions.some((transition) => lens.transitions.has(transition))));
      group.classList.toggle("taken", transitions.some((transition) => taken.has(transition)));
      group.classList.toggle("selected",
        transitions.some((transition) => state.selected === `transition ${transition}`));
      visit(group, counts ? transitions.reduce((all, transition) => all + sum(counts.transitions[transition]), 0) : 0);
    }
    if (this.anyGroup) this.anyGroup.classList.toggle("lit",
      Boolean(lens && (this.model.away.get("") || []).some((transition) => lens.transitions.has(transition.place))));
  }

  /** Makes room for numbers, where there is a run to count. */
  recount() {
    this.plans = this.planned();
    this.draw((plans, room) => plans.making(this.level, this.turned, room));
  }

  /** States and all that is around them. */
  closure(names) {
    const found = new Set();
    for (const name of names) for (const each of this.model.chain(name)) found.add(each);
    return found;
  }

  /** Where a state is seen, on the screen's measure; of the empty name, the sign of what leads away from every
   *  state. */
  place(name) {
    const item = this.view && (name ? this.view.seen(name) : this.view.anywhere);
    return item ? { x: item.X, y: item.Y, w: item.w, h: item.h, item } : null;
  }

  center(name) {
    const place = this.place(name);
    if (place) this.gestures.center(place.x, place.y + Math.min(place.h, 200) / 2);
  }

  /** To a state, wherever it is. */
  goTo(name) {
    this.reveal([name]);
    this.center(name);
  }

  /** Marks what is chosen: a state, a transition, or neither. */
  select(kind, name) {
    this.show({ selected: kind === "state" || kind === "transition" ? `${kind} ${name}` : null });
  }

  /** The part of the chart that holds these states, in as much detail as can be read; else the first of them that
   *  can. */
  frame(names) {
    if (!this.view || this.work) return;
    const room = this.room(), levels = this.plans.seen > BOTH_WAYS ? [this.level] : [...LEVELS.keys()].reverse();
    const ways = levels.map((level) => this.around(names, level, room));
    const way = ways.find((each) => each && each.whole) || ways.find((each) => each && each.level === WHOLE_NAMES)
      || ways[0];
    if (way) this.draw((plans) => plans.making(way.level, this.turned, room), () => {
      this.gestures.frame(way, room, LEVELS[way.level].most);
      this.keep(() => this.frame(names));
    });
  }

  /** Where states are at a level: as many of a list, from its beginning, as can be read together. */
  around(names, level, room) {
    const { view } = this.plans.at(level, this.turned, room), { readable } = LEVELS[level];
    const places = names.map((name) => (name ? view.seen(name) : view.anywhere)).filter(Boolean);
    let found = null;
    for (const { X, Y, w, h } of places) {
      const [l, t, r, b] = found || [X, Y, X, Y];
      const more = [Math.min(l, X - w / 2), Math.min(t, Y), Math.max(r, X + w / 2), Math.max(b, Y + h)];
      const scale = Math.min(room.w / (more[2] - more[0]), room.h / (more[3] - more[1]));
      if (found && scale < readable) return { ...boxOf(found), level, whole: false };
      found = more;
    }
    if (!found) return null;
    const box = boxOf(found);
    return { ...box, level, whole: Math.min(room.w / box.w, room.h / box.h) >= readable };
  }

  /** How the chart is looked at, to come back to. */
  get viewpoint() {
    const { x, y, scale } = this.gestures;
    return { open: new Set(this.open), level: this.level, turned: this.turned, x, y, scale };
  }

  set viewpoint({ open, level, turned, x, y, scale }) {
    if (open.size !== this.open.size || [...open].some((name) => !this.open.has(name))) {
      this.open = new Set(open);
      this.plans = this.planned();
    }
    this.draw((plans, room) => plans.making(level, turned, room), () => this.gestures.set(x, y, scale));
  }

  /** All of it, in as much detail as can be read; with a least scale, and on a phone, what is active where all cannot
   *  be read. */
  fit(asked) {
    this.draw((plans, room) => plans.fitting(room), () => {
      const least = asked ?? this.isNarrow();
      const { most } = LEVELS[this.level], room = this.room(), [active] = [...this.state.active].reverse();
      const readable = scaleOf(this.plan, room) >= readableIn(this.level, room) ? readableIn(this.level, room)
        : readableCut(this.level, room);
      this.gestures.fit(least ? readable : 0, least ? this.place(active || this.first()) : null,
        { most, margin: room.margin });
      this.keep(() => this.fit(asked));
    });
  }

  /** Remembers how what is in view was found, until it is moved by hand. */
  keep(again) {
    this.sight = { again, size: this.measure(), at: this.gestures.at };
  }

  measure() {
    const { width, height } = this.svg.getBoundingClientRect();
    return `${width} ${height}`;
  }

  /** The window was resized or turned: what was in view and not moved by hand is brought into view again. */
  resized() {
    if (!this.sight || this.svg.hasAttribute("viewBox")) return;
    const { again, size, at } = this.sight;
    if (size === this.measure() || at !== this.gestures.at) return;
    if (!this.work) this.plans = this.planned(); // a layout is made for the window's proportions
    again();
  }

  /** All of it, in a box that is scaled to the paper's: it is laid out for the screen's. */
  toPaper() {
    this.fit(false);
    const { width, height } = this.svg.getBoundingClientRect();
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  }

  toScreen() {
    this.svg.removeAttribute("viewBox");
  }

  /** The innermost state that the mission begins with. */
  first() {
    const begins = new Map([...this.model.data.initials].reverse());
    let name = begins.get("");
    for (let deep = 0; begins.has(name) && deep < 100; deep += 1) name = begins.get(name);
    return name;
  }
}

/** How often a state or an arrow was passed, next to it. */
function visit(group, times) {
  group.classList.toggle("visited", times > 0);
  const count = group.querySelector(":scope > .count");
  if (count) count.textContent = times ? `${times}×` : "";
}

function boxOf([left, top, right, bottom]) {
  return { x: left, y: top, w: right - left, h: bottom - top };
}

function sum(numbers) {
  return (numbers || []).reduce((all, each) => all + each, 0);
}
