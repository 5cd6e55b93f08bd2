// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// What a chart in the browser tells the server: each message has the name of this window and a number, and the server's
// answers name the last number that it has read.
(() => {
  if (window.stitchmeshChartMessages) return;
  const browser = Math.random().toString(36).slice(2, 10);
  let sent = 0;

  // Sends an action with its values from the piece of HTML in which an element stands; returns the number.
  const send = (element, action, values) => {
    const piece = element && element.closest("[data-stitchmesh]"); // none after the page was left
    if (!piece || !window.stitchmesh) return 0;
    sent += 1;
    const value = typeof values === "string" ? values : JSON.stringify({ ...values, browser, number: sent });
    window.stitchmesh.send(piece.dataset.stitchmesh, { action, value });
    return sent;
  };

  window.stitchmeshChartMessages = { send, lastRead: (answer) => answer.read[browser] || 0 };
})();
