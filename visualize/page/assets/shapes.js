// SPDX-License-Identifier: Apache-2.0
// The forms of the chart: outlines, texts, trees and tips, drawn where the layout has put them.

function marks(mark) {
  return { "+": " added", "-": " removed", "~": " changed" }[mark] || "";
}

function texts(lines, x, y) {
  return draw("g", { class: "texts", transform: `translate(${x},${y})` }, lines.map((line) =>
    draw("text", { x: line.x, y: line.y, "font-size": line.size, class: `${line.tone}${line.bold ? " bold" : ""}` },
      line.whole ? draw("title", {}, line.whole) : "", line.text)));
}

/** A state's form; finals have a double line, what holds others is drawn on another. */
function outline(state, item) {
  const { w, h } = item, look = lookOf(state)[1];
  if (state.kind === "final") {
    const cut = Math.min(11, 4 + h / 18); // the lower, the less, so that no line runs through the name
    const form = (by, name) => state.outcome === "succeeded"
      ? draw("rect", { class: name, x: by, y: by, width: w - 2 * by, height: h - 2 * by, rx: Math.min(16, h / 2) - by })
      : draw("path", { class: name, d: cornered(by, w, h, cut) });
    return draw("g", {}, form(0, "form"), form(SECOND, "second"));
  }
  const square = ["decision", "tree", "call", "mission"].includes(look);
  const main = draw("rect", { class: "form", width: w, height: h, rx: square ? 1 : 9 });
  if (look === "call") return draw("g", {}, main, draw("path", { class: "second", d: `M4,0V${h}M${w - 4},0V${h}` }));
  if (look === "group" && !item.inner) return draw("g", {},
    draw("rect", { class: "form under", x: 4, y: 4, width: w, height: h, rx: 9 }), main);
  if (look === "tree") return draw("g", {}, draw("path", { class: "second", d: `M8,0V-5H48V0` }), main);
  return main;
}

function cornered(by, w, h, cut) {
  const [l, t, r, b] = [by, by, w - by, h - by], c = cut - by / 2;
  return `M${l + c},${t}H${r - c}L${r},${t + c}V${b - c}L${r - c},${b}H${l + c}L${l},${b - c}V${t + c}Z`;
}

/** A box with its tree below its texts. */
function grownBox(box, tree) {
  const w = Math.max(box.w, tree.w + 2 * PAD);
  return { ...box, w, h: box.h + tree.h + PAD + 4, tree, treeAt: [(w - tree.w) / 2, box.h + 2] };
}

function treeParts(box) {
  const [x, y] = box.treeAt;
  return [draw("g", { class: "twigs", transform: `translate(${x},${y})` },
    box.tree.lines.map(([x0, y0, x1, y1]) => draw("path", { class: "bough", d: pathOf([[x0, y0], [x1, y1]]) })),
    box.tree.twigs.map((each) =>
      draw("g", { class: `twig ${each.twig.kind}${marks(each.twig.mark)}`,
        transform: `translate(${each.x},${each.y})` },
      draw("title", {}, each.twig.text),
      draw("rect", { width: each.w, height: each.h, rx: each.twig.kind === "action" ? 7 : 1 }),
      texts(each.texts, 7, 2))))];
}

/** The tip of an arrow that leads to the right, to a point. */
function tipAt(x, y) {
  return `M${x - 8},${y - 5}L${x},${y}L${x - 8},${y + 5}Z`;
}

function markers() {
  return draw("defs", {}, draw("marker",
    { id: "tip", viewBox: "0 0 8 8", refX: 7.2, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse",
      orient: "auto" },
    draw("path", { class: "tip", d: "M0,0.5L8,4L0,7.5Z" })));
}
