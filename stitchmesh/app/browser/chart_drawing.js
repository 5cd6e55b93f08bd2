// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// Draws a chart on its canvas: squares, symbols, copies, frames and margins; (across, down) is how far it is scrolled.
(() => {
  if (window.StitchmeshChartDrawing) return;
  const COVERED = 65535;
  const DOT = 0.1, RING = 0.2; // radius, in squares
  const COPIES = 130; // height of a small chart with the pale copies that show how it repeats, in pixels
  const LONGEST = 400; // height of the canvas at most, in pixels
  const NEAR = 8; // size of a square from which symbols are drawn, in pixels; below it they are shades
  const SHADE = 0.35;
  const clamp = (value, least, most) => Math.max(least, Math.min(most, value));
  const partsOf = (colour) => [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
  const inkOn = (colour) => {
    const [red, green, blue] = partsOf(colour);
    return 0.299 * red + 0.587 * green + 0.114 * blue > 140 ? "#1b1f24" : "#ffffff";
  };

  window.StitchmeshChartDrawing = class {
    // Makes what depends on the chart as a whole.
    prepare() {
      const { base } = this;
      this.inks = base.colours.map(inkOn);
      this.shades = base.symbols.map(([, marks]) => (marks.length && !base.warps.length ? SHADE : 0));
      this.near = this.newImage();
      this.far = this.newImage();
    }

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
      this.height = clamp(rows * this.cell, COPIES, LONGEST - this.top); // copies stand below a small chart
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
      const width = Math.min(this.width, columns * this.cell), height = Math.min(this.height, rows * this.cell);
      context.rect(this.left, this.top, width + 1, height + 1);
      context.clip();
      context.translate(this.left - this.across, this.top - this.down);
      this.drawSquares(context, seen);
      context.restore();
      this.drawCopies(context, ratio);
      context.save();
      context.translate(this.left - this.across, this.top - this.down);
      context.beginPath();
      context.rect(this.across - 2, this.down - 2, this.width + 3, this.height + 3);
      context.clip();
      this.drawFrames(context);
      context.restore();
    }

    // Pale copies beside and below a chart that is seen as a whole.
    drawCopies(context, ratio) {
      const { rows, columns, left, right } = this.base;
      const width = columns * this.cell, height = rows * this.cell;
      if (left || right || this.across || this.down || width > this.width || height > this.height) return;
      const source = [this.left, this.top, width, height].map((each) => each * ratio);
      context.save();
      context.beginPath();
      context.rect(this.left, this.top, this.width, this.height);
      context.clip();
      context.globalAlpha = 0.35;
      for (let y = 0; y < this.height; y += height) {
        for (let x = 0; x < this.width; x += width) {
          if (x || y) context.drawImage(this.canvas, ...source, this.left + x + 1, this.top + y + 1, width, height);
        }
      }
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
        const moved = [row + rowsBy, column + columnsBy, rowEnd + rowsBy, columnEnd + columnsBy];
        this.outline(context, moved, "#d97706", []);
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
        const start = Math.max(this.left - this.across + x * cell, this.left);
        context.fillRect(start, this.top - 10, Math.max(cell - 1, 1), 8);
      }
    }
  };
})();
