// SPDX-License-Identifier: Apache-2.0
// The layers of one scope: which box is on which, in which order, and how far to the right.
// Sources: layers and dummies as Sugiyama, Tagawa and Toda (1981); places within a layer by isotonic regression.

const SWEEPS = 8, PULLS = 8;

/** Gives every item a rank (even; labels and bends are between) and every segment a way, up or down. */
function rankScope(scope) {
  const inner = scope.items.filter((item) => item.kind !== "port");
  const out = new Map(inner.map((item) => [item, []]));
  const touched = new Set();
  for (const segment of scope.segments) {
    touched.add(segment.a).add(segment.b);
    if (segment.a.kind !== "port" && segment.b.kind !== "port") out.get(segment.a).push(segment);
  }
  const order = orient(inner, out);
  for (const item of inner) item.rank = 0;
  for (const item of order) {
    for (const { low, high } of out.get(item).map(ends)) if (high === item) low.rank =
      Math.max(low.rank, high.rank + 2);
  }
  settle(inner, scope.segments);
  const joined = inner.some((item) => out.get(item).length); // regions are not, whatever enters and leaves them
  const loose = joined ? inner.filter((item) => !touched.has(item)) : inner,
    last = Math.max(0, ...inner.map((item) => item.rank));
  shelve(loose.filter((item) => !item.final), joined);
  for (const item of loose) if (item.final) item.rank = joined ? last + 2 : item.rank;
  const ranks = inner.map((item) => item.rank);
  const top = Math.min(0, ...ranks) - 2, bottom = Math.max(0, ...ranks) + 2;
  for (const item of scope.items) if (item.kind === "port") item.rank = item.side === "top" ? top : bottom;
}

function ends(segment) {
  return segment.up ? { high: segment.b, low: segment.a } : { high: segment.a, low: segment.b };
}

/** Turns the arrows that close a circle; returns the items so that each is before those it leads to. */
function orient(items, out) {
  const seen = new Map(), order = [];
  const first = { start: 0, tab: 1, any: 3 };
  const roots = [...items].sort((a, b) => (first[a.kind] ?? 2) - (first[b.kind] ?? 2));
  const visit = (root) => {
    const path = [[root, out.get(
      root)[Symbol.iterator]()]]; // not by recursion: a chain may be longer than the stack is deep
    seen.set(root, "open");
    while (path.length) {
      const [item, segments] = path[path.length - 1], next = segments.next();
      if (next.done) {
        seen.set(item, "done");
        order.push(item);
        path.pop();
      } else if (seen.get(next.value.b) === "open") {
        next.value.up = true;
      } else if (!seen.has(next.value.b)) {
        seen.set(next.value.b, "open");
        path.push([next.value.b, out.get(next.value.b)[Symbol.iterator]()]);
      }
    }
  };
  for (const item of roots) if (!seen.has(item)) visit(item);
  order.reverse();
  for (const item of items) for (const segment of [...out.get(item)]) if (segment.up
    && !out.get(segment.b).includes(segment)) out.get(segment.b).push(segment);
  return order;
}

/** What nothing leads to is right above what it leads to. */
function settle(items, segments) {
  const above = new Set(), next = new Map();
  for (const segment of segments) {
    const { high, low } = ends(segment);
    if (high.kind === "port" || low.kind === "port") continue;
    above.add(low);
    next.set(high, Math.min(next.get(high) ?? Infinity, low.rank));
  }
  for (const item of items) if (!above.has(item) && next.has(item)) item.rank = next.get(item) - 2;
  const least = Math.min(0, ...items.map((item) => item.rank));
  for (const item of items) item.rank -= least;
}

/** Items without arrows get rows of their own. */
function shelve(loose, others) {
  const across = loose.length <= 4 ? 4 : Math.ceil(Math.sqrt(loose.length * 1.4));
  loose.forEach((item, index) => {
    item.rank = 2 * Math.floor(index / across) - (others ? 2 * Math.ceil(loose.length / across) : 0);
  });
}

/** Layers with bends and labels, and links between neighbours in them. */
function layered(scope) {
  const least = Math.min(...scope.items.map((item) => item.rank), 0);
  for (const item of scope.items) item.rank -= least;
  const layers = [];
  const at = (rank) => (layers[rank] = layers[rank] || []);
  const links = [];
  for (const segment of scope.segments) {
    const { high, low } = ends(segment);
    segment.way = [];
    let before = high;
    for (let rank = high.rank + 1; rank < low.rank; rank += 1) {
      const labelled = segment.label && rank === (segment.up ? low.rank - 1 : high.rank + 1);
      const bend = labelled ? { kind: "label", w: segment.label.w, h: segment.label.h, texts: segment.label.texts,
        counted: segment.label.counted } : { kind: "bend", w: 4, h: 0 };
      bend.rank = rank;
      segment.way.push(bend);
      links.push({ high: before, low: bend, segment });
      before = bend;
    }
    links.push({ high: before, low, segment });
  }
  for (const item of scope.items) Object.assign(item, { ups: [], downs: [], placed: false });
  for (const segment of scope.segments) for (const bend of segment.way) Object.assign(bend,
    { ups: [], downs: [], placed: false });
  for (const link of links) {
    link.high.downs.push(link);
    link.low.ups.push(link);
  }
  const put = (root) => {
    for (const path = [root]; path.length;) {
      const item = path.pop();
      if (item.placed) continue;
      item.placed = true;
      at(item.rank).push(item);
      path.push(...item.downs.map((link) => link.low).reverse());
    }
  };
  for (const item of [...scope.items].sort((a, b) => a.rank - b.rank)) put(item);
  for (let rank = 0; rank < layers.length; rank += 1) at(rank).forEach((item, index) => (item.order = index));
  return layers;
}

