// Gestures on the picture: orbit, pan, look, dolly and fly.
import { Viewpoint } from "./pathmarch_web.js";

/** Radians of a drag across the picture. */
const TURN = Math.PI;

/** Calls `moved` with a camera, JSON, whenever a gesture on `element` changes it. */
export class Viewport {
  #element;
  #moved;
  #viewpoint = null;
  #pointers = new Map();
  #keys = new Set();

  constructor(element, moved) {
    [this.#element, this.#moved] = [element, moved];
    element.addEventListener("pointerdown", (event) => this.#press(event));
    element.addEventListener("pointermove", (event) => this.#drag(event));
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (event) => this.#pointers.delete(event.pointerId));
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("keydown", (event) => this.#key(event));
    element.addEventListener("keyup", (event) => this.#keys.delete(event.code));
    element.addEventListener("blur", () => this.#keys.clear());
  }

  /** The camera as JSON. */
  get camera() {
    return this.#viewpoint?.json();
  }

  set camera(json) {
    this.#viewpoint?.free();
    this.#viewpoint = new Viewpoint(json);
  }

  #press(event) {
    if (event.target.closest("button, label")) return;
    this.#element.focus({ preventScroll: true });
    this.#element.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  #drag(event) {
    const last = this.#pointers.get(event.pointerId);
    if (!last || !this.#viewpoint) return;
    const height = this.#element.clientHeight;
    const [x, y] = [(event.clientX - last.x) / height, (event.clientY - last.y) / height];
    if (this.#pointers.size > 1) this.#pinch(event, x, y);
    else if (event.shiftKey || event.buttons & 4) this.#viewpoint.pan(x, y);
    else if (event.ctrlKey || event.buttons & 2) {
      const angle = this.#viewpoint.field_of_view();
      this.#viewpoint.look(-x * angle, -y * angle);
    } else this.#viewpoint.orbit(-x * TURN, -y * TURN);
    [last.x, last.y] = [event.clientX, event.clientY];
    this.#moved(this.#viewpoint.json());
  }

  /** Two fingers pan by their mean, and come closer by their distance. */
  #pinch(event, x, y) {
    const other = [...this.#pointers].find(([id]) => id !== event.pointerId)[1];
    const mine = this.#pointers.get(event.pointerId);
    const before = Math.hypot(mine.x - other.x, mine.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    this.#viewpoint.pan(x / 2, y / 2);
    if (after > 10) this.#viewpoint.dolly(before / after);
  }

  #wheel(event) {
    event.preventDefault();
    if (!this.#viewpoint) return;
    const lines = event.deltaMode === 1 ? event.deltaY * 30 : event.deltaY;
    this.#viewpoint.dolly(Math.exp(Math.max(-200, Math.min(200, lines)) * 0.0015));
    this.#moved(this.#viewpoint.json());
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || !this.#viewpoint) return;
    if (!/^(Key[WASDEQ]|Arrow\w+)$/.test(event.code)) return;
    event.preventDefault();
    const isIdle = this.#keys.size === 0;
    this.#keys.add(event.code);
    if (isIdle) this.#fly(performance.now());
  }

  #fly(last) {
    requestAnimationFrame((now) => {
      if (this.#keys.size === 0) return;
      const seconds = Math.min(0.1, Math.max(0.001, (now - last) / 1000));
      const axis = (plus, minus) => Number(this.#keys.has(plus)) - Number(this.#keys.has(minus));
      this.#viewpoint.orbit(axis("ArrowLeft", "ArrowRight") * seconds, axis("ArrowUp", "ArrowDown") * seconds);
      this.#viewpoint.fly(axis("KeyD", "KeyA"), axis("KeyE", "KeyQ"), axis("KeyW", "KeyS"), seconds);
      this.#moved(this.#viewpoint.json());
      this.#fly(now);
    });
  }
}
