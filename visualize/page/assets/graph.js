// SPDX-License-Identifier: Apache-2.0
// What of a mission is to be seen: boxes inside boxes, and the arrows between them cut where they cross a border.
// Rule: an arrow inside one box is laid out with that box alone, so opening a box moves only what is around it.

const HUB = 8, BENDS = 900, NEAR = 7;

/** The states of a chart by name, with what is inside and around each. */
class Model {
  constructor(data) {
    this.data = data;
    this.states = new Map(data.states.map((state) => [state.name, state]));
    this.children = new Map([["", []]]);
    for (const state of data.states) this.children.set(state.name, []);
    for (const state of data.states) this.children.get(state.parent || "").push(state.name);
    this.away = new Map();
    this.here = new Map();
    for (const transition of data.transitions) {
      push(this.away, transition.source || "", transition);
      if (transition.target) push(this.here, transition.target, transition);
    }
    this.transitions = new Map();
    for (const transition of data.transitions) push(this.transitions, transition.place, transition);
  }

  /** Whether so many arrows lead to some state that far away they are left out. */
  get hasHubs() {
    return [...this.here.values()].some((into) => into.length > HUB);
  }

  /** The states around one, outermost first, itself last. */
  chain(name) {
    const found = [];
    for (let here = name; here; here = (this.states.get(here) || {}).parent || "") found.unshift(here);
    return found;
  }

  /** Who must hold control while a state is active: what the innermost state around it demands. */
  wanted(name) {
    return this.chain(name).reduce((wanted, each) => (this.states.get(each) || {}).control || wanted, "");
  }

  /** Of a name that begins as others do once it is cut to lines of a level's width: how many letters it ends alike
   *  with one of these; null of any other. */
  sharing() {
    const found = new Map();
    const last = (name, limit, lines) => wrapped(name, NAME, { bold: true, limit, most: lines }).lines[lines - 1];
    return (name, limit, lines) => {
      const cut = `${limit} ${lines}`;
      if (!found.has(cut)) {
        const alike = new Map();
        for (const each of this.states.keys()) push(alike, last(each, limit, lines), each);
        found.set(cut, new Map([...alike.values()].filter((names) => names.length > 1).flatMap(endsAlike)));
      }
      return found.get(cut).get(name) ?? null;
    };
  }

  /** The state that is meant, or that a transition leaves, else enters; "" for what the chart lacks. */
  stateOf(kind, name) {
    const [transition] = (kind === "transition" && this.transitions.get(name)) || [];
    const state = kind === "state" ? name : transition && (transition.source || transition.target);
    return this.states.has(state) ? state : "";
  }

  holds(name) {
    return this.children.get(name).length > 0;
  }

  inside(name) {
    return this.children.get(name).flatMap((child) => [child, ...this.inside(child)]);
  }

  /** What is inside a closed state, in words. */
  summary(name) {
    const all = this.inside(name).map((each) => this.states.get(each));
    const count = (kind) => all.filter((state) => state.kind === kind).length;
    const parts = [`${counted(all.length, "state")} inside`];
    if (count("decision")) parts.push(counted(count("decision"), "decision"));
    if (count("final")) parts.push(counted(count("final"), "final"));
    return parts.join(", ");
  }
}

/** Names, each with how many letters it ends alike with another of them. */
function endsAlike(names) {
  const turned = names.map((name) => ({ name, back: letters(name).reverse() }));
  turned.sort((one, other) => (one.back.join("") < other.back.join("") ? -1 : 1));
  const alike = ({ back }, other) => {
    let count = 0;
    while (other && count < back.length && back[count] === other.back[count]) count += 1;
    return count;
  };
  return turned.map((each, at) => [each.name, Math.max(alike(each, turned[at - 1]), alike(each, turned[at + 1]))]);
}

function push(map, key, value) {
  const found = map.get(key);
  if (found) found.push(value);
  else map.set(key, [value]);
}

/** The boxes and bundles of arrows that are seen when these states are open. */
class View {
  constructor(model, open, signs = true, far = new Set()) {
    this.model = model;
    this.open = open;
    this.signs = signs;
    this.farAway = far;
    this.items = new Map();
    this.bundles = [];
    this.root = { owner: null, items: [], segments: [] };
    this.build("", this.root);
    this.bundle();
  }

  build(parent, scope) {
    for (const name of this.model.children.get(parent)) {
      const item = this.item(scope, "state", name);
      item.final = this.model.states.get(name).kind === "final";
      this.items.set(name, item);
      if (this.model.holds(name) && this.open.has(name)) {
        item.inner = { owner: item, items: [], segments: [] };
        this.build(name, item.inner);
      }
    }
  }

  item(scope, kind, name) {
    const item = { kind, name, scope, inner: null, w: 0, h: 0, rank: 0, x: 0, y: 0, order: 0, unseen: 0 };
    scope.items.push(item);
    return item;
  }

  /** The box in which a state is seen. */
  seen(name) {
    let found = null;
    for (const each of this.model.chain(name)) {
      found = this.items.get(each) || found;
    }
    return found;
  }

