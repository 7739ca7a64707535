// The controls of a page with a slider of time: where in the run its pictures are.

class Player {
  static wholeRun = 12;  // seconds that a run takes at speed 1

  /// @param link the axis of time @param stops times that the arrow keys go to @param events Events @param showAll ends all zooms
  constructor(link, stops, events, showAll) {
    Object.assign(this, { link, stops, events, showAll, playing: null });
    [this.begin, this.end] = [stops[0], stops[stops.length - 1]];
    this.slider = element("input", { type: "range", min: this.begin, max: this.end, step: "any", value: this.begin, ariaLabel: "Time" });
    this.playButton = iconButton("play", "Play (space)", () => this.toggle());
    this.playButton.classList.add("play");
    this.speed = element("select", { ariaLabel: "Speed", title: "Speed" }, ...[0.1, 0.25, 0.5, 1, 2, 4].map((speed) =>
      element("option", { value: speed, textContent: `${readable(speed)}×`, selected: speed === 1 })));
    this.clock = element("output", { className: "clock" });
    this.detail = element("p", { className: "detail", ariaLive: "polite" });
    this.strip = svgElement("svg", { class: "strip", viewBox: "0 0 1000 12", preserveAspectRatio: "none", "aria-hidden": "true" });
    const hasEvents = events.list.length > 0;
    this.node = element("section", { className: "player live", ariaLabel: "Time of the pictures" },
      element("div", { className: "controls" },
        ...(hasEvents ? [iconButton("previous", "Previous contact change (P)", () => this.jump(events.previous(this.time)))] : []),
        this.playButton,
        ...(hasEvents ? [iconButton("next", "Next contact change (N)", () => this.jump(events.next(this.time)))] : []),
        this.speed, this.clock, element("span", { className: "space" }), ...viewButtons([link], showAll)),
      element("div", { className: "track" }, ...(hasEvents ? [this.strip] : []), this.slider), ...(hasEvents ? [this.detail] : []));
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value)));
    this.slider.addEventListener("keydown", (event) => this.key(event));
    this.strip.addEventListener("click", (event) => this.clickedStrip(event));
    link.onPlace.add(() => this.show());
    link.onRange.add(() => this.drawStrip());
    events.onChosen.add(() => this.drawStrip());
    this.drawStrip();
    this.go(this.begin);
  }

  get time() { return this.link.rest; }

  go(time) {
    this.events.choose(null);
    this.stand(time);
  }
  stand(time) {
    this.link.stand(Math.min(this.end, Math.max(this.begin, time)));
    const [from, to] = this.link.range ?? [this.begin, this.end];
    if (this.time < from || this.time > to) this.link.pan((this.time - (from + to) / 2) / (to - from));
  }
  /// To a contact change.
  jump(event) {
    if (!event) return;
    this.stop();
    this.events.choose(event);
    this.stand(event.time);
  }
  step(count) {
    const { stops } = this;
    const [below, part] = Field.locate(stops, this.time), at = part >= 1 ? below + 1 : below;
    const exact = part <= 0 || part >= 1;
    this.go(stops[Math.min(stops.length - 1, Math.max(0, count < 0 && !exact ? at + count + 1 : at + count))]);
  }

  show() {
    this.slider.value = this.time;
    const pointed = this.link.pointed;
    this.clock.textContent = `t = ${withUnit(pointed ?? this.time, "time", 6)}`;
    this.clock.classList.toggle("pointed", pointed !== null);
    this.slider.setAttribute("aria-valuetext", `t = ${withUnit(this.time, "time", 6)}`);
    const { chosen } = this.events;
    this.detail.textContent = chosen ? Events.words(chosen) : "";
  }

  toggle() { this.playing === null ? this.play() : this.stop(); }
  play() {
    if (this.time >= this.end) this.go(this.begin);
    let last = performance.now();
    const frame = (now) => {
      const seconds = Math.max(0, now - last) / 1000;
      last = now;
      this.go(this.time + (seconds * Number(this.speed.value) * (this.end - this.begin)) / Player.wholeRun);
      if (this.time >= this.end) this.stop();
      else this.playing = requestAnimationFrame(frame);
    };
    this.playing = requestAnimationFrame(frame);
    this.showPlaying("pause", "Pause (space)");
  }
  stop() {
    if (this.playing !== null) cancelAnimationFrame(this.playing);
    this.playing = null;
    this.showPlaying("play", "Play (space)");
  }
  showPlaying(name, label) {
    this.playButton.replaceChildren(icon(name));
    Object.assign(this.playButton, { ariaLabel: label, title: label });
  }

  /// Keys of the slider and of the pictures over time.
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const action = {
      ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1), ArrowUp: () => this.step(1), ArrowDown: () => this.step(-1),
      PageUp: () => this.step(10), PageDown: () => this.step(-10), Home: () => this.go(this.begin), End: () => this.go(this.end),
      " ": () => this.toggle(), n: () => this.jump(this.events.next(this.time)), p: () => this.jump(this.events.previous(this.time)),
      "+": () => this.link.zoom(0.5, this.time), "-": () => this.link.zoom(2, this.time), 0: this.showAll,
    }[event.key];
    if (!action) return;
    event.preventDefault();
    if (event.key !== " " && event.key !== "+" && event.key !== "-" && event.key !== "0") this.stop();
    action();
  }

  clickedStrip(event) {
    const { left, width } = this.strip.getBoundingClientRect(), scale = (this.end - this.begin) / width;
    const time = this.begin + (event.clientX - left) * scale, mark = this.events.nearest(time, 6 * scale);
    if (mark) this.jump(mark);
    else this.go(time);
  }

  /// Marks of all contact changes above the slider, and the part of time that is in view.
  drawStrip() {
    const at = (time) => (((time - this.begin) / (this.end - this.begin)) * 1000).toFixed(2), { list, chosen } = this.events;
    const marks = (events) => events.map(({ time, closes }) => `M${at(time)} ${closes ? 0 : 6}v${closes ? 12 : 6}`).join("");
    const { range } = this.link, view = range ? [svgElement("path", { class: "view", d: `M${at(range[0])} 0H${at(range[1])}V12H${at(range[0])}z` })] : [];
    this.strip.replaceChildren(...view, ...["left", "right", "span"].map((side) =>
      svgElement("path", { class: side, d: marks(list.filter((event) => Events.side(event) === side)) })),
      svgElement("path", { class: "chosen", d: marks(chosen ? [chosen] : []) }));
  }
}
