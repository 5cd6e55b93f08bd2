// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
// What the application adds to viser's page: colours of faces, hints, and actions of HTML elements.
(() => {
  if (window.stitchmesh) return;
  const hooks = () => window.__viserMutable;
  const bytesOf = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const S = {
    inbox: null, // identity of the hidden text through which messages reach the server
    sent: 0,
    hints: {}, // hint of each control, by its identity
    wanted: {}, // colours of each mesh that are not applied yet, by its name
    begun: Math.random().toString(36).slice(2),
  };

  S.send = (target, message) => {
    if (!S.inbox || !hooks()) return;
    S.sent += 1;
    const value = JSON.stringify({ target, number: `${S.begun}-${S.sent}`, ...message });
    hooks().sendMessage({ type: "GuiUpdateMessage", uuid: S.inbox, updates: { value } });
  };

  // Colours: one byte for each triangle or point, and a palette in linear light.
  S.colour = (name, palette, bytes, flat) => {
    S.wanted[name] = { palette: new Uint32Array(bytesOf(palette).buffer), bytes: bytesOf(bytes), flat };
    S.applyColours();
  };

  const meshOf = (name) => {
    const node = hooks() && hooks().nodeRefFromName[name];
    let found = null;
    if (node) node.traverse((part) => {
      if (!found && part.isMesh && part.geometry.attributes.position && part.material.isMeshStandardMaterial) found = part;
    });
    return found;
  };

  const applyTo = (mesh, { palette, bytes, flat }) => {
    const positions = mesh.geometry.attributes.position;
    const corners = flat ? 3 : 1;
    if (positions.count !== bytes.length * corners) return false;
    let colours = mesh.geometry.attributes.color;
    if (!colours || colours.count !== positions.count) {
      colours = positions.clone();
      colours.array = new Uint8Array(positions.count * 4);
      Object.assign(colours, { itemSize: 4, normalized: true, count: positions.count });
      mesh.geometry.setAttribute("color", colours);
    }
    const values = new Uint32Array(colours.array.buffer);
    for (let item = 0, place = 0; item < bytes.length; item++) {
      const value = palette[bytes[item]];
      for (let corner = 0; corner < corners; corner++) values[place++] = value;
    }
    colours.needsUpdate = true;
    if (!mesh.material.vertexColors) {
      mesh.material.vertexColors = true;
      mesh.material.needsUpdate = true;
    }
    return true;
  };

  S.applyColours = () => {
    let applied = false;
    for (const name of Object.keys(S.wanted)) {
      const mesh = meshOf(name);
      if (mesh && applyTo(mesh, S.wanted[name])) {
        delete S.wanted[name];
        applied = true;
      }
    }
    if (applied) hooks().requestRender();
  };
  const everyFrame = () => {
    if (Object.keys(S.wanted).length) S.applyColours();
    requestAnimationFrame(everyFrame);
  };
  requestAnimationFrame(everyFrame);

  // Hints: viser shows them for inputs, but not for buttons.
  S.applyHints = () => {
    for (const [identity, hint] of Object.entries(S.hints)) {
      const element = document.getElementById(identity);
      if (element && element.tagName === "BUTTON" && element.title !== hint) element.title = hint;
    }
  };

  // Focus: a piece of HTML that is shown anew would lose the element on which a user of the keyboard stands.
  let stood = null;
  document.addEventListener("focusin", ({ target }) => {
    const piece = target.closest("[data-stitchmesh]");
    stood = piece && target.dataset.action && target.matches(":focus-visible")
      ? { element: target, piece: piece.dataset.stitchmesh, action: target.dataset.action, value: target.dataset.value }
      : null;
  });
  const keepFocus = () => {
    if (!stood || stood.element.isConnected || document.activeElement !== document.body) return;
    const elements = document.querySelectorAll(`[data-stitchmesh="${stood.piece}"] [data-action="${stood.action}"]`);
    const same = [...elements].find((element) => element.dataset.value === stood.value);
    if (same) same.focus({ preventScroll: true });
  };

  new MutationObserver(() => {
    S.applyHints();
    keepFocus();
  }).observe(document.body, { childList: true, subtree: true });

  // Actions of HTML elements.
  document.addEventListener("click", (event) => {
    const element = event.target.closest && event.target.closest("[data-action]");
    const piece = element && element.closest("[data-stitchmesh]");
    if (!piece || element.disabled) return;
    S.send(piece.dataset.stitchmesh, { action: element.dataset.action, value: element.dataset.value || "" });
  });

  // Plots: viser first draws each plot with the width 0, for which Plotly raises an error.
  const withoutEmptyPlots = (plotly) => {
    const react = plotly.react;
    plotly.react = (node, data, layout, config) =>
      layout && layout.width === 0 ? Promise.resolve(node) : react(node, data, layout, config);
    return plotly;
  };
  if (window.Plotly) withoutEmptyPlots(window.Plotly);
  else {
    let plotly;
    Object.defineProperty(window, "Plotly", {
      configurable: true,
      get: () => plotly,
      set: (value) => { plotly = withoutEmptyPlots(value); },
    });
  }

  window.stitchmesh = S;
})();
