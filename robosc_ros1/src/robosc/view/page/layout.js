// Where the parts of an automaton lie.
"use strict";

/**
 * Places for a row of boxes as near as possible to where they want to be, in their order and
 * without overlap: the least sum of squares, by pooling adjacent violators.
 */
function settle(boxes, wished, gap) {
  const offsets = [0];
  for (let i = 1; i < boxes.length; i++) {
    offsets.push(offsets[i - 1] + boxes[i - 1].right + gap + boxes[i].left);
  }
  const pools = [];
  boxes.forEach((_, i) => {
    let pool = { sum: wished[i] - offsets[i], count: 1 };
    while (pools.length && pools.at(-1).sum / pools.at(-1).count > pool.sum / pool.count) {
      const before = pools.pop();
      pool = { sum: pool.sum + before.sum, count: pool.count + before.count };
    }
    pools.push(pool);
  });
  const places = [];
  for (const pool of pools) {
    for (let i = 0; i < pool.count; i++) {
      places.push(pool.sum / pool.count + offsets[places.length]);
    }
  }
  return places;
}

/** Nodes in the order in which they are met from the first one. */
function breadthFirst(nodes, links) {
  const order = [];
  const met = new Set();
  for (const start of nodes) {
    const queue = met.has(start) ? [] : [start];
    met.add(start);
    while (queue.length) {
      const node = queue.shift();
      order.push(node);
      for (const link of links) {
        if (link.from === node && !met.has(link.to)) {
          met.add(link.to);
          queue.push(link.to);
        }
      }
    }
  }
  return order;
}

/** Layers by the longest way from above; each link leads over one layer for its label at least. */
function giveRanks(order, links) {
  order.forEach((node, i) => Object.assign(node, { turn: i, rank: 0 }));
  for (const link of links) {
    link.back = link.from.turn > link.to.turn;
    [link.upper, link.lower] = link.back ? [link.to, link.from] : [link.from, link.to];
  }
  for (const node of order) {
    for (const link of links) {
      if (link.upper === node) link.lower.rank = Math.max(link.lower.rank, node.rank + 2);
    }
  }
  for (const node of order.slice(1).reverse()) {
    const below = links.filter((l) => l.upper === node).map((l) => l.lower.rank);
    const above = links.some((l) => l.lower === node);
    if (!above && below.length) node.rank = Math.max(0, Math.min(...below) - 2);
  }
}

/** Rows of boxes: nodes, labels, and bends where a link passes a layer. */
function makeRows(order, links) {
  const rows = [];
  const put = (box, rank) => (rows[rank] ??= []).push(Object.assign(box, { rank }));
  for (const node of order) put(node, node.rank);
  for (const link of links) {
    link.way = [];
    const labelled = link.back ? link.lower.rank - 1 : link.upper.rank + 1;
    for (let rank = link.upper.rank + 1; rank < link.lower.rank; rank++) {
      const half = rank === labelled ? link.width / 2 : 3;
      const bend = { left: half, right: half, height: rank === labelled ? link.height : 0, bend: true };
      if (rank === labelled) link.label = bend;
      put(bend, rank);
      link.way.push(bend);
    }
  }
  const boxes = Array.from(rows, (row) => row ?? []);
  for (const row of boxes) for (const box of row) Object.assign(box, { up: [], down: [] });
  for (const link of links) {
    const chain = [link.upper, ...link.way, link.lower];
    for (let i = 1; i < chain.length; i++) {
      chain[i - 1].down.push(chain[i]);
      chain[i].up.push(chain[i - 1]);
    }
  }
  return boxes;
}

function crossings(rows) {
  let count = 0;
  for (const row of rows) {
    const ends = row.flatMap((box, i) => box.down.map((below) => [i, below.place]));
    for (let a = 0; a < ends.length; a++) {
      for (let b = a + 1; b < ends.length; b++) {
        if ((ends[a][0] - ends[b][0]) * (ends[a][1] - ends[b][1]) < 0) count++;
      }
    }
  }
  return count;
}

