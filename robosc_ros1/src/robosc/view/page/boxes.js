// States in states: each box is a drawing of its own, and one node of the drawing around it.
"use strict";

const TITLE = 20; // pixels above what stands in a box

/** Whether the state of a path is the one of another path, or stands in it. */
const standsIn = (path, place) => path === place || path.startsWith(`${place}.`);

/** The name of a state without those of the states around it. */
const bareName = (path) => path.slice(path.lastIndexOf(".") + 1);

/** The node or box of a level that a path stands in; `inside` is the path of the level, or "". */
function headOf(path, inside) {
  const rest = inside ? path.slice(inside.length + 1) : path;
  return (inside ? `${inside}.` : "") + rest.split(".")[0];
}

/**
 * One level of a drawing: `nodes` stand in the state `inside` (or in none), `links` join paths in it.
 * `gates` are ends of links that lead on outside: `path` joined with the upper or the lower `side`.
 */
class Level {
  constructor(nodes, links, inside = "", gates = []) {
    this.inside = inside;
    this.items = [];
    const heads = new Map();
    for (const node of nodes) {
      const path = node.any ? "" : headOf(node.path, inside);
      if (node.any || path === node.path) {
        this.items.push(node);
        heads.set(path, node);
      } else if (heads.has(path)) heads.get(path).members.push(node);
      else {
        const box = { box: true, path, members: [node], links: [], gates: [] };
        this.items.push(box);
        heads.set(path, box);
      }
    }
    const itemOf = (path) => heads.get(path && headOf(path, inside));
    this.links = [];
    for (const link of links) {
      const [from, to] = [itemOf(link.source), itemOf(link.target)];
      if (from === to) from.links.push(link);
      else this.links.push(Object.assign(link, { from, to, chains: [[], []] }));
    }
    this.gates = gates.map((gate) => {
      const end = { gate, left: 0, right: 0, half: 0, height: 0 };
      const item = itemOf(gate.path);
      const [from, to] = gate.outwards ? [item, end] : [end, item];
      const ends = gate.outwards ? { source: gate.path } : { target: gate.path };
      const piece = { ...ends, from, to, width: 0, height: 0, chains: [[], []] };
      gate.piece = piece;
      this.links.push(piece);
      return end;
    });
    this.place();
  }

  place() {
    const [upper, lower] = ["up", "down"].map((side) => this.gates.filter((g) => g.gate.side === side));
    const own = this.links.filter((l) => !l.from.gate && !l.to.gate);
    const order = [...upper, ...breadthFirst(this.items, own), ...lower];
    giveRanks(order, this.links);
    const lowest = Math.max(...order.map((item) => item.rank));
    for (const end of upper) end.rank = 0;
    for (const end of lower) end.rank = lowest;
    for (const item of this.items) if (item.box) this.fill(item);
    this.size = placeRanked(order, this.links);
    for (const end of upper) end.y = -TITLE;
    for (const end of lower) end.y = this.size.height;
    for (const item of this.items) if (item.box) this.fix(item);
  }

  /** Draw what stands in a box, with gates for the links that lead to what stands in it. */
  fill(box) {
    for (const link of this.links) {
      for (const outwards of [true, false]) {
        const path = outwards ? link.source : link.target;
        if ((outwards ? link.from : link.to) !== box || path === box.path) continue;
        box.gates.push({ path, outwards, side: link.upper === box ? "down" : "up", link });
      }
    }
    box.level = new Level(box.members, box.links, box.path, box.gates);
    const width = Math.max(box.level.size.width, widthOf(bareName(box.path), "600 12.5px") + 24);
    const half = width / 2;
    Object.assign(box, { half, left: half, right: half, height: box.level.size.height + TITLE });
  }

  /** The place of a box is known: what stands in it follows, and links go through its gates. */
  fix(box) {
    box.level.move(box.x - box.half, box.y - box.height / 2 + TITLE);
    for (const { outwards, side, link, piece } of box.gates) {
      link[side === "down" ? "leaves" : "enters"] = (outwards ? piece.to : piece.from).x;
      link.chains[outwards ? 0 : 1] = outwards
        ? [...piece.chains[0], piece] : [piece, ...piece.chains[1]];
    }
  }

  move(dx, dy) {
    const shift = (part) => {
      part.x += dx;
      part.y += dy;
    };
    this.items.forEach(shift);
    this.gates.forEach(shift);
    for (const item of this.items) if (item.box) item.level.move(dx, dy);
    for (const link of this.links) {
      link.way.forEach(shift);
      link.leaves += dx;
      link.enters += dx;
    }
  }

  /** All boxes, the outer ones first. */
  get boxes() {
    return this.items.filter((item) => item.box).flatMap((box) => [box, ...box.level.boxes]);
  }
}

/** The whole way of a link, through the borders of boxes. */
const wayOf = (link) => [...link.chains[0], link, ...link.chains[1]].map(pathOf).join("");
