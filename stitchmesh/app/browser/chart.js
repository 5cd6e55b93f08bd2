// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// The canvas and the text of the chart editor: draws charts, paints strokes at once, and sends what the user does.
//
// The server describes a chart in hidden elements: the whole chart ("base"), the squares that differ from it
// ("changes") and the text ("words"). Each answer confirms the last message that it knows, so that strokes which are
// still on their way stay on the canvas.
(() => {
  if (window.stitchmeshCharts) return;
  const COVERED = 65535;
  const DOT = 0.1, RING = 0.2;
  const LONGEST = 400; // height of the canvas at most, in pixels
  const NEAR = 8; // size of a square from which symbols are drawn, in pixels; below it they are shades
  const SHADE = 0.35;
  const FLUSH_MS = 40; // a stroke is sent in parts at this interval
  const TYPING_MS = 250; // a text is sent when the user pauses
  const browser = Math.random().toString(36).slice(2, 10);
  const charts = {};
  let sent = 0;
  window.stitchmeshCharts = charts;

  const shorts = (text) => new Uint16Array(Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0)).buffer);
  const clamp = (value, least, most) => Math.max(least, Math.min(most, value));
  const partsOf = (colour) => [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
  const inkOn = (colour) => {
    const [red, green, blue] = partsOf(colour);
    return 0.299 * red + 0.587 * green + 0.114 * blue > 140 ? "#1b1f24" : "#ffffff";
  };

  const send = (element, action, values) => {
    const piece = element && element.closest("[data-stitchmesh]"); // none after the page was left
    if (!piece || !window.stitchmesh) return 0;
    sent += 1;
    const value = typeof values === "string" ? values : JSON.stringify({ ...values, browser, number: sent });
    window.stitchmesh.send(piece.dataset.stitchmesh, { action, value });
    return sent;
  };

  class Chart {
    constructor() {
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
      this.inks = base.colours.map(inkOn);
      this.changed = [];
      this.shades = base.symbols.map(([, marks]) => (marks.length && !base.warps.length ? SHADE : 0));
      this.near = this.newImage();
      this.far = this.newImage();
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
      const read = changes.read[browser] || 0;
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
      const inside = place.row >= 0 && place.column >= 0 && place.row < this.base.rows && place.column < this.base.columns;
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
      const name = { z: event.shiftKey ? "redo" : "undo", y: "redo", c: "copy", x: "cut", v: "paste" }[event.key.toLowerCase()];
      if (event.key.toLowerCase() === "a") this.choose([0, 0, this.base.rows, this.base.columns]);
      else if (name) send(this.root, name, "");
      else return false;
      return true;
    }

    plainKey(event) {
      const up = this.base.upwards ? 1 : -1;
      const step = { ArrowUp: [up, 0], ArrowDown: [-up, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
      const tool = { p: "Paint", f: "Fill", b: "Box", s: "Select" }[event.key.toLowerCase()];
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
      else if (this.base.warps.length && "we".includes(event.key.toLowerCase())) this.dyeAtCursor(event.key.toLowerCase());
      else if (event.key.toLowerCase() === "i") send(this.root, "pick", { row: this.cursor[0], column: this.cursor[1] });
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
      else if (this.tool === "Box" && this.selection) send(this.root, "box", { ...this.named(this.selection), ...this.brush() });
      else if (this.tool === "Select") this.choose([row, column, row + 1, column + 1]);
      else {
        this.beginStroke(row, column);
        this.stroke = null;
      }
    }

    // W dyes the weft under the cursor, and E the warp, which weavers call an end.
    dyeAtCursor(key) {
      send(this.root, "thread", key === "w" ? { kind: "wefts", thread: this.cursor[0] } : { kind: "warps", thread: this.cursor[1] });
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

    // Drawing.

    newImage() {
      const image = document.createElement("canvas");
      image.width = this.base.columns;
      image.height = this.base.rows;
      return image;
    }

    // The colour of a square, and its mixture with ink that stands for the symbol where squares are small.
    coloursOf(index) {
      const number = this.fills[index] < this.base.colours.length ? this.fills[index] : 0;
      const paper = this.papers[number];
      const shade = this.squares[index] === COVERED ? SHADE : this.shades[this.squares[index]] || 0;
      const ink = this.inks[number] === "#ffffff" ? 255 : 27;
      return [paper, shade ? paper.map((part) => Math.round(part + (ink - part) * shade)) : paper];
    }

    repaint() {
      const { rows, columns, colours, upwards } = this.base;
      this.papers = colours.map(partsOf);
      const contexts = [this.near, this.far].map((image) => image.getContext("2d"));
      const pixels = contexts.map((context) => context.createImageData(columns, rows));
      for (let row = 0, index = 0; row < rows; row++) {
        let place = 4 * columns * (upwards ? rows - 1 - row : row);
        for (let column = 0; column < columns; column++, index++, place += 4) {
          const both = this.coloursOf(index);
          for (let which = 0; which < 2; which++) {
            pixels[which].data.set(both[which], place);
            pixels[which].data[place + 3] = 255;
          }
        }
      }
      contexts.forEach((context, which) => context.putImageData(pixels[which], 0, 0));
    }

    pixel(index) {
      const { rows, columns, upwards } = this.base;
      const row = Math.floor(index / columns);
      this.coloursOf(index).forEach((colour, which) => {
        const context = (which ? this.far : this.near).getContext("2d");
        context.fillStyle = `rgb(${colour.join(",")})`;
        context.fillRect(index % columns, upwards ? rows - 1 - row : row, 1, 1);
      });
    }

    fitting() {
      const { rows, columns } = this.base;
      return Math.min((this.root.clientWidth - this.left - 2) / columns, (LONGEST - this.top) / rows);
    }

    fit() {
      this.cell = clamp(this.fitting(), 0.5, 26);
      this.across = this.down = 0;
      this.draw();
    }

    draw() {
      if (!this.base || !this.root || this.frame) return;
      this.frame = requestAnimationFrame(() => {
        this.frame = null;
        this.drawNow();
      });
    }

    layOut() {
      const { rows, columns, warps } = this.base;
      this.left = 26 + (warps.length ? 10 : 0);
      this.top = 15 + (warps.length ? 10 : 0);
      if (!this.cell) this.cell = clamp(this.fitting(), 7, 26);
      this.width = this.root.clientWidth - this.left - 1;
      this.height = clamp(rows * this.cell, 60, LONGEST - this.top);
      this.across = clamp(this.across, 0, Math.max(columns * this.cell - this.width, 0));
      this.down = clamp(this.down, 0, Math.max(rows * this.cell - this.height, 0));
      const ratio = window.devicePixelRatio || 1;
      const size = [Math.round(this.root.clientWidth * ratio), Math.round((this.top + this.height + 1) * ratio)];
      if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) {
        [this.canvas.width, this.canvas.height] = size;
        this.canvas.style.width = `${size[0] / ratio}px`;
        this.canvas.style.height = `${size[1] / ratio}px`;
      }
      return ratio;
    }

    drawNow() {
      if (!this.root || !this.root.clientWidth || !this.root.isConnected) return;
      const ratio = this.layOut();
      const context = this.canvas.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      const { rows, columns } = this.base;
      const seen = {
        column: Math.floor(this.across / this.cell), line: Math.floor(this.down / this.cell),
        columnEnd: Math.min(Math.ceil((this.across + this.width) / this.cell), columns),
        lineEnd: Math.min(Math.ceil((this.down + this.height) / this.cell), rows),
      };
      this.drawMargins(context, seen);
      context.save();
      context.beginPath();
      context.rect(this.left, this.top, Math.min(this.width, columns * this.cell) + 1, Math.min(this.height, rows * this.cell) + 1);
      context.clip();
      context.translate(this.left - this.across, this.top - this.down);
      this.drawSquares(context, seen);
      this.drawFrames(context);
      context.restore();
    }

    rowOf(line) {
      return this.base.upwards ? this.base.rows - 1 - line : line;
    }

    drawSquares(context, { column, line, columnEnd, lineEnd }) {
      const { cell } = this;
      context.imageSmoothingEnabled = cell < 1;
      const across = columnEnd - column, down = lineEnd - line;
      const image = cell < NEAR ? this.far : this.near;
      context.drawImage(image, column, line, across, down, column * cell, line * cell, across * cell, down * cell);
      if (cell >= 4) this.drawGrid(context, { column, line, columnEnd, lineEnd });
      if (cell < NEAR) return;
      for (let y = line; y < lineEnd; y++) {
        const row = this.rowOf(y);
        for (let x = Math.max(column - 30, 0); x < columnEnd; x++) this.drawSquare(context, row, x, y);
      }
    }

    drawSquare(context, row, column, line) {
      const index = row * this.base.columns + column;
      const number = this.squares[index];
      if (number === COVERED) return;
      const fill = this.fills[index];
      this.drawSymbol(context, this.base.symbols[number], column * this.cell, line * this.cell, fill);
      if (this.base.warps.length) this.drawLayers(context, row, column, line, number);
    }

    drawGrid(context, { column, line, columnEnd, lineEnd }) {
      const { cell } = this;
      for (const strong of [false, true]) {
        context.beginPath();
        for (let x = column; x <= columnEnd; x++) {
          if ((x % 10 === 0) !== strong) continue;
          context.moveTo(x * cell + 0.5, line * cell);
          context.lineTo(x * cell + 0.5, lineEnd * cell);
        }
        for (let y = line; y <= lineEnd; y++) {
          const number = this.base.upwards ? this.base.rows - y : y;
          if ((number % 10 === 0) !== strong) continue;
          context.moveTo(column * cell, y * cell + 0.5);
          context.lineTo(columnEnd * cell, y * cell + 0.5);
        }
        context.strokeStyle = strong ? "rgba(90,90,90,.9)" : "rgba(110,110,110,.45)";
        context.lineWidth = 1;
        context.stroke();
      }
    }

    drawSymbol(context, [columns, marks], x, y, fill) {
      const { cell } = this;
      const ink = this.inks[fill] || "#1b1f24", paper = this.base.colours[fill] || "#ffffff";
      const trace = (points) => {
        context.beginPath();
        for (let place = 0; place < points.length; place += 2) {
          context.lineTo(x + points[place] * cell, y + cell - points[place + 1] * cell);
        }
      };
      context.lineJoin = "round";
      if (columns > 1) {
        context.save();
        context.beginPath();
        context.rect(x + 1, y + 1, columns * cell - 1, cell - 1);
        context.clip();
        context.fillStyle = paper;
        context.fillRect(x, y, columns * cell, cell);
      }
      for (const [kind, points] of marks) {
        context.lineCap = kind === "strand" || this.base.warps.length ? "butt" : "round";
        if (kind === "shade") {
          context.fillStyle = "rgba(128,128,128,.75)";
          context.fillRect(x + 0.5, y + 0.5, columns * cell, cell);
          continue;
        }
        if (kind === "dot" || kind === "ring") {
          context.beginPath();
          const radius = (kind === "dot" ? DOT : RING) * cell;
          context.arc(x + points[0] * cell, y + cell - points[1] * cell, radius * (kind === "dot" ? 1.2 : 1), 0, 7);
        } else trace(points);
        if (kind === "strand") {
          for (const [colour, width] of [[paper, 0.5], [ink, 0.34], [paper, 0.2]]) {
            context.strokeStyle = colour;
            context.lineWidth = width * cell;
            context.stroke();
          }
        } else if (kind === "dot") {
          context.fillStyle = ink;
          context.fill();
        } else {
          context.strokeStyle = ink;
          context.lineWidth = Math.max(cell * 0.08, 1.1);
          context.stroke();
        }
      }
      if (columns > 1) context.restore();
    }

    drawLayers(context, row, column, line, number) {
      const weft = this.base.wefts[row][1], warp = this.base.warps[column][1];
      if (weft === warp) return;
      const { cell } = this;
      const bound = number === 1 ? weft > warp : warp > weft;
      context.fillStyle = "rgba(128,128,128,.45)";
      if (!bound) context.fillRect(column * cell + 1, line * cell + 1, cell - 1, cell - 1);
      else {
        context.strokeStyle = "#d97706";
        context.lineWidth = Math.max(cell * 0.12, 1.5);
        context.strokeRect(column * cell + cell * 0.2, line * cell + cell * 0.2, cell * 0.6, cell * 0.6);
      }
    }

    frameOf([row, column, rowEnd, columnEnd]) {
      const first = this.base.upwards ? this.base.rows - rowEnd : row;
      return [column * this.cell, first * this.cell, (columnEnd - column) * this.cell, (rowEnd - row) * this.cell];
    }

    drawFrames(context) {
      const { cell, drag } = this;
      const { rows, columns, left, right } = this.base;
      if (left || right) {
        context.fillStyle = "rgba(120,120,120,.4)";
        context.fillRect(0, 0, left * cell, rows * cell);
        context.fillRect((columns - right) * cell, 0, right * cell, rows * cell);
        context.fillStyle = "#1f6fd1";
        for (const limit of [left, columns - right]) context.fillRect(limit * cell - 1, 0, 3, rows * cell);
      }
      if (this.faultRow !== null && this.faultRow < rows) {
        this.outline(context, [this.faultRow, 0, this.faultRow + 1, columns], "#d9480f", [3, 2]);
      }
      if (this.selection) this.outline(context, this.selection, "#1f6fd1", [5, 3]);
      if (drag && drag.kind === "box") this.outline(context, this.boxOf(drag), "#d97706", []);
      if (drag && drag.kind === "shift" && this.selection) {
        const rowsBy = drag.to[0] - drag.from[0], columnsBy = drag.to[1] - drag.from[1];
        const [row, column, rowEnd, columnEnd] = this.selection;
        this.outline(context, [row + rowsBy, column + columnsBy, rowEnd + rowsBy, columnEnd + columnsBy], "#d97706", []);
      }
      if (document.activeElement === this.canvas) {
        const [row, column] = this.cursor;
        this.outline(context, [row, column, row + 1, column + 1], "#d97706", []);
      }
    }

    outline(context, box, colour, dashes) {
      const frame = this.frameOf(box);
      context.lineWidth = 4;
      context.strokeStyle = "rgba(255,255,255,.85)";
      context.strokeRect(...frame);
      context.setLineDash(dashes);
      context.lineWidth = 2;
      context.strokeStyle = colour;
      context.strokeRect(...frame);
      context.setLineDash([]);
    }

    drawMargins(context, { column, line, columnEnd, lineEnd }) {
      const { cell, base } = this;
      context.fillStyle = getComputedStyle(this.canvas).color;
      context.font = "10px sans-serif";
      context.textBaseline = "middle";
      const every = cell >= 12 ? 1 : cell >= 5 ? 5 : cell >= 2 ? 10 : 50;
      const edge = this.left - (base.warps.length ? 13 : 3);
      context.textAlign = "right";
      for (let y = line; y < lineEnd; y++) {
        const number = this.rowOf(y) + 1;
        const middle = this.top - this.down + (y + 0.5) * cell;
        if (number - 1 === this.faultRow) context.fillText("▶", 9, middle);
        else if (number % every === 0 && middle > this.top) context.fillText(String(number), edge, middle);
      }
      context.textAlign = "center";
      const spread = cell >= 18 ? 1 : every === 1 ? 5 : every;
      for (let x = column; x < columnEnd; x++) {
        const middle = this.left - this.across + (x + 0.5) * cell;
        if ((x + 1) % spread === 0 && middle > this.left) context.fillText(String(x + 1), middle, 7);
      }
      if (base.warps.length) this.drawThreads(context, { column, line, columnEnd, lineEnd });
    }

    drawThreads(context, { column, line, columnEnd, lineEnd }) {
      const { cell, base } = this;
      for (let y = line; y < lineEnd; y++) {
        context.fillStyle = base.colours[base.wefts[this.rowOf(y)][0]] || base.colours[0];
        context.fillRect(this.left - 10, Math.max(this.top - this.down + y * cell, this.top), 8, Math.max(cell - 1, 1));
      }
      for (let x = column; x < columnEnd; x++) {
        context.fillStyle = base.colours[base.warps[x][0]] || base.colours[0];
        context.fillRect(Math.max(this.left - this.across + x * cell, this.left), this.top - 10, Math.max(cell - 1, 1), 8);
      }
    }
  }

  class ChartText {
    constructor() {
      Object.assign(this, { words: null, sent: 0, timer: null, faultLine: null });
    }

    attach(root) {
      this.root = root;
      this.area = root.querySelector("textarea");
      this.lines = root.querySelector(".sm-lines");
      this.area.addEventListener("input", () => {
        clearTimeout(this.timer);
        this.timer = setTimeout(() => this.send(), TYPING_MS);
        this.number();
      });
      this.area.addEventListener("blur", () => this.timer && this.send());
      this.area.addEventListener("scroll", () => { this.lines.scrollTop = this.area.scrollTop; });
      this.area.addEventListener("keydown", (event) => event.stopPropagation());
      if (this.words) this.update(this.words);
    }

    send() {
      clearTimeout(this.timer);
      this.timer = null;
      this.sent = send(this.root, "text", { text: this.area.value });
    }

    update(words) {
      this.words = words;
      if (!this.area) return;
      const behind = this.timer || (words.read[browser] || 0) < this.sent;
      if (!behind && this.area.value !== words.text) {
        const caret = this.area.selectionStart;
        this.area.value = words.text;
        if (document.activeElement === this.area) this.area.setSelectionRange(caret, caret);
      }
      this.faultLine = words.fault_line;
      this.number();
    }

    number() {
      const count = this.area.value.split("\n").length;
      const key = `${count} ${this.faultLine}`;
      if (this.key === key) return;
      this.key = key;
      this.root.style.setProperty("--sm-height", `${clamp(16 * count + 24, 104, 400)}px`);
      const numbers = Array.from({ length: count }, (_, place) => place + 1);
      this.lines.innerHTML = numbers.map((each) => each === this.faultLine ? `<b>▶${each}</b>` : each).join("\n");
      this.lines.scrollTop = this.area.scrollTop;
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
    bind("[data-chart-text]", "data-chart-text", texts, ChartText);
    read("base", (id, values) => charts[id] && charts[id].load(values));
    read("changes", (id, values) => charts[id] && charts[id].update(values));
    read("words", (id, values) => (texts[id] = texts[id] || new ChartText()).update(values));
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
    [data-chart] canvas { display: block; cursor: crosshair; touch-action: none; outline-offset: -1px; }
    .sm-status { font: 12px/16px sans-serif; min-height: 16px; }
    .sm-fault { font: 12px/16px sans-serif; padding: 4px 6px; border-left: 4px solid #d9480f; margin: 2px 0;
      background: #fff1e6; color: #5c1d00; }
    .sm-line { fill: none; stroke: currentColor; stroke-width: 1.7; vector-effect: non-scaling-stroke; stroke-linecap: round; }
    .sm-under { fill: none; stroke: #fbfaf7; stroke-width: 8; vector-effect: non-scaling-stroke; }
    .sm-strand { fill: none; stroke: currentColor; stroke-width: 3; vector-effect: non-scaling-stroke; }
    .sm-dot { fill: currentColor; }
    .sm-shade { fill: #8b9097; }
    .sm-text { display: flex; font: 12px/16px monospace; border: 1px solid #8b9097; border-radius: 3px; overflow: hidden; }
    .sm-text .sm-lines { white-space: pre; text-align: right; padding: 4px 4px 4px 2px; min-width: 2.6em; overflow: hidden;
      max-height: 400px; background: rgba(128,128,128,.18); height: var(--sm-height, 168px); box-sizing: border-box; }
    .sm-text .sm-lines b { background: #d9480f; color: #fff; }
    .sm-text textarea { flex: 1; min-width: 0; font: inherit; border: 0; padding: 4px; margin: 0; white-space: pre;
      resize: none; height: var(--sm-height, 168px); box-sizing: border-box; background: var(--mantine-color-body);
      color: var(--mantine-color-text); }
  `;
  document.head.append(style);
  new MutationObserver(scan).observe(document.body, { childList: true, subtree: true });
  scan();
})();