/** Order each row by the mean place of its neighbours, downwards and upwards; keep the best. */
function untangle(rows) {
  const number = () => rows.forEach((row) => row.forEach((box, i) => (box.place = i)));
  const mean = (list, other) => (list.length ? list.reduce((s, b) => s + b.place, 0) / list.length : other);
  number();
  let best = { count: crossings(rows), rows: rows.map((row) => [...row]) };
  for (let sweep = 0; sweep < 10 && best.count; sweep++) {
    const side = sweep % 2 ? "down" : "up";
    for (const row of sweep % 2 ? [...rows].reverse() : rows) {
      for (const box of row) box.wish = mean(box[side], box.place);
      row.sort((a, b) => a.wish - b.wish);
      row.forEach((box, i) => (box.place = i));
    }
    const count = crossings(rows);
    if (count < best.count) best = { count, rows: rows.map((row) => [...row]) };
  }
  rows.forEach((row, i) => row.splice(0, row.length, ...best.rows[i]));
  number();
}

/** Columns: each row is drawn to its neighbours, again and again. */
function giveColumns(rows) {
  const put = (row, wished) => settle(row, wished, 16).forEach((x, i) => (row[i].x = x));
  for (const row of rows) put(row, row.map(() => 0));
  for (let sweep = 0; sweep < 24; sweep++) {
    for (const row of sweep % 2 ? [...rows].reverse() : rows) {
      put(row, row.map((box) => {
        const near = sweep < 20 ? (sweep % 2 ? box.down : box.up) : [...box.up, ...box.down];
        return near.length ? near.reduce((s, b) => s + b.x, 0) / near.length : box.x;
      }));
    }
  }
}

/** Where links touch a node's upper or lower side: below their next bend, in its order. */
function ports(node, links, side) {
  const ends = links
    .map((link) => {
      if (side === "down" && link.upper === node) return { link, next: link.way[0] };
      if (side === "up" && link.lower === node) return { link, next: link.way.at(-1) };
      return null;
    })
    .filter(Boolean)
    .sort((a, b) => a.next.x - b.next.x);
  const reach = Math.max(0, node.half - 10);
  const near = (x) => Math.min(node.x + reach, Math.max(node.x - reach, x));
  const dots = ends.map(() => ({ left: 0, right: 0 }));
  const gap = Math.min(14, (2 * reach) / Math.max(1, ends.length - 1));
  settle(dots, ends.map((end) => near(end.next.x)), gap).forEach((x, i) => {
    ends[i].link[side === "down" ? "leaves" : "enters"] = near(x);
  });
}

/**
 * A layered drawing after Sugiyama, Tagawa and Toda (1981): `nodes` have `left`, `right`, `height`
 * and `half` (of the box itself); `links` join two of them and have the `width` and `height` of
 * their labels. All have their ranks, and get their places; the result is the size of the whole.
 */
function placeRanked(nodes, links) {
  const rows = makeRows(nodes, links);
  untangle(rows);
  giveColumns(rows);
  let y = 12;
  for (const row of rows) {
    const height = Math.max(4, ...row.map((box) => box.height));
    for (const box of row) box.y = y + height / 2;
    y += height + 11;
  }
  const boxes = rows.flat();
  const shift = 14 - Math.min(...boxes.map((box) => box.x - box.left));
  for (const box of boxes) box.x += shift;
  for (const node of nodes) for (const side of ["up", "down"]) ports(node, links, side);
  return { width: Math.max(...boxes.map((box) => box.x + box.right)) + 14, height: y };
}

/** A curve through the bends, upright at ends and labels, in the direction of the arrow. */
function pathOf(link) {
  const reach = ({ tall, height }) => (tall ?? height) / 2; // loops are higher than their nodes
  const points = [[link.leaves, link.upper.y + reach(link.upper)]];
  for (const bend of link.way) {
    if (bend.height) points.push([bend.x, bend.y - bend.height / 2], [bend.x, bend.y + bend.height / 2]);
    else points.push([bend.x, bend.y, "free"]);
  }
  points.push([link.enters, link.lower.y - reach(link.lower)]);
  if (link.back) points.reverse();
  const slopes = points.map(([, , free], i) =>
    free ? (points[i + 1][0] - points[i - 1][0]) / (points[i + 1][1] - points[i - 1][1]) : 0);
  let text = `M${round(points[0][0])},${round(points[0][1])}`;
  for (let i = 1; i < points.length; i++) {
    const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
    const half = (y1 - y0) / 2;
    text += `C${round(x0 + slopes[i - 1] * half)},${round(y0 + half)} ` +
      `${round(x1 - slopes[i] * half)},${round(y1 - half)} ${round(x1)},${round(y1)}`;
  }
  return text;
}

const round = (x) => Math.round(x * 10) / 10;
