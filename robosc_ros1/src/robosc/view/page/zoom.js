// Zoom and pan in a diagram.
"use strict";

const CLOSEST = 8;
const zooms = new Map(); // by component

/** Makes the drawing in an element zoom by its buttons or the wheel (with Ctrl), and pan by dragging. */
class Zoom {
  constructor(pane, name) {
    this.pane = pane;
    this.picture = pane.firstElementChild;
    const { width, height } = this.picture.viewBox.baseVal;
    Object.assign(this, { width, height, scale: 1, x: 0, y: 0, from: null });
    this.buttons = make("span", { className: "zoom" });
    for (const [sign, name, by] of [["−", "Zoom out", 1 / 1.5], ["+", "Zoom in", 1.5]]) {
      const button = make("button", { type: "button", title: `${name} (Ctrl and wheel)`, ariaLabel: name }, sign);
      button.addEventListener("click", () => this.by(by));
      this.buttons.append(button);
    }
    pane.addEventListener("wheel", (event) => this.onWheel(event), { passive: false });
    pane.addEventListener("pointerdown", (event) => {
      if (this.scale > 1) this.from = { x: event.clientX, y: event.clientY };
    });
    pane.addEventListener("pointermove", (event) => this.onMove(event));
    for (const end of ["pointerup", "pointercancel"]) pane.addEventListener(end, () => (this.from = null));
    zooms.set(name, this);
    if (restored.zoom.has(name)) this.restore(...restored.zoom.get(name));
  }

  onWheel(event) {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const box = this.picture.getBoundingClientRect();
    this.by(1.0015 ** -event.deltaY, (event.clientX - box.x) / box.width, (event.clientY - box.y) / box.height);
  }

  onMove(event) {
    if (!this.from || !event.buttons) return;
    const by = [event.clientX - this.from.x, event.clientY - this.from.y];
    if (!this.pane.hasPointerCapture(event.pointerId)) {
      if (Math.hypot(...by) < 4) return; // a click
      this.pane.setPointerCapture(event.pointerId);
    }
    const box = this.picture.getBoundingClientRect();
    this.x -= (by[0] / box.width) * (this.width / this.scale);
    this.y -= (by[1] / box.height) * (this.height / this.scale);
    this.from = { x: event.clientX, y: event.clientY };
    this.show();
  }

  /** Zoom so that a place of the drawing, from 0 to 1, stays where it is. */
  by(factor, left = 0.5, top = 0.5) {
    const before = this.scale;
    this.scale = Math.min(CLOSEST, Math.max(1, this.scale * factor));
    if (this.scale < 1.05) this.scale = 1;
    this.x += left * this.width * (1 / before - 1 / this.scale);
    this.y += top * this.height * (1 / before - 1 / this.scale);
    this.show();
  }

  /** What a link has shown. */
  restore(scale, x, y) {
    Object.assign(this, { scale: Math.min(CLOSEST, Math.max(1, scale)), x, y });
    this.show();
  }

  show() {
    remember();
    const [width, height] = [this.width / this.scale, this.height / this.scale];
    this.x = Math.max(0, Math.min(this.width - width, this.x));
    this.y = Math.max(0, Math.min(this.height - height, this.y));
    this.picture.setAttribute("viewBox", [this.x, this.y, width, height].map(round).join(" "));
    toggle(this.pane, "zoomed", this.scale > 1);
  }
}
