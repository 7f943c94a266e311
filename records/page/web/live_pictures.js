// SPDX-License-Identifier: Apache-2.0
// The pictures of a flight that is still flown: the one of the time that is shown. Videos there are when it has ended.
const kKeptPictures_bytes = 48e6;  // of each kind; of what is older every second one goes

class LivePictures {
  constructor(name) {
    Object.assign(this, {name, all: [], bytes: 0, shown: null, drawn: null});
    clock.onTime((t_s) => this.show(t_s));
  }

  add(t_s, jpeg) {
    this.all.push({t_s, jpeg});
    this.bytes += jpeg.size;
    if (this.bytes > kKeptPictures_bytes) this.thin();
    this.show(clock.t_s);
  }
  thin() {
    const older = Math.floor(this.all.length * 0.75);
    this.all = this.all.filter((_, i) => i >= older || i % 2 === 0);
    this.bytes = this.all.reduce((sum, {jpeg}) => sum + jpeg.size, 0);
  }
  clear() { Object.assign(this, {all: [], bytes: 0}); }

  // Of what is to come the newest; else the last one that is not later.
  at(t_s) {
    if (clock.following) return this.all.at(-1);
    let low = 0, high = this.all.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.all[middle].t_s <= t_s + 1e-6) low = middle;
      else high = middle - 1;
    }
    return this.all[low];
  }
  show(t_s) {
    this.shown = this.at(t_s) ?? this.shown;
    if (!this.drawing) this.draw();
  }
  // One at a time; those that came meanwhile are passed over.
  async draw() {
    this.drawing = true;
    while (this.drawn !== this.shown) {
      this.drawn = this.shown;
      try {
        this.paint(await createImageBitmap(this.drawn.jpeg));
      } catch (error) {  // no JPEG: the one before stays
        console.info(error);
      }
    }
    this.drawing = false;
  }
  paint(picture) {
    this.canvas ??= this.pane();
    const {canvas} = this;
    if (canvas.width !== picture.width || canvas.height !== picture.height)
      [canvas.width, canvas.height] = [picture.width, picture.height];
    canvas.getContext("2d").drawImage(picture, 0, 0);
    picture.close();
  }
  pane() {
    const {title} = panes[this.name], canvas = el("canvas", {role: "img", "aria-label": title});
    const figure = pane(`${this.name}-pane`, title, canvas), first = byId("video-pane");
    if (first) first.after(figure);
    else byId("panes").prepend(figure);
    return canvas;
  }
}
