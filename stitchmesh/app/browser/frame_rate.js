// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
//
// Frames per second, triangles, and bytes of drawings, in each element of the class "sm-frames" that the page shows.
// While there is such an element, the scene is drawn all the time, because a page that rests draws no frames.
(() => {
  "use strict";
  const EVERY = 500; // milliseconds between two figures
  const seen = new WeakSet(); // arrays that were counted
  let frames = 0, at = 0, bytes = 0, total = 0, running = false;

  const shown = () => Array.from(document.querySelectorAll(".sm-frames")).filter((one) => one.offsetParent !== null);

  const count = () => {
    for (const node of Object.values(window.__viserSceneTree.getState())) {
      const props = node && node.message && node.message.props;
      for (const value of Object.values(props || {})) {
        if (!ArrayBuffer.isView(value) || seen.has(value)) continue;
        seen.add(value);
        bytes += value.byteLength;
      }
    }
  };

  const short = (number) => number >= 1e6 ? `${(number / 1e6).toFixed(1)} M`
    : number >= 1e4 ? `${Math.round(number / 1e3)} k` : String(Math.round(number));

  const write = (elements) => {
    const info = window.__viserTestpoints.rendererInfo.render, now = performance.now();
    const seconds = Math.max((now - at) / 1000, 0.001), rate = (info.frame - frames) / seconds;
    total += bytes;
    const text = `${rate.toFixed(0)} frames/s · ${short(info.triangles)} triangles, ${short(info.lines)} lines · ` +
      `${short(bytes / seconds)}B/s, ${short(total)}B in all`;
    for (const element of elements) element.textContent = text;
    frames = info.frame;
    at = now;
    bytes = 0;
  };

  const draw = () => {
    running = shown().length > 0;
    if (!running) return;
    window.__viserMutable.requestRender();
    requestAnimationFrame(draw);
  };

  setInterval(() => {
    const elements = shown();
    if (!elements.length || !window.__viserTestpoints || !window.__viserSceneTree) return;
    count();
    write(elements);
    if (!running) draw();
  }, EVERY);
})();
