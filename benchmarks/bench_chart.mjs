// SPDX-License-Identifier: Apache-2.0
// CPU microseconds an event in XState, for the states given as JSON; the second argument is where it is installed.
import { createRequire } from "node:module";

const { assign, createActor, createMachine } = createRequire(`${process.argv[3]}/`)("xstate");

const built = (given) => Object.fromEntries(Object.entries(given).map(([name, state]) => [name, {
  id: name,
  ...(state.states ? { initial: state.initial, states: built(state.states) } : {}),
  ...(state.parallel ? { type: "parallel", states: built(state.parallel) } : {}),
  on: Object.fromEntries((state.transitions ?? []).map((row) => [row.on, {
    target: `#${row.to}`,
    ...(row.when ? { guard: ({ context }) => context.n >= 0, actions: assign({ n: ({ context }) => context.n + 1 }) } : {}),
  }])),
}]));
const states = JSON.parse(process.argv[2]);
const actor = createActor(createMachine({ context: { n: 0 }, initial: Object.keys(states)[0], states: built(states) }));
actor.start();
const round = (count) => {
  const begun = process.cpuUsage();
  for (let i = 0; i < count; i++) { actor.send({ type: "a" }); actor.send({ type: "b" }); }
  const { user, system } = process.cpuUsage(begun);
  return (user + system) / (2 * count);
};
round(5_000);
console.log(Math.min(...Array.from({ length: 5 }, () => round(5_000))));
