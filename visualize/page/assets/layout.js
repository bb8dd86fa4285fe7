// SPDX-License-Identifier: Apache-2.0
// A view laid out: every box with its place and size, every arrow with its way, in the chart's own measure.

// Rule: it is computed downwards; a chart that goes to the right is computed with its boxes turned, and turned at the
// end.

const STRIPS = 24, CUT = 3, TIP = 7;

/** The boxes that are seen when these states are open, ranked; arrows that are too far for a picture end in a name. */
function* viewing(model, open, signs) {
  let view = new View(model, open, signs);
  yield 0.03;
  rankAll(view, view.root);
  for (let round_ = 0, far = view.far(); far.size > view.farAway.size && round_ < 3; round_ += 1, far = view.far()) {
    yield 0.06 + 0.03 * round_;
    view = new View(model, open, signs, far);
    yield 0.07 + 0.03 * round_;
    rankAll(view, view.root);
  }
  yield 0.15;
  return view;
}

/** Lays a view out, in parts; yields how far it is, returns its size. `way`: a level of detail, turned or not, in a
 *  window of an aspect. */
function* layingOut(view, content, way) {
  for (const bundle of view.bundles) {
    const first = bundle.segments[0];
    const box = bundle.start ? null : content.arrow(bundle, bundle.quiet && !first.up);
    first.label = box && box.w ? (way.turned ? { ...box, w: box.h + 9, h: box.w } : box) : null;
  }
  yield 0.2;
  const size = yield* placeScope(view.root, content, way);
  moveTo(view.root, 0, 0);
  yield 0.8;
  for (const bundle of view.bundles) bundle.points = wayOf(bundle);
  for (const item of allItems(view.root)) if (way.turned) turn(item);
  for (const bundle of view.bundles) settleLabel(bundle, way.turned);
  return way.turned ? { w: size.h, h: size.w } : size;
}

/** What was computed downwards, to the right. */
function turn(item) {
  [item.X, item.Y] = [item.Y + item.h / 2, item.X - item.w / 2];
  [item.w, item.h] = [item.h, item.w];
}

/** Where the words of an arrow begin: next to its line, or below it. */
function settleLabel(bundle, turned) {
  const label = bundle.segments[0].way.find((bend) => bend.kind === "label");
  bundle.turned = turned;
  bundle.label = label ? { texts: label.texts, counted: label.counted,
    x: turned ? label.Y + 4 : label.X - label.w / 2 + 9, y: turned ? label.X - label.w / 2 + 6 : label.Y } : null;
}

function* allItems(scope) {
  for (const item of scope.items) {
    yield item;
    if (item.inner) yield* allItems(item.inner);
  }
}

function leftOf(items) {
  return items.reduce((least, item) => Math.min(least, item.x - item.w / 2), Infinity);
}

function rightOf(items) {
  return items.reduce((most, item) => Math.max(most, item.x + item.w / 2), -Infinity);
}

function rankAll(view, scope) {
  rankScope(scope);
  view.descend(scope);
  for (const item of scope.items) if (item.inner) rankAll(view, item.inner);
}

function* placeScope(scope, content, way) {
  for (const item of scope.items) yield* measure(item, content, way);
  for (const segment of scope.segments) fix(segment, way.turned);
  const layers = layered(scope);
  yield 0.3;
  yield* untangle(layers);
  yield* placeAcross(layers, way);
  let bottom = 0;
  layers.forEach((layer, rank) => {
    const h = Math.max(0, ...layer.map((item) => item.h));
    for (const item of layer) {
      item.y = bottom + (item.inner ? 0 : (h - item.h) / 2);
      item.band = [bottom, bottom + h];
    }
    bottom += h + (rank < layers.length - 1 ? way.row : 0);
  });
  const all = layers.flat();
  bottom = inStrips(layers, all, bottom, { ...way, aspect: scope.owner ? 1 : way.aspect });
  const left = Math.min(0, leftOf(all));
  for (const item of all) {
    item.x -= left;
    item.gutterAt -= left;
  }
  for (const item of scope.items) spreadEnds(item);
  scope.w = Math.max(0, rightOf(all));
  scope.h = bottom;
  return { w: scope.w, h: scope.h };
}