  chain(item) {
    return item.scope.owner ? [...this.chain(item.scope.owner), item] : [item];
  }

  bundle() {
    const found = new Map();
    const own = this.model.away.get("") || [];
    if (own.length) this.anywhere = this.item(this.root, "any", "");
    for (const transition of this.model.data.transitions) {
      if (!transition.target) continue;
      const from = transition.source ? this.seen(transition.source) : this.anywhere;
      const to = this.seen(transition.target);
      if (!from || !to || from === to) continue;
      const option = from.name === transition.source && (transition.options || []).length === 1 ? transition.options[0]
        : "";
      const key = `${from.kind}${from.name}>${to.name}>${option}`;
      if (!found.has(key)) found.set(key, { key, from, to, option, transitions: [], quiet: false });
      found.get(key).transitions.push(transition);
    }
    const into = new Map();
    for (const bundle of found.values()) into.set(bundle.to, (into.get(bundle.to) || 0) + 1);
    for (const bundle of found.values()) {
      bundle.quiet = Boolean(bundle.option);
      if ((into.get(bundle.to) > HUB && bundle.from.kind !== "any") || this.farAway.has(bundle.key)) {
        if (this.signs) this.stub(bundle);
        else this.leaveOut(found, bundle);
      }
    }
    for (const [parent, target] of this.model.data.initials) {
      const scope = parent ? (this.items.get(parent) || {}).inner : this.root;
      const to = this.seen(target);
      if (scope && to) found.set(`start ${parent}>${target}`,
        { key: "", from: this.start(scope, parent), to, option: "", transitions: [], quiet: true, start: true });
    }
    this.bundles = [...found.values()];
    this.bundles.forEach((bundle) => this.cut(bundle));
  }

  /** The longest arrows, as many as must not be drawn for the others to stay readable. */
  far() {
    const found = new Set(this.farAway);
    const spans = this.bundles.filter((bundle) => bundle.key && !bundle.target)
      .map((bundle) => [bundle.segments.reduce((sum_, { a, b }) => sum_ + Math.abs(a.rank - b.rank) - 1, 0),
        bundle.key]);
    let bends = spans.reduce((all, [span]) => all + span, 0);
    for (const [span, key] of spans.sort((a, b) => b[0] - a[0])) {
      if (bends <= BENDS || span < NEAR) break;
      found.add(key);
      bends -= span;
    }
    return found;
  }

  /** An arrow that has no room; its target has a sign instead, which counts its transitions. */
  leaveOut(found, bundle) {
    found.delete(bundle.key);
    bundle.to.unseen += bundle.transitions.length;
  }

  start(scope, parent) {
    return scope.items.find((item) => item.kind === "start") || this.item(scope, "start", parent);
  }

  /** Where very many arrows lead, each ends in the name of its target. */
  stub(bundle) {
    bundle.target = bundle.to;
    bundle.to = this.item(bundle.from.scope, "stub", bundle.target.name);
    bundle.to.bundle = bundle;
  }

  /** The part of an arrow where both its ends are boxes of one scope. */
  cut(bundle) {
    const from = this.chain(bundle.from), to = this.chain(bundle.to);
    let shared = 0;
    while (shared < from.length && shared < to.length && from[shared] === to[shared]) shared += 1;
    const segment = { bundle, from, to, a: from[shared], b: to[shared], atA: shared, atB: shared, up: false };
    if (!segment.a) segment.a = this.tab(bundle.from);
    if (!segment.b) segment.b = this.tab(bundle.to);
    segment.a.scope.segments.push(segment);
    bundle.segments = [segment];
  }

  /** The place inside an open box from which its own transitions lead into it. */
  tab(item) {
    return item.inner.items.find((each) => each.kind === "tab") || this.item(item.inner, "tab", item.name);
  }

  /** The parts of a scope's arrows inside its boxes, once it is known which way they go. */
  descend(scope) {
    for (const segment of scope.segments) {
      if (segment.a.inner && segment.a !== segment.bundle.from) this.leave(segment);
      if (segment.b.inner && segment.b !== segment.bundle.to) this.enter(segment);
    }
  }

  leave(outer) {
    const port = this.item(outer.a.inner, "port", "");
    port.side = outer.up ? "top" : "bottom";
    outer.portA = port;
    const at = outer.atA + 1;
    const segment = { ...outer, a: outer.from[at], b: port, atA: at, atB: -1, up: outer.up, portA: null, portB: null };
    outer.a.inner.segments.push(segment);
    outer.bundle.segments.unshift(segment);
  }

  enter(outer) {
    const port = this.item(outer.b.inner, "port", "");
    port.side = outer.up ? "bottom" : "top";
    outer.portB = port;
    const at = outer.atB + 1;
    const segment = { ...outer, a: port, b: outer.to[at], atA: -1, atB: at, up: outer.up, portA: null, portB: null };
    outer.b.inner.segments.push(segment);
    outer.bundle.segments.push(segment);
  }
}
