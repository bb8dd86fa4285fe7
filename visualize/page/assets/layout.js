// SPDX-License-Identifier: Apache-2.0
// A view laid out: every box with its place and size, every arrow with its way, in the chart's own measure.

const EDGE = 14, ROW = 13, GUTTER = 48;

/** The boxes that are seen when these states are open, ranked; arrows that are too far for a picture end in a name. */
function viewOf(model, open) {
  let view = new View(model, open);
  rankAll(view, view.root);
  for (let round_ = 0, far = view.far(); far.size > view.farAway.size && round_ < 3; round_ += 1, far = view.far()) {
    view = new View(model, open, far);
    rankAll(view, view.root);
  }
  return view;
}

/** Lays a view out; returns its size. */
function layOut(view, content) {
  for (const bundle of view.bundles) {
    const first = bundle.segments[0];
    const box = bundle.start ? null : content.arrow(bundle, bundle.quiet && !first.up);
    first.label = box && box.w ? box : null;
  }
  const size = placeScope(view.root, content);
  moveTo(view.root, 0, 0);
  for (const bundle of view.bundles) bundle.points = wayOf(bundle);
  return size;
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

function placeScope(scope, content) {
  for (const item of scope.items) measure(item, content);
  for (const segment of scope.segments) fix(segment);
  const layers = layered(scope);
  untangle(layers);
  placeAcross(layers);
  let bottom = 0;
  layers.forEach((layer, rank) => {
    const h = Math.max(0, ...layer.map((item) => item.h));
    for (const item of layer) {
      item.y = bottom + (item.inner ? 0 : (h - item.h) / 2);
      item.band = [bottom, bottom + h];
    }
    bottom += h + (rank < layers.length - 1 ? ROW : 0);
  });
  const all = layers.flat();
  bottom = inStrips(layers, all, bottom);
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

/** What is many times as long as wide is set in strips side by side; returns the height. */
function inStrips(layers, all, height) {
  const wide = layers.reduce((most, layer) => Math.max(most, layer.length ? rightOf(layer) - leftOf(layer) : 0), 0);
  const wanted = Math.min(12, Math.round(Math.sqrt(height / (1.1 * wide + 1))));
  for (const item of all) Object.assign(item, { strip: 0, gutterAt: 0 });
  if (wanted < 2 || layers.length < 16) return height;
  const strips = [];
  layers.forEach((layer, rank) => {
    if (!layer.length) return;
    const [begin, end] = layer[0].band, last = strips[strips.length - 1];
    if (!last || (rank % 2 === 0 && begin - last.top > height / wanted)) strips.push({ items: [...layer], top: begin, bottom: end });
    else Object.assign(last, { items: [...last.items, ...layer], bottom: end });
  });
  let right = 0;
  strips.forEach(({ items, top }, strip) => {
    const shift = right - leftOf(items), down = GUTTER / 3 - top;
    for (const item of items) {
      Object.assign(item, { strip, gutterAt: right - GUTTER / 2, x: item.x + shift, y: item.y + down, band: item.band.map((each) => each + down) });
    }
    right = rightOf(items) + GUTTER;
  });
  return Math.max(...strips.map(({ top, bottom }) => bottom - top)) + (2 * GUTTER) / 3;
}

function measure(item, content) {
  if (item.kind === "port") Object.assign(item, { w: 4, h: 0 });
  else if (item.kind === "start") Object.assign(item, { w: 12, h: 12 });
  else if (item.kind === "tab") Object.assign(item, { w: 18, h: 8 });
  else if (item.inner) {
    const size = placeScope(item.inner, content);
    item.box = content.head(item.name);
    item.w = Math.max(item.box.w, size.w + 2 * EDGE);
    item.h = item.box.h + size.h + EDGE;
    item.inner.left = (item.w - size.w) / 2;
    item.inner.top = item.box.h;
  } else {
    item.box = item.kind === "any" ? content.anywhere() : item.kind === "stub" ? content.stub(item.name) : content.leaf(item.name);
    item.w = item.box.w;
    item.h = item.box.h;
  }
}

/** Ends that have a place of their own: an option's cell, or where an arrow comes through a border. */
function fix(segment) {
  const { a, b, bundle } = segment;
  const cell = a === bundle.from && bundle.option && a.box ? (a.box.cells || []).find((each) => each.choice.name === bundle.option) : null;
  segment.fixedA = Boolean(cell || segment.portA);
  segment.fixedB = Boolean(segment.portB);
  segment.offA = cell ? cell.x + cell.w / 2 - a.w / 2 : segment.portA ? segment.portA.x + a.inner.left - a.w / 2 : 0;
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
    const offHigh = high === segment.a ? segment.offA : segment.offB, offLow = low === segment.a ? segment.offA : segment.offB;
    const points = [[high.X + offHigh, high.Y + high.h], [high.X + offHigh, high.bottom]];
    let strip = high.strip;
    for (const next of [...segment.way, low]) {
      const x = next.X + (next === low ? offLow : next.kind === "label" ? 4 - next.w / 2 : 0);
      if (next.strip !== strip) points.push(...across(points[points.length - 1], [x, next.top], next.gutter));
      strip = next.strip;
      points.push([x, next.top], [x, next === low ? low.Y : next.bottom]);
    }
    return segment.up ? points.reverse() : points;
  });
}

/** From the foot of one strip to the head of another. */
function across([x0, y0], [x1, y1], gutter) {
  return [[x0, y0 + 8], [gutter, y0 + 8], [gutter, y1 - 8], [x1, y1 - 8]];
}

/** Points as the path of an SVG: straight where they are above one another, else a curve that begins and ends upright. */
function pathOf(points) {
  const parts = [`M${round(points[0])}`];
  for (let index = 1; index < points.length; index += 1) {
    const [x0, y0] = points[index - 1], [x1, y1] = points[index];
    if (Math.abs(x0 - x1) < 0.5 || Math.abs(y0 - y1) < 0.5) parts.push(`L${round([x1, y1])}`);
    else parts.push(`C${round([x0, (y0 + y1) / 2])} ${round([x1, (y0 + y1) / 2])} ${round([x1, y1])}`);
  }
  return parts.join("");
}

function round(point) {
  return `${point[0].toFixed(1)},${point[1].toFixed(1)}`;
}
