// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// The canvas of the chart editor: paints strokes at once, sends what the user does, and takes what the server answers.
//
// The server describes a chart in hidden elements: the whole chart ("base"), the squares that differ from it
// ("changes") and the text ("words"). Each answer confirms the last message that it knows, so that strokes which are
// still on their way stay on the canvas.
(() => {
  if (window.stitchmeshCharts) return;
  const { send, lastRead } = window.stitchmeshChartMessages;
  const COVERED = 65535;
  const FLUSH_MS = 40; // a stroke is sent in parts at this interval
  const charts = {};
  window.stitchmeshCharts = charts;

  const shorts = (text) => new Uint16Array(Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0)).buffer);
  const clamp = (value, least, most) => Math.max(least, Math.min(most, value));

  class Chart extends window.StitchmeshChartDrawing {
    constructor() {
      super();
      Object.assign(this, {
        base: null, waiting: null, changed: [], pending: [], stroke: null, drag: null, cursor: [0, 0], anchor: null,
        selection: null, tool: "Paint", word: null, yarn: null, faultRow: null, cell: 0, across: 0, down: 0,
      });
    }

    attach(root) {
      this.root = root;
      this.canvas = root.querySelector("canvas");
      this.status = root.querySelector("[role=status]");
      const canvas = this.canvas;
      canvas.addEventListener("pointerdown", (event) => this.press(event));
      canvas.addEventListener("pointermove", (event) => this.move(event));
      for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.release(event));
      canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
      canvas.addEventListener("keydown", (event) => this.key(event));
      canvas.addEventListener("contextmenu", (event) => event.preventDefault());
      canvas.addEventListener("focus", () => this.draw());
      canvas.addEventListener("blur", () => this.draw());
      new ResizeObserver(() => this.draw()).observe(root);
    }

    // The state that the server sends.

    load(base) {
      const old = this.base;
      this.base = base;
      this.baseSquares = shorts(base.squares);
      this.baseFills = shorts(base.fills);
      this.squares = this.baseSquares.slice();
      this.fills = this.baseFills.slice();
      this.changed = [];
      this.prepare();
      if (!old || old.rows !== base.rows || old.columns !== base.columns) {
        this.cell = 0;
        this.cursor = [0, 0];
        this.anchor = null;
        if (this.status) this.status.textContent = "";
      }
      this.repaint();
      if (this.waiting) this.update(this.waiting);
      this.draw();
    }

    update(changes) {
      if (!this.base || changes.version !== this.base.version) {
        this.waiting = changes;
        return;
      }
      this.waiting = null;
      const touched = new Set();
      for (const index of this.changed) {
        this.squares[index] = this.baseSquares[index];
        this.fills[index] = this.baseFills[index];
        touched.add(index);
      }
      this.changed = [];
      for (let place = 0; place < changes.squares.length; place += 3) {
        const index = changes.squares[place];
        this.squares[index] = changes.squares[place + 1];
        this.fills[index] = changes.squares[place + 2];
        this.changed.push(index);
        touched.add(index);
      }
      const read = lastRead(changes);
      this.pending = this.pending.filter((part) => part.number > read);
      for (const part of [...this.pending, ...(this.stroke ? [this.stroke] : [])]) {
        for (const [row, column] of part.places) this.put(row, column, part, touched);
      }
      touched.forEach((index) => this.pixel(index));
      this.tool = changes.tool;
      this.word = changes.word;
      this.yarn = changes.yarn;
      this.faultRow = changes.fault_row;
      if (this.stroke && this.stroke.places.length) this.flushSoon();
      if (!this.drag) this.selection = changes.selection;
      this.draw();
    }

    // Painting.

    put(row, column, brush, touched) {
      const { rows, columns, words, wefts, warps } = this.base;
      if (row < 0 || column < 0 || row >= rows || column >= columns) return;
      const index = row * columns + column;
      if (brush.word !== null) {
        const number = words.indexOf(brush.word);
        if (number < 0) return;
        const width = this.base.symbols[number][0];
        if (column + width > columns) return;
        this.squares[index] = number;
        for (let step = 1; step < width; step++) this.squares[index + step] = COVERED;
        for (let step = 0; step < width; step++) {
          if (warps.length) this.fills[index] = brush.word === "1" ? wefts[row][0] : warps[column][0];
          else if (brush.yarn !== null) this.fills[index + step] = brush.yarn;
          touched.add(index + step);
          this.changed.push(index + step);
        }
      } else if (brush.yarn !== null) {
        this.fills[index] = brush.yarn;
        touched.add(index);
        this.changed.push(index);
      }
    }

    paintTo(row, column) {
      const stroke = this.stroke;
      const [fromRow, fromColumn] = stroke.last || [row, column];
      const steps = Math.max(Math.abs(row - fromRow), Math.abs(column - fromColumn), 1);
      const touched = new Set();
      const number = stroke.word === null ? -1 : this.base.words.indexOf(stroke.word);
      const width = number < 0 ? 1 : this.base.symbols[number][0];
      for (let step = stroke.last ? 1 : 0; step <= steps; step++) {
        const r = Math.round(fromRow + ((row - fromRow) * step) / steps);
        const c = Math.round(fromColumn + ((column - fromColumn) * step) / steps);
        if (r < 0 || c < 0 || r >= this.base.rows || c + width > this.base.columns) continue;
        let free = true;
        for (let part = 0; part < width; part++) free = free && !stroke.taken.has(r * this.base.columns + c + part);
        if (!free) continue;
        for (let part = 0; part < width; part++) stroke.taken.add(r * this.base.columns + c + part);
        stroke.places.push([r, c]);
        this.put(r, c, stroke, touched);
      }
      stroke.last = [row, column];
      touched.forEach((index) => this.pixel(index));
      this.draw();
    }

    beginStroke(row, column) {
      this.stroke = { places: [], taken: new Set(), last: null, sentParts: 0, word: this.word, yarn: this.yarn };
      this.paintTo(row, column);
      this.flush();
    }

    flush() {
      const stroke = this.stroke;
      if (!stroke) return;
      clearTimeout(this.timer);
      this.timer = null;
      if (!stroke.places.length) return;
      const { word, yarn, places } = stroke;
      const number = send(this.root, "stroke", { places, word, yarn, goes_on: stroke.sentParts > 0 });
      this.pending.push({ number, word, yarn, places });
      stroke.sentParts += 1;
      stroke.places = [];
    }

    // A large chart takes the server longer than a part of a stroke takes the user, so one part is sent at a time.
    flushSoon() {
      if (this.pending.length === 0) this.timer = this.timer || setTimeout(() => this.flush(), FLUSH_MS);
    }

    brush() {
      return { word: this.word, yarn: this.yarn };
    }

    // The pointer.

    at(event) {
      const box = this.canvas.getBoundingClientRect();
      const x = event.clientX - box.left, y = event.clientY - box.top;
      const column = Math.floor((x - this.left + this.across) / this.cell);
      const line = Math.floor((y - this.top + this.down) / this.cell);
      const row = this.base.upwards ? this.base.rows - 1 - line : line;
      return { row, column, margin: x < this.left ? "rows" : y < this.top ? "columns" : null, x, y };
    }

    press(event) {
      if (!this.base) return;
      event.stopPropagation();
      event.preventDefault();
      this.canvas.focus({ preventScroll: true });
      this.canvas.setPointerCapture(event.pointerId);
      const place = this.at(event);
      const { rows, columns } = this.base;
      const inside = place.row >= 0 && place.column >= 0 && place.row < rows && place.column < columns;
      if (event.button === 1) {
        this.drag = { kind: "pan", x: event.clientX, y: event.clientY, across: this.across, down: this.down };
      } else if (place.margin) {
        this.pressMargin(place);
      } else if (!inside) {
        return;
      } else if (event.button === 2 || (event.altKey && this.tool !== "Select")) {
        send(this.root, "pick", { row: place.row, column: place.column });
      } else if (event.button === 0) {
        this.cursor = [place.row, place.column];
        this.begin(place, event);
      }
    }

    begin({ row, column }, event) {
      if (this.tool === "Paint") this.beginStroke(row, column);
      else if (this.tool === "Fill") send(this.root, "fill", { row, column, ...this.brush() });
      else if (this.tool === "Box") this.drag = { kind: "box", from: [row, column], to: [row, column] };
      else if (this.selected(row, column)) {
        this.drag = { kind: "shift", from: [row, column], to: [row, column], keep: event.altKey || event.ctrlKey };
      } else {
        this.drag = { kind: "select", from: [row, column], to: [row, column] };
        this.selection = this.boxOf(this.drag);
      }
      this.draw();
    }

    pressMargin({ row, column, margin }) {
      const { rows, columns, warps } = this.base;
      const number = margin === "rows" ? row : column;
      if (number < 0 || number >= (margin === "rows" ? rows : columns)) return;
      const box = margin === "rows" ? [number, 0, number + 1, columns] : [0, number, rows, number + 1];
      if (this.tool === "Select") this.choose(box);
      else if (warps.length) {
        this.drag = { kind: "thread", margin, seen: new Set([number]) };
        send(this.root, "thread", { kind: margin === "rows" ? "wefts" : "warps", thread: number });
      } else send(this.root, "box", { ...this.named(box), ...this.brush() });
    }

    move(event) {
      if (!this.base) return;
      const place = this.at(event);
      if (this.stroke) {
        for (const each of event.getCoalescedEvents ? event.getCoalescedEvents() : [event]) {
          const { row, column } = this.at(each);
          this.paintTo(row, column);
        }
        this.flushSoon();
      } else if (this.drag) this.dragTo(place, event);
      this.tell(place.row, place.column);
    }

    dragTo({ row, column }, event) {
      const drag = this.drag;
      if (drag.kind === "pan") {
        this.across = drag.across + drag.x - event.clientX;
        this.down = drag.down + drag.y - event.clientY;
      } else if (drag.kind === "thread") {
        const number = drag.margin === "rows" ? row : column;
        const count = drag.margin === "rows" ? this.base.rows : this.base.columns;
        if (number >= 0 && number < count && !drag.seen.has(number)) {
          drag.seen.add(number);
          send(this.root, "thread", { kind: drag.margin === "rows" ? "wefts" : "warps", thread: number });
        }
      } else {
        const free = drag.kind === "shift";
        drag.to = free ? [row, column] : [clamp(row, 0, this.base.rows - 1), clamp(column, 0, this.base.columns - 1)];
        if (drag.kind === "select") this.selection = this.boxOf(drag);
      }
      this.draw();
    }

    release(event) {
      const drag = this.drag;
      this.drag = null;
      if (this.stroke) {
        this.flush();
        this.stroke = null;
      }
      if (drag && event.type !== "pointercancel") {
        if (drag.kind === "select") this.choose(this.boxOf(drag));
        else if (drag.kind === "box") send(this.root, "box", { ...this.named(this.boxOf(drag)), ...this.brush() });
        else if (drag.kind === "shift") this.shift(drag.to[0] - drag.from[0], drag.to[1] - drag.from[1], drag.keep);
      }
      this.draw();
    }

    shift(rows, columns, keep) {
      if (rows || columns) send(this.root, "move", { rows, columns, keep: Boolean(keep) });
    }

    choose(box) {
      this.selection = box;
      send(this.root, "select", box ? this.named(box) : {});
      this.draw();
    }

    boxOf({ from, to }) {
      const rows = [from[0], to[0]], columns = [from[1], to[1]];
      return [Math.min(...rows), Math.min(...columns), Math.max(...rows) + 1, Math.max(...columns) + 1];
    }

    named([row, column, row_end, column_end]) {
      return { row, column, row_end, column_end };
    }

    selected(row, column) {
      const box = this.selection;
      return box && row >= box[0] && column >= box[1] && row < box[2] && column < box[3];
    }

    wheel(event) {
      if (!this.base) return;
      if (event.ctrlKey || event.metaKey) {
        event.preventDefault();
        this.zoom(event.deltaY < 0 ? 1.25 : 0.8, event);
        return;
      }
      const before = [this.across, this.down];
      this.across += event.shiftKey ? event.deltaY : event.deltaX;
      this.down += event.shiftKey ? 0 : event.deltaY;
      this.draw();
      if (before[0] !== this.across || before[1] !== this.down) event.preventDefault();
    }

    zoom(factor, event) {
      const box = this.canvas.getBoundingClientRect();
      const x = event ? event.clientX - box.left - this.left : 0, y = event ? event.clientY - box.top - this.top : 0;
      const old = this.cell;
      this.cell = clamp(this.cell * factor, Math.min(1, this.fitting()), 40);
      this.across = ((this.across + x) * this.cell) / old - x;
      this.down = ((this.down + y) * this.cell) / old - y;
      this.draw();
    }

    // The keyboard.

    key(event) {
      if (!this.base || event.key === "Tab") return;
      const held = event.ctrlKey || event.metaKey;
      if (!(held ? this.command(event) : this.plainKey(event))) return;
      event.preventDefault();
      event.stopPropagation();
    }

    command(event) {
      const key = event.key.toLowerCase();
      const name = { z: event.shiftKey ? "redo" : "undo", y: "redo", c: "copy", x: "cut", v: "paste" }[key];
      if (key === "a") this.choose([0, 0, this.base.rows, this.base.columns]);
      else if (name) send(this.root, name, "");
      else return false;
      return true;
    }

    plainKey(event) {
      const up = this.base.upwards ? 1 : -1;
      const step = { ArrowUp: [up, 0], ArrowDown: [-up, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
      const key = event.key.toLowerCase();
      const tool = { p: "Paint", f: "Fill", b: "Box", s: "Select" }[key];
      if (step) this.walk(step, event);
      else if (tool) send(this.root, "tool", tool);
      else if (event.key === " " || event.key === "Enter") this.useAtCursor();
      else if (event.key === "Escape") this.choose(null);
      else if (event.key === "Delete" || event.key === "Backspace") send(this.root, "clear", "");
      else if (event.key === "+" || event.key === "=") this.zoom(1.25);
      else if (event.key === "-") this.zoom(0.8);
      else if (event.key === "0") this.fit();
      else if (event.key === "[") send(this.root, "previous-stitch", "");
      else if (event.key === "]") send(this.root, "next-stitch", "");
      else if (this.base.warps.length && "we".includes(key)) this.dyeAtCursor(key);
      else if (key === "i") send(this.root, "pick", { row: this.cursor[0], column: this.cursor[1] });
      else return false;
      return true;
    }

    walk([rows, columns], event) {
      if (event.altKey) {
        this.shift(rows, columns, false);
        return;
      }
      const { rows: height, columns: width } = this.base;
      const next = [clamp(this.cursor[0] + rows, 0, height - 1), clamp(this.cursor[1] + columns, 0, width - 1)];
      if (event.shiftKey) {
        this.anchor = this.anchor || this.cursor;
        this.choose(this.boxOf({ from: this.anchor, to: next }));
      } else this.anchor = null;
      this.cursor = next;
      this.reveal();
      this.tell(...next);
      this.draw();
    }

    useAtCursor() {
      const [row, column] = this.cursor;
      if (this.tool === "Fill") send(this.root, "fill", { row, column, ...this.brush() });
      else if (this.tool === "Box" && this.selection) {
        send(this.root, "box", { ...this.named(this.selection), ...this.brush() });
      } else if (this.tool === "Select") this.choose([row, column, row + 1, column + 1]);
      else {
        this.beginStroke(row, column);
        this.stroke = null;
      }
    }

    // W dyes the weft under the cursor, and E the warp, which weavers call an end.
    dyeAtCursor(key) {
      const [row, column] = this.cursor;
      send(this.root, "thread", key === "w" ? { kind: "wefts", thread: row } : { kind: "warps", thread: column });
    }

    reveal() {
      const line = this.base.upwards ? this.base.rows - 1 - this.cursor[0] : this.cursor[0];
      const column = this.cursor[1];
      this.across = clamp(this.across, (column + 1) * this.cell - this.width, column * this.cell);
      this.down = clamp(this.down, (line + 1) * this.cell - this.height, line * this.cell);
    }

    tell(row, column) {
      const { rows, columns, words, warps } = this.base;
      if (row < 0 || column < 0 || row >= rows || column >= columns) return;
      let head = row * columns + column;
      while (this.squares[head] === COVERED) head -= 1;
      const word = words[this.squares[head]];
      const what = warps.length ? (word === "1" ? "weft over" : "warp over") : word;
      const yarn = this.base.colours.length > 1 && !warps.length ? `, yarn ${this.fills[row * columns + column]}` : "";
      const names = warps.length ? ["weft", "warp"] : ["row", "column"];
      const text = `${names[0]} ${row + 1}, ${names[1]} ${column + 1}: ${what}${yarn}`;
      if (this.status.textContent !== text) this.status.textContent = text;
    }
  }

  const texts = {};
  const read = (name, take) => {
    for (const element of document.querySelectorAll(`[data-chart-${name}]`)) {
      if (element.chartRead) continue;
      element.chartRead = true;
      take(element.getAttribute(`data-chart-${name}`), JSON.parse(element.dataset.json));
    }
  };
  const bind = (selector, name, made, Kind) => {
    for (const element of document.querySelectorAll(selector)) {
      const id = element.getAttribute(name);
      made[id] = made[id] || new Kind();
      if (made[id].root === element) continue;
      made[id].attach(element);
      if (made[id].draw) made[id].draw();
    }
  };
  const scan = () => {
    bind("[data-chart]", "data-chart", charts, Chart);
    bind("[data-chart-text]", "data-chart-text", texts, window.StitchmeshChartText);
    read("base", (id, values) => charts[id] && charts[id].load(values));
    read("changes", (id, values) => charts[id] && charts[id].update(values));
    read("words", (id, values) => (texts[id] = texts[id] || new window.StitchmeshChartText()).update(values));
    for (const [made, data] of [[charts, "base"], [texts, "words"]]) {
      for (const id of Object.keys(made)) {
        if (made[id].root && made[id].root.isConnected) continue;
        made[id].root = null;
        if (!document.querySelector(`[data-chart-${data}="${id}"]`)) delete made[id]; // the page was left
      }
    }
  };
  const style = document.createElement("style");
  style.textContent = `
    [data-chart] { width: 100%; }
    [data-chart] canvas { display: block; cursor: crosshair; touch-action: none; }
    [data-chart] canvas:focus { outline: 2px solid #1f6fd1; outline-offset: -1px; }
    .sm-status { font: 12px/16px sans-serif; min-height: 16px; }
    .sm-fault { font: 12px/16px sans-serif; padding: 4px 6px; border-left: 4px solid #d9480f; margin: 2px 0;
      background: #fff1e6; color: #5c1d00; }
    .sm-line { fill: none; stroke: currentColor; stroke-width: 1.7; stroke-linecap: round;
      vector-effect: non-scaling-stroke; }
    .sm-under { fill: none; stroke: #fbfaf7; stroke-width: 8; vector-effect: non-scaling-stroke; }
    .sm-strand { fill: none; stroke: currentColor; stroke-width: 3; vector-effect: non-scaling-stroke; }
    .sm-dot { fill: currentColor; }
    .sm-shade { fill: #8b9097; }
    .sm-text { display: flex; font: 12px/16px monospace; border: 1px solid #8b9097; border-radius: 3px;
      overflow: hidden; }
    .sm-text .sm-lines { white-space: pre; text-align: right; padding: 4px 4px 4px 2px; min-width: 2.6em;
      overflow: hidden; background: rgba(128,128,128,.18); height: var(--sm-height, 168px);
      box-sizing: border-box; }
    .sm-text .sm-lines b { background: #d9480f; color: #fff; }
    .sm-text textarea { flex: 1; min-width: 0; font: inherit; border: 0; padding: 4px; margin: 0; white-space: pre;
      resize: none; height: var(--sm-height, 168px); box-sizing: border-box; background: var(--mantine-color-body);
      color: var(--mantine-color-text); }
  `;
  document.head.append(style);
  new MutationObserver(scan).observe(document.body, { childList: true, subtree: true });
  scan();
})();
