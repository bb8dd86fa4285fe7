// SPDX-License-Identifier: Apache-2.0
// A run at any of its steps: what was active and what was known, from what each step changed.

const KEYFRAME = 256;

class Replay {
  /** @param run as in the page's data  @param keys the mission's keys */
  constructor(run, keys) {
    this.run = run;
    this.length = run.steps.length;
    this.keys = keys;
    const board = new Map(), at = this.length ? run.steps[0][1] : 0;
    for (const [name, key] of Object.entries(keys)) if (key.initial !== undefined && key.initial !== null) board.set(
      name, [key.initial, at]);
    for (const [name, value] of Object.entries(run.head.arguments || {})) board.set(name, [value, at]);
    this.frames = [];
    let frame = { active: new Set(), board };
    for (let index = 0; index < this.length; index += 1) {
      if (index % KEYFRAME === 0) this.frames.push({ active: new Set(frame.active), board: new Map(frame.board) });
      this.fold(frame, index);
    }
  }

  fold(frame, index) {
    const { moves, writes } = this.step(index);
    for (const [, exited, entered] of moves) {
      for (const name of exited) frame.active.delete(name);
      for (const name of entered) frame.active.add(name);
    }
    for (const [key, value, stamp] of writes) {
      if (value === null) frame.board.delete(key); // a process that continues must receive it again
      else frame.board.set(key, [value, stamp]);
    }
  }

  /** What a step itself recorded. */
  step(index) {
    const [seq, at, event, moves, guards, writes, more] = this.run.steps[index], pool = this.run.pool;
    return { seq, at, event: pool[event], moves: pool[moves], guards: pool[guards], writes: pool[writes],
      more: pool[more] };
  }

  /** What was so right after a step. */
  at(index) {
    const nearest = Math.floor(index / KEYFRAME), kept = this.frames[nearest];
    const frame = { active: new Set(kept.active), board: new Map(kept.board) };
    for (let each = nearest * KEYFRAME; each <= index; each += 1) this.fold(frame, each);
    return frame;
  }

  /** Whether a value is too old to be believed. */
  stale(name, stamp, at) {
    const most = (this.keys[name] || {}).max_age_s;
    return most !== undefined && at >= stamp + most;
  }

  /** The first step that did something; the first of all where none did. */
  first() {
    const found = this.moved(-1, 1);
    return found >= 0 && this.step(found).moves.length ? found : 0;
  }

  /** Whether a step moved, asked or ended something. */
  isChange(index) {
    const { moves, more } = this.step(index);
    return Boolean(moves.length || more.outcome || more.asks);
  }

  changes() {
    return this.run.steps.map((_, index) => index).filter((index) => this.isChange(index));
  }

  /** The next change, or the one before. */
  moved(index, way) {
    for (let each = index + way; each >= 0 && each < this.length; each += way) if (this.isChange(each)) return each;
    return way < 0 ? 0 : this.length - 1;
  }
}