/** What is longer than its window is set in strips side by side, as many as make it largest there; returns the
 *  height. */
function inStrips(layers, all, height, way) {
  for (const item of all) Object.assign(item, { strip: 0, gutterAt: 0 });
  if (layers.length < 16) return height;
  let best = null;
  for (let count = 1; count <= STRIPS; count += 1) {
    const strips = cutInto(layers, height / count);
    const w = strips.reduce((sum_, { items }) => sum_ + rightOf(items) - leftOf(items) + way.gutter, -way.gutter);
    const h = Math.max(...strips.map(({ top, bottom }) => bottom - top));
    const scale = Math.min(way.aspect / w, 1 / h);
    if (!best || scale > 1.03 * best.scale) best = { strips, scale, h };
  }
  if (best.strips.length < 2) return height;
  let right = 0;
  best.strips.forEach(({ items, top }, strip) => {
    const shift = right - leftOf(items), down = way.gutter / 3 - top;
    for (const item of items) {
      Object.assign(item, { strip, gutterAt: right - way.gutter / 2, x: item.x + shift, y: item.y + down,
        band: item.band.map((each) => each + down) });
    }
    right = rightOf(items) + way.gutter;
  });
  return best.h + (2 * way.gutter) / 3;
}

/** Layers cut where they are long enough, and few arrows are cut. */
function cutInto(layers, length) {
  const strips = [];
  layers.forEach((layer, rank) => {
    if (!layer.length) return;
    const [begin, end] = layer[0].band, last = strips[strips.length - 1];
    const few = layer.reduce((sum_, item) => sum_ + item.ups.length, 0) <= CUT;
    if (!last || (rank % 2 === 0 && few && end - last.top > length)) strips.push(
      { items: [...layer], top: begin, bottom: end });
    else {
      last.items.push(...layer);
      last.bottom = end;
    }
  });
  return strips;
}

function* measure(item, content, way) {
  if (item.kind === "port") Object.assign(item, { w: 4, h: 0 });
  else if (item.kind === "start") Object.assign(item, { w: 12, h: 12 });
  else if (item.kind === "tab") Object.assign(item, { w: 18, h: 8 });
  else if (item.inner) yield* measureOpen(item, content, way);
  else {
    item.box = item.kind === "any" ? content.anywhere()
      : item.kind === "stub" ? content.stub(item.name)
      : content.leaf(item.name);
    [item.w, item.h] = way.turned ? [item.box.h, item.box.w] : [item.box.w, item.box.h];
  }
}

/** An open state: its inside below its head, and no arrow that comes from above through the words of the head. */
function* measureOpen(item, content, way) {
  const size = yield* placeScope(item.inner, content, way), edge = way.edge;
  item.box = content.head(item.name);
  if (way.turned) {
    Object.assign(item, { w: item.box.h + size.w + edge, h: Math.max(item.box.w, size.h + 2 * edge) });
    Object.assign(item.inner, { left: item.box.h, top: (item.h - size.h) / 2 });
    return;
  }
  const ports = item.inner.items.filter((each) => each.kind === "port" && each.side === "top");
  const clear = ports.length ? item.box.words + 6 - Math.min(...ports.map((each) => each.x)) : 0;
  const left = Math.max((Math.max(item.box.w, size.w + 2 * edge) - size.w) / 2, clear);
  Object.assign(item, { w: Math.max(item.box.w, left + size.w + edge), h: item.box.h + size.h + edge });
  Object.assign(item.inner, { left, top: item.box.h });
}

