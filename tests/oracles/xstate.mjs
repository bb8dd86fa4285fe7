// SPDX-License-Identifier: Apache-2.0
// Runs generated charts in XState: a line of JSON in, {"document", "script"}, a line with the trace out.
import { createInterface } from "node:readline";
import { and, assign, createActor, createMachine, not, or, raise, stateIn } from "xstate";

const many = (given) => (given === undefined ? [] : Array.isArray(given) ? given : [given]);
const compare = {
  "==": (a, b) => a === b, "!=": (a, b) => a !== b, "<": (a, b) => a < b,
  "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b,
};

function run({ document, script }) {
  let logged = [];
  const guard = (given) => {
    if (given.key !== undefined) {
      const op = Object.keys(given).find((word) => word !== "key");
      return ({ context }) => compare[op](context[given.key], given[op]);
    }
    if (given.in !== undefined) return stateIn(`#${given.in}`);
    if (given.not !== undefined) return not(guard(given.not));
    return given.all !== undefined ? and(given.all.map(guard)) : or(given.any.map(guard));
  };
  const action = (effect) => {
    if (effect.log !== undefined) return () => { logged.push(effect.log); };
    if (effect.raise !== undefined) return raise({ type: effect.raise });
    const value = (context) => (effect.add !== undefined ? context[effect.set] + effect.add : effect.value);
    return assign(({ context }) => ({ [effect.set]: value(context) }));
  };
  const transition = (given) => ({
    ...(given.to === undefined ? {} : { target: many(given.to).map((name) => `#${name}`), reenter: !given.internal }),
    ...(given.when === undefined ? {} : { guard: guard(given.when) }),
    actions: (given.do ?? []).map(action),
  });
  const state = (name, given, parent) => {
    if (given.history !== undefined) return { id: name, type: "history", history: given.history, target: `#${parent.initial}` };
    const children = given.states ?? given.parallel ?? {};
    const made = {
      id: name, entry: (given.entry ?? []).map(action), exit: (given.exit ?? []).map(action), on: {}, always: [], onDone: [],
    };
    if (given.final !== undefined) return { ...made, type: "final", on: undefined, always: undefined, onDone: undefined };
    if (given.parallel !== undefined) made.type = "parallel";
    if (given.states !== undefined) made.initial = given.initial;
    for (const each of given.transitions ?? []) {
      if (each.on === undefined) made.always.push(transition(each));
      for (const event of many(each.on)) {
        if (event === "succeeded") made.onDone.push(transition(each));
        else (made.on[event] ??= []).push(transition(each));
      }
    }
    if (Object.keys(children).length > 0) {
      made.states = Object.fromEntries(Object.entries(children).map(([child, inner]) => [child, state(child, inner, given)]));
    }
    return made;
  };
  const states = Object.entries(document.states).map(([name, each]) => [name, state(name, each, document)]);
  const context = Object.fromEntries(Object.entries(document.blackboard).map(([name, key]) => [name, key.initial]));
  const machine = createMachine({ id: "mission", context, initial: document.initial, states: Object.fromEntries(states) });
  const actor = createActor(machine);
  const observed = () => {
    const snapshot = actor.getSnapshot();
    const active = snapshot._nodes.map((node) => node.id).filter((id) => id !== "mission");
    const logs = logged;
    logged = [];
    return [active, logs, snapshot.status === "done" ? "succeeded" : snapshot.status === "active" ? "" : snapshot.status];
  };
  actor.start();
  const trace = [observed()];
  for (const name of script) {
    if (actor.getSnapshot().status === "active") actor.send({ type: name });
    trace.push(observed());
  }
  actor.stop();
  return trace;
}

for await (const line of createInterface({ input: process.stdin })) {
  try {
    console.log(JSON.stringify(run(JSON.parse(line))));
  } catch (error) {
    console.log(JSON.stringify({ error: String(error.stack) }));
  }
}
