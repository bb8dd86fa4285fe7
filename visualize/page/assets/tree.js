// SPDX-License-Identifier: Apache-2.0
// A behaviour tree inside its state: what arranges is above what it arranges, in the order in which it is tried.

const TWIG = 132, BETWEEN = 10, DOWN = 24;

/** Measured and placed: {w, h, twigs: [{x, y, w, h, texts, twig}], lines: [[x, y, x, y]]}. */
function treeBox(twigs) {
  const below = new Map(twigs.map((twig) => [twig.path, []]));
  let root = null;
  for (const twig of twigs) {
    if (twig.parent === null || twig.parent === undefined) root = twig;
    else below.get(twig.parent).push(twig);
  }
  const found = { w: 0, h: 0, twigs: [], lines: [] };
  if (!root) return found;
  const measured = measuredTwig(root, below);
  placeTwig(measured, 0, 0, found);
  found.w = measured.w;
  found.h = Math.max(...found.twigs.map((each) => each.y + each.h));
  return found;
}

function twigColumn(twig) {
  const column = new Column(TWIG);
  if (twig.branch) column.add(`${twig.branch}:`, 10, { bold: true });
  const [head, ...rest] = `${twig.number ? `${twig.number}. ` : ""}${twig.text}`.split("; ");
  column.add(marked(twig.mark, head), 11, { bold: true, most: 3 });
  rest.forEach((line) => column.add(line, 10, { tone: "muted", most: 3 }));
  for (const choice of twig.choices || []) {
    const bound = choice.guard ? `when ${choice.guard}` : choice.fallback ? "fallback" : "always open";
    column.add(`• ${marked(choice.mark, choice.name)}: ${bound}`, 10, { most: 3 });
  }
  return column;
}

function measuredTwig(twig, below) {
  const column = twigColumn(twig);
  const children = below.get(twig.path).map((child) => measuredTwig(child, below));
  const across = children.reduce((sum, child) => sum + child.w, Math.max(0, children.length - 1) * BETWEEN);
  const own = { w: column.w + 14, h: column.h + 8 };
  return { twig, column, children, own, across, w: Math.max(own.w, across) };
}

/** A node in the middle above its branches; returns its own middle. */
function placeTwig(measured, left, top, found) {
  const { own, w, across, children, column, twig } = measured;
  const middle = left + w / 2;
  found.twigs.push({ x: middle - own.w / 2, y: top, w: own.w, h: own.h, texts: column.texts, twig });
  let at = left + (w - across) / 2;
  for (const child of children) {
    const to = placeTwig(child, at, top + own.h + DOWN, found);
    found.lines.push([middle, top + own.h, to, top + own.h + DOWN]);
    at += child.w + BETWEEN;
  }
  return middle;
}