/** Ends that have a place of their own: an option's cell, or where an arrow comes through a border. */
function fix(segment, turned) {
  const { a, b, bundle } = segment;
  const cell = a === bundle.from && bundle.option && a.box
    ? (a.box.cells || []).find((each) => each.choice.name === bundle.option) : null;
  segment.fixedA = Boolean(cell || segment.portA);
  segment.fixedB = Boolean(segment.portB);
  segment.offA = cell ? (turned ? cell.y + cell.h / 2 : cell.x + cell.w / 2) - a.w / 2
    : segment.portA ? segment.portA.x + a.inner.left - a.w / 2
    : 0;
  segment.offB = segment.portB ? segment.portB.x + b.inner.left - b.w / 2 : 0;
}

/** Several arrows at one side of a box are spread, in the order of where they come from. */
function spreadEnds(item) {
  if (item.kind === "port" || item.kind === "start") return;
  for (const links of [item.ups, item.downs]) {
    const free = links.filter((link) => !(item === link.segment.a ? link.segment.fixedA : link.segment.fixedB));
    if (free.length < 2) continue;
    const far = (link) => {
      const other = link.high === item ? link.low : link.high;
      return other.x + offset(link, other);
    };
    free.sort((a, b) => far(a) - far(b));
    const step = Math.min(26, (item.w * 0.72) / (free.length - 1));
    free.forEach((link, index) => {
      const at = (index - (free.length - 1) / 2) * step;
      if (item === link.segment.a) link.segment.offA = at;
      else link.segment.offB = at;
    });
  }
}

function moveTo(scope, x, y) {
  const bends = scope.segments.flatMap((segment) => segment.way);
  for (const item of [...scope.items, ...bends]) {
    item.X = x + item.x;
    item.Y = y + item.y;
    item.top = y + item.band[0];
    item.bottom = y + item.band[1];
    item.gutter = x + (item.gutterAt || 0);
    if (item.inner) moveTo(item.inner, item.X - item.w / 2 + item.inner.left, item.Y + item.inner.top);
  }
}

/** The points of an arrow from its source to its target. */
function wayOf(bundle) {
  return bundle.segments.flatMap((segment) => {
    const { high, low } = ends(segment);
    const offHigh = high === segment.a ? segment.offA : segment.offB,
      offLow = low === segment.a ? segment.offA : segment.offB;
    const points = [[high.X + offHigh, high.Y + high.h], [high.X + offHigh, high.bottom + (segment.up ? TIP : 0)]];
    let strip = high.strip;
    for (const next of [...segment.way, low]) {
      const x = next.X + (next === low ? offLow : next.kind === "label" ? 4 - next.w / 2 : 0);
      if (next.strip !== strip) points.push(...across(points[points.length - 1], [x, next.top], next.gutter));
      strip = next.strip;
      points.push([x, next.top - (next === low && !segment.up ? TIP : 0)], [x, next === low ? low.Y : next.bottom]);
    }
    return segment.up ? points.reverse() : points;
  });
}

/** From the foot of one strip to the head of another. */
function across([x0, y0], [x1, y1], gutter) {
  return [[x0, y0 + 8], [gutter, y0 + 8], [gutter, y1 - 8], [x1, y1 - 8]];
}

/** Points as the path of an SVG: straight where they are above one another, else a curve that begins and ends
 *  upright. */
function pathOf(points, turned = false) {
  const round = turned ? ([x, y]) => `${y.toFixed(1)},${x.toFixed(1)}` : ([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`;
  const parts = [`M${round(points[0])}`];
  for (let index = 1; index < points.length; index += 1) {
    const [x0, y0] = points[index - 1], [x1, y1] = points[index];
    if (Math.abs(x0 - x1) < 0.5 || Math.abs(y0 - y1) < 0.5) parts.push(`L${round([x1, y1])}`);
    else parts.push(`C${round([x0, (y0 + y1) / 2])} ${round([x1, (y0 + y1) / 2])} ${round([x1, y1])}`);
  }
  return parts.join("");
}
