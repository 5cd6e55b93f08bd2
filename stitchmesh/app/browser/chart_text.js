// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// The text beside a chart: line numbers, the line at fault, and what the user types, which is sent at each pause.
(() => {
  if (window.StitchmeshChartText) return;
  const { send, lastRead } = window.stitchmeshChartMessages;
  const TYPING_MS = 250; // length of a pause
  const SHORTEST = 104, LONGEST = 400; // height, in pixels

  window.StitchmeshChartText = class {
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
      const behind = this.timer || lastRead(words) < this.sent;
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
      this.root.style.setProperty("--sm-height", `${Math.max(SHORTEST, Math.min(16 * count + 24, LONGEST))}px`);
      const numbers = Array.from({ length: count }, (_, place) => place + 1);
      const fault = document.createElement("b");
      fault.textContent = `▶${this.faultLine}`;
      const lines = numbers.map((each) => each === this.faultLine ? fault : String(each));
      this.lines.replaceChildren(...lines.flatMap((line, place) => place ? ["\n", line] : [line]));
      this.lines.scrollTop = this.area.scrollTop;
    }
  };
})();