function offset(link, item) {
  if (item.kind === "label") return 4 - item.w / 2;
  const segment = link.segment;
  return item === segment.a ? segment.offA || 0 : item === segment.b ? segment.offB || 0 : 0;
}

function* untangle(layers) {
  let best = Infinity, kept = null;
  const sweeps = layers.length > 120 ? 4 : SWEEPS;
  for (let sweep = 0; sweep <= sweeps; sweep += 1) {
    const crossings = layers.reduce((sum, layer) => sum + crossed(layer), 0);
    if (crossings < best) {
      best = crossings;
      kept = layers.map((layer) => [...layer]);
    }
    if (!crossings || sweep === sweeps) break;
    const down = sweep % 2 === 0;
    for (const layer of down ? layers : [...layers].reverse()) sortLayer(layer, down);
    yield 0.3 + (0.2 * sweep) / sweeps;
  }
  kept.forEach((layer, rank) => {
    layers[rank] = layer;
    layer.forEach((item, index) => (item.order = index));
  });
}

function sortLayer(layer, down) {
  const wish = new Map();
  for (const item of layer) {
    const links = down ? item.ups : item.downs;
    const places = links.map((link) => {
      const other = down ? link.high : link.low;
      return other.order + (other.w ? (0.8 * offset(link, other)) / other.w : 0);
    });
    wish.set(item, places.length ? places.reduce((sum, each) => sum + each, 0) / places.length : item.order);
  }
  layer.sort((a, b) => wish.get(a) - wish.get(b) || a.order - b.order);
  layer.forEach((item, index) => (item.order = index));
}

/** How often the links above a layer cross. */
function crossed(layer) {
  const links = layer.flatMap((item) =>
    item.ups.map((link) => [link.high.order + (link.high.w ? offset(link, link.high) / (link.high.w * 1.2) : 0),
      item.order]));
  links.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const seen = [];
  let count = 0;
  for (const [, low] of links) {
    let left = 0, right = seen.length;
    while (left < right) {
      const middle = (left + right) >> 1;
      if (seen[middle] <= low) left = middle + 1;
      else right = middle;
    }
    count += seen.length - left;
    seen.splice(left, 0, low);
  }
  return count;
}

/** Middles from left to right: as near as can be to what each item is linked with, none upon another. */
function* placeAcross(layers, room) {
  for (const layer of layers) {
    let right = 0;
    for (const item of layer) {
      item.x = right + item.w / 2;
      right += item.w + gap(item, item, room);
    }
  }
  for (let pull = 0; pull <= PULLS; pull += 1) {
    const way = pull === PULLS ? "both" : pull % 2 ? "up" : "down";
    for (const layer of way === "up" ? [...layers].reverse() : layers) pullLayer(layer, way, room);
    yield 0.5 + (0.2 * pull) / PULLS;
  }
}

function gap(a, b, { apart, close }) {
  return a.kind === "bend" || b.kind === "bend" ? close : apart;
}

function pullLayer(layer, way, room) {
  const wishes = layer.map((item) => {
    const links = [...(way === "up" ? [] : item.ups), ...(way === "down" ? [] : item.downs)];
    let sum = 0, weight = 0;
    for (const link of links) {
      const other = link.high === item ? link.low : link.high;
      const straight = (item.kind === "bend" ? 1 : 0) + (other.kind === "bend" ? 1 : 0);
      const heavy = link.segment.bundle.target ? 0.05 : link.segment.bundle.start ? 3 : [1, 2, 8][straight];
      sum += heavy * (other.x + offset(link, other) - offset(link, item));
      weight += heavy;
    }
    return weight ? { x: sum / weight, weight } : { x: item.x, weight: 0.05 };
  });
  const places = [0];
  for (let index = 1; index < layer.length; index += 1) {
    places.push(places[index - 1] + layer[index - 1].w / 2 + gap(layer[index - 1], layer[index],
      room) + layer[index].w / 2);
  }
  const blocks = [];
  wishes.forEach((wish, index) => {
    blocks.push({ sum: (wish.x - places[index]) * wish.weight, weight: wish.weight, count: 1 });
    while (blocks.length > 1) {
      const last = blocks[blocks.length - 1], before = blocks[blocks.length - 2];
      if (before.sum / before.weight <= last.sum / last.weight) break;
      blocks.splice(-2, 2, { sum: before.sum + last.sum, weight: before.weight + last.weight,
        count: before.count + last.count });
    }
  });
  let index = 0;
  for (const block of blocks) for (let each = 0; each < block.count; each += 1, index += 1) layer[index].x =
    places[index] + block.sum / block.weight;
}
