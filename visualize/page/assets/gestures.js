// SPDX-License-Identifier: Apache-2.0
// Moving about: pan by drag, zoom by wheel or pinch, fit.

const LEAST = 0.05, MOST = 4;
const PANS = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] };

class Gestures {
  constructor(svg, layer, { size, zoomed, moved }) {
    Object.assign(this, { svg, layer, size, zoomed, moved, x: 0, y: 0, scale: 1, pointers: new Map() });
    svg.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    svg.addEventListener("pointerdown", (event) => this.down(event));
    svg.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) svg.addEventListener(end,
      (event) => this.pointers.delete(event.pointerId));
    svg.addEventListener("click", (event) => { if (this.dragged) event.stopPropagation(); }, true);
  }

  /** What part of the chart is seen, to compare. */
  get at() {
    return `${this.x} ${this.y} ${this.scale}`;
  }

  apply() {
    this.layer.setAttribute("transform",
      `translate(${this.x.toFixed(2)},${this.y.toFixed(2)}) scale(${this.scale.toFixed(4)})`);
    this.moved();
  }

  wheel(event) {
    event.preventDefault();
    const box = this.svg.getBoundingClientRect();
    const step = event.deltaMode ? event.deltaY * 24 : event.deltaY;
    this.zoom(Math.exp(-step * 0.0016), event.clientX - box.left, event.clientY - box.top);
  }

  down(event) {
    if (event.button) return;
    this.dragged = false;
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    if (!this.dragged && Math.hypot(now[0] - before[0], now[1] - before[1]) < 4) return;
    if (!this.dragged) this.svg.setPointerCapture(event.pointerId);
    this.dragged = true;
    const other = [...this.pointers.entries()].find(([id]) => id !== event.pointerId);
    if (other) {
      const box = this.svg.getBoundingClientRect(),
        away = (point) => Math.hypot(point[0] - other[1][0], point[1] - other[1][1]);
      this.zoom(away(now) / Math.max(1, away(before)), other[1][0] - box.left, other[1][1] - box.top);
    } else {
      this.x += now[0] - before[0];
      this.y += now[1] - before[1];
      this.apply();
    }
    this.pointers.set(event.pointerId, now);
  }

  /** Nearer or farther, with one point of the window held. */
  zoom(by, x, y) {
    const box = this.svg.getBoundingClientRect();
    const scale = Math.min(MOST, Math.max(Math.min(LEAST, this.scale), this.scale * by));
    const [holdX, holdY] = [x ?? box.width / 2, y ?? box.height / 2];
    this.x = holdX - ((holdX - this.x) * scale) / this.scale;
    this.y = holdY - ((holdY - this.y) * scale) / this.scale;
    this.scale = scale;
    this.apply();
    this.zoomed(holdX, holdY);
  }

  /** A place of the chart at a point of the window. */
  hold(scale, place, [x, y]) {
    this.scale = scale;
    [this.x, this.y] = [x - place.x * scale, y - (place.y + place.h / 2) * scale];
    this.apply();
  }

  /** Where the middle of a place of the chart is in the window. */
  outside(place) {
    return [this.x + place.x * this.scale, this.y + (place.y + place.h / 2) * this.scale];
  }

  /** The edges of a place of the chart in the window. */
  edges({ x, y, w, h }) {
    return { left: this.x + (x - w / 2) * this.scale, right: this.x + (x + w / 2) * this.scale,
      top: this.y + y * this.scale, bottom: this.y + (y + h) * this.scale };
  }

  /** Whether a place of the chart is in the window, all of it or a part. */
  isSeen(place, whole) {
    const { left, right, top, bottom } = this.edges(place), { width, height } = this.svg.getBoundingClientRect();
    return whole ? left >= 0 && top >= 0 && right <= width && bottom <= height
      : left < width && top < height && right > 0 && bottom > 0;
  }

  /** Moves as little as brings a place of the chart into the window; of one that is larger, its upper left part. */
  bring(place, margin) {
    const { left, right, top, bottom } = this.edges(place), { width, height } = this.svg.getBoundingClientRect();
    const by = (from, to, room) =>
      (from < margin || to - from > room - 2 * margin ? margin - from : to > room - margin ? room - margin - to : 0);
    const [x, y] = [by(left, right, width), by(top, bottom, height)];
    if (x || y) this.pan(x, y);
  }

  /** A point of the window on the chart's measure. */
  inside(x, y) {
    return { x: (x - this.x) / this.scale, y: (y - this.y) / this.scale };
  }

  pan(x, y) {
    this.x += x;
    this.y += y;
    this.apply();
  }

  /** By so much of the chart's own measure. */
  shift(x, y) {
    this.pan(x * this.scale, y * this.scale);
  }

  center(x, y) {
    const box = this.svg.getBoundingClientRect();
    if (this.scale < 0.5) this.scale = 0.8;
    this.x = box.width / 2 - x * this.scale;
    this.y = box.height / 2 - y * this.scale;
    this.apply();
    this.zoomed(box.width / 2, box.height / 2);
  }

  /** A part of the chart, as large as it can be seen whole. */
  frame({ x, y, w, h }, room, most) {
    const box = this.svg.getBoundingClientRect(),
      scale = Math.min(room.w / Math.max(w, 1), room.h / Math.max(h, 1), most);
    this.set(box.width / 2 - (x + w / 2) * scale, box.height / 2 - (y + h / 2) * scale, scale);
  }

  set(x, y, scale) {
    Object.assign(this, { x, y, scale });
    this.apply();
  }

  /** All of it, however small; or at least so large that it can be read, and then from a place that is to be seen. */
  fit(least, first, { most, margin }) {
    const box = this.svg.getBoundingClientRect(), { w, h } = this.size();
    const scale = Math.min((box.width - margin) / Math.max(w, 1), (box.height - margin) / Math.max(h, 1), most);
    this.scale = Math.max(scale, least, 0.001);
    this.x = this.edge(box.width, w, margin / 2, first && [first.x - first.w / 2, first.w]);
    this.y = this.edge(box.height, h, margin / 2, first && [first.y, first.h]);
    this.apply();
  }

  /** Where the chart begins on one axis: in the middle, or such that what is to be seen is, and no more is left out
   *  than must be. */
  edge(room, size, margin, first) {
    const full = size * this.scale;
    if (full + 2 * margin <= room + 0.5 || !first) return Math.max(margin, (room - full) / 2);
    const [from, length] = first, middle = room / 2 - (from + length / 2) * this.scale;
    const start = length * this.scale + 4 * margin > room ? 3 * margin - from * this.scale : middle;
    return Math.min(margin, Math.max(room - full - margin, start));
  }
}
