// SPDX-License-Identifier: Apache-2.0
// How much of a chart is drawn: from afar the names, nearer the triggers, then guards, effects and all that is written.
// Rule: a level is drawn where its texts can be read; names are never smaller than LEAST_NAME on the screen where any
// level allows, on a phone LEAST_NARROW, or LEAST_TOGETHER where all are seen then; and there a name is whole rather
// than seen together with all others.

const NAME = 13, LEAST_NAME = 11, LEAST_NARROW = 10, LEAST_TOGETHER = 9, HYSTERESIS = 1.12, LARGEST = 2.4;

/** Coarse to fine. `limit`, `lines`: of a name; `whole`: a word that is wider than the limit, but not than this, is not
 *  cut; `area`: what a state takes at least; `readable`: the least scale. Without `signs` arrows that would
 *  end in a name, since very many lead there or it is far, are left out; where they lead is a tip without a line. */
const LEVELS = [
  { word: "shortest names", lines: 1, limit: 44, area: 1200, readable: LEAST_NAME / NAME, most: 1.6, row: 8, apart: 8,
    close: 6, gutter: 16, edge: 6 },
  { word: "shorter names", lines: 1, limit: 58, area: 1500, readable: LEAST_NAME / NAME, most: 1.6, row: 9, apart: 9,
    close: 6, gutter: 18, edge: 6 },
  { word: "short names", signs: true, lines: 3, limit: 66, whole: 124, area: 2000, readable: LEAST_NAME / NAME,
    most: 1.6, row: 10, apart: 7, close: 5, gutter: 16, edge: 6 },
  { word: "close names", signs: true, lines: 2, limit: 132, area: 2000, readable: LEAST_NAME / NAME, most: 1.6, row: 10,
    apart: 7, close: 5, gutter: 16, edge: 6 },
  { word: "names", signs: true, lines: 2, limit: 132, area: 2200, readable: LEAST_NAME / NAME, most: 1.6, row: 13,
    apart: 16, close: 9, gutter: 30, edge: 10 },
  { word: "triggers", signs: true, triggers: true, limit: 210, area: 6000, readable: 0.9, most: 1.25, row: 15,
    apart: 20, close: 12, gutter: 40, edge: 12 },
  { word: "all", signs: true, triggers: true, all: true, limit: 210, area: 12000, readable: 0.9, most: 1.25, row: 17,
    apart: 26, close: 14, gutter: 48, edge: 14 },
];
const FINEST = LEVELS.length - 1, WHOLE_NAMES = LEVELS.findIndex(({ word }) => word === "names"),
  BROKEN_NAMES = WHOLE_NAMES - 2, BOTH_WAYS = 150, NARROW = 600, FEW = 40;

/** The ways to lay a chart out, each made once: at every level, downwards or to the right. */
class Plans {
  /** @param model {Model}  @param open the open states  @param content what measures the boxes at a level */
  constructor(model, open, content) {
    Object.assign(this, { model, open: new Set(open), content, made: new Map() });
    this.seen = this.count("");
  }

  /** How many states are seen inside one. */
  count(parent) {
    const inside = this.model.children.get(parent);
    return inside.reduce((sum_, name) => sum_ + (this.open.has(name) ? this.count(name) : 0), inside.length);
  }

  /** The layout of a level: {view, size, level, turned}. */
  at(level, turned, room) {
    return finished(this.making(level, turned, room));
  }

  /** The same, in parts, for charts that take a while; yields how far it is. */
  *making(level, turned, room) {
    const key = `${level} ${turned}`;
    if (!this.made.has(key)) {
      const view = yield* viewing(this.model, this.open, Boolean(LEVELS[level].signs));
      const size = yield* layingOut(view, this.content(LEVELS[level], turned),
        { ...LEVELS[level], turned, aspect: turned ? room.h / room.w : room.w / room.h });
      this.made.set(key, { view, size, level, turned });
    }
    return this.made.get(key);
  }

  /** The finest layout of which all is in the room and can be read; where there is none, one whose names are not cut
   *  for nothing. */
  *fitting(room) {
    const area = (room.w * room.h) / (LEVELS[0].readable * LEVELS[0].readable);
    for (let level = FINEST; level > 0; level -= 1) {
      if (this.seen * LEVELS[level].area > 1.6 * area) continue;
      const plan = yield* this.wider(level, room);
      if (scaleOf(plan, room) >= readableIn(level, room)) return plan;
      if (room.narrow && level === BROKEN_NAMES && this.seen <= FEW) return plan;
    }
    const coarsest = yield* this.wider(0, room);
    return this.seen > BOTH_WAYS || scaleOf(coarsest, room) >= LEVELS[0].readable ? coarsest
      : yield* this.wider(BROKEN_NAMES, room);
  }

  /** Downwards, or to the right where that is larger in the room. */
  *wider(level, room) {
    const down = yield* this.making(level, false, room);
    if (this.seen > BOTH_WAYS) return down;
    const right = yield* this.making(level, true, room);
    return scaleOf(right, room) > 1.08 * scaleOf(down, room) ? right : down;
  }
}

/** The least scale of a level where all of it is in the room; names alone are read somewhat smaller on a phone, which
 *  is held near. */
function readableIn(level, room) {
  if (!room.narrow || LEVELS[level].triggers) return LEVELS[level].readable;
  return (level === BROKEN_NAMES ? LEAST_TOGETHER : LEAST_NARROW) / NAME;
}

/** The least scale of a layout that is too large for the room. */
function readableCut(level, room) {
  return Math.max(readableIn(level, room), room.narrow ? LEAST_NARROW / NAME : 0);
}

/** How large a layout is when all of it is in the room. */
function scaleOf({ size, level }, room) {
  return Math.min(room.w / Math.max(size.w, 1), room.h / Math.max(size.h, 1), LEVELS[level].most);
}

/** Whether no name is cut that a layout has. */
function areWhole(view) {
  const texts = [...allItems(view.root)].flatMap((item) => (item.box ? item.box.texts : []));
  return texts.every((line) => !line.bold || !line.whole);
}

function finished(parts) {
  let part = parts.next();
  while (!part.done) part = parts.next();
  return part.value;
}

/** Does work in parts between which the page can be used; the bar shows how far it is. */
class Work {
  constructor(host, words) {
    this.bar = make("progress", { max: "1", value: "0", "aria-label": words });
    this.note = make("div", { class: "drawing", role: "status" }, make("span", {}, words), this.bar);
    host.append(this.note);
    this.stopped = false;
  }

  run(parts, then) {
    this.then = then;
    const turn = () => {
      if (this.stopped) return;
      const end = performance.now() + 14;
      let part;
      do part = parts.next(); while (!part.done && performance.now() < end);
      if (!part.done) this.bar.value = part.value;
      if (!part.done) setTimeout(turn, 0);
      else {
        this.stop();
        this.then();
      }
    };
    setTimeout(turn, 0);
  }

  stop() {
    this.stopped = true;
    this.note.remove();
  }
}
