// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
//
// Tubes of yarns with levels of detail, made in the page from packed control points.
//
// The server sends the control points of yarns in blocks (render/yarn_blocks.py) as properties of a mesh of the scene,
// the carrier. This script makes the triangles. Each block has the detail that its distance from the camera of this
// page needs, so that no message is sent when a camera moves. Blocks are made one after the other, the nearest first,
// in short slices of time, and keep their earlier shape until the new one is complete.
(function () {
  "use strict";
  if (window.stitchmeshYarns) return;

  const SLICE = 14; // milliseconds of work between two frames
  const EVERY = 80; // milliseconds between two looks at the cameras and the carriers
  const FIRST = 500000; // triangles of a scene that moves, before the time of its frames is known
  const RESTS = 600; // milliseconds without motion after which a scene gets all its detail
  const { build } = window.stitchmeshShapes, { eye, choose, adapt, levelsOf } = window.stitchmeshLevels;

  const sets = new Map(); // by the name of the carrier
  const parse = (props) => ({
    points: props.yarn_points, low: props.yarn_low, step: props.yarn_step, runs: props.yarn_runs,
    blocks: props.yarn_blocks, radius: props.yarn_radius, index: props.yarn_index, palette: props.yarn_palette,
    copies: props.yarn_copies, levels: props.yarn_levels, budget: props.yarn_budget,
  });

  function materialOf(carrier) {
    const material = carrier.material.clone();
    material.vertexColors = true;
    material.side = 0;
    material.flatShading = false;
    material.color.setRGB(1, 1, 1);
    material.roughness = 0.9;
    material.metalness = 0.0;
    return material;
  }

  // ---- the parts of the scene ---------------------------------------------------------------------------------------

  function show(set, part, geometry) {
    const { carrier } = set, isLine = set.levels[part.wanted].sides === 0;
    if (!part.object) {
      part.object = new carrier.constructor(geometry, set.material);
      part.object.position.set(part.copy[0], part.copy[1], part.copy[2]);
      part.object.raycast = () => {};
      set.group.add(part.object);
    }
    // One class of objects draws triangles and lines: the renderer reads these flags.
    part.object.isMesh = !isLine;
    part.object.isLine = part.object.isLineSegments = isLine;
    part.object.geometry = geometry;
    part.object.visible = true;
    part.level = part.wanted;
    part.made = set.version;
    part.lit = isLine ? part.view : null;
  }

  function discard(set) {
    for (const part of set.parts) if (part.object) set.group.remove(part.object);
    for (const geometry of set.shapes.values()) geometry.value.dispose();
    if (set.material) set.material.dispose();
    set.parts = [];
    set.shapes.clear();
  }

  // Geometries by block and level; those that no part shows are kept while they are few.
  function work(set, deadline) {
    const waiting = set.parts.filter((part) => part.wanted !== part.level || part.made !== set.version);
    if (!waiting.length) return false;
    // Parts that are not there yet come first, then the nearest.
    waiting.sort((a, b) => (a.level < 0 ? 0 : 1) - (b.level < 0 ? 0 : 1) || a.distance - b.distance);
    for (const part of waiting) {
      const key = part.block * 16 + part.wanted;
      let shape = set.shapes.get(key);
      if (!shape || shape.version !== set.version || part.made < 0) {
        const level = set.levels[part.wanted], before = shape && shape.value;
        shape = { value: build(set.carrier, set.data, part.block, level, before, part.view), version: set.version };
        set.shapes.delete(key); // the newest is last
        set.shapes.set(key, shape);
      }
      show(set, part, shape.value);
      if (performance.now() > deadline) break;
    }
    forget(set);
    window.__viserMutable.requestRender();
    return true;
  }

  function forget(set) {
    const most = 2 * (set.data.blocks.length - 1);
    if (set.shapes.size <= most) return;
    const shown = new Set(set.parts.map((part) => part.block * 16 + part.level));
    for (const [key, shape] of set.shapes) {
      if (set.shapes.size <= most) break;
      if (!shown.has(key)) { shape.value.dispose(); set.shapes.delete(key); }
    }
  }

  // ---- carriers -----------------------------------------------------------------------------------------------------

  const linear = new Float32Array(256);
  for (let i = 0; i < 256; i++) {
    const c = i / 255;
    linear[i] = c <= 0.04045 ? c / 12.92 : Math.pow((c + 0.055) / 1.055, 2.4);
  }

  function linearTable(palette) {
    return Uint8Array.from(palette, (value) => Math.round(255 * linear[value]));
  }

  function meshBelow(group) {
    return group.children.find((child) => child.isMesh && child.geometry && child.geometry.attributes.position);
  }

  // The properties arrive one after the other, and may belong to two drawings for a moment.
  function isWhole(data) {
    if (!data.points || !data.blocks || !data.index || !data.runs || !data.low || !data.copies) return false;
    return data.index.length * 3 === data.points.length && data.runs[data.runs.length - 1] === data.index.length &&
      data.low.length === 3 * (data.blocks.length - 1);
  }

  function begin(name, group, data) {
    const carrier = meshBelow(group);
    if (!carrier || !carrier.geometry.boundingSphere) return undefined;
    const set = { group, carrier, material: materialOf(carrier), shapes: new Map(), parts: [], version: 0 };
    set.levels = levelsOf(data.levels);
    set.most = data.budget;
    set.moving = Math.min(data.budget, FIRST);
    for (let copy = 0; copy < data.copies.length; copy += 3) {
      for (let block = 0; block + 1 < data.blocks.length; block++) {
        set.parts.push({ block, copy: Array.from(data.copies.slice(copy, copy + 3)), level: -1, wanted: 0, made: 0 });
      }
    }
    sets.set(name, set);
    return set;
  }

  function moveCopies(set, copies) {
    const blocks = set.data.blocks.length - 1;
    set.parts.forEach((part, i) => {
      const copy = 3 * Math.floor(i / blocks);
      part.copy = Array.from(copies.slice(copy, copy + 3));
      if (part.object) part.object.position.set(...part.copy);
    });
    window.__viserMutable.requestRender();
  }

  function receive(name, props, group) {
    let set = sets.get(name);
    const data = parse(props);
    if (!isWhole(data)) return;
    if (set && (set.group !== group || set.data.blocks !== data.blocks || set.data.levels !== data.levels ||
                set.data.copies.length !== data.copies.length)) {
      discard(set);
      set = undefined;
    }
    set = set || begin(name, group, data);
    if (!set) return;
    const old = set.data;
    if (old && old.copies !== data.copies) moveCopies(set, (old.copies = data.copies));
    if (!old || old.points !== data.points || old.index !== data.index || old.palette !== data.palette) {
      data.table = old && old.palette === data.palette ? old.table : linearTable(data.palette);
      if (old) set.changed = performance.now();
      set.data = data;
      set.version++;
    }
  }

  function lookAtCarriers(viewer, state) {
    for (const name of Object.keys(state)) {
      const props = state[name] && state[name].message && state[name].message.props;
      const group = viewer.nodeRefFromName[name];
      if (props && props.yarn_points !== undefined && group) receive(name, props, group);
    }
    for (const [name, set] of sets) {
      if (viewer.nodeRefFromName[name] === set.group && state[name]) continue;
      discard(set);
      sets.delete(name);
    }
  }

  let pose = "", movedAt = 0;
  function update(where) {
    const now = performance.now();
    const present = where.at.concat(where.forward, where.pixels).map((value) => value.toFixed(4)).join();
    if (present !== pose) { pose = present; movedAt = now; }
    let busy = false, moves = false;
    for (const set of sets.values()) {
      const stands = now - movedAt >= RESTS;
      const budget = now - Math.max(movedAt, set.changed || 0) < RESTS ? set.moving : set.most;
      moves = moves || budget === set.moving;
      const seen = `${pose} ${budget} ${set.version} ${stands}`;
      if (seen !== set.seen) choose(set, where, budget, stands);
      set.seen = seen;
      const works = work(set, now + SLICE);
      // A frame is shown as a whole before the scene begins to rest.
      if (works && budget < set.most) set.changed = now;
      busy = works || busy;
    }
    if (moves) adapt(sets, now);
    return busy;
  }

  function tick() {
    const viewer = window.__viserMutable, tree = window.__viserSceneTree;
    let busy = false;
    if (viewer && tree && viewer.scene) {
      lookAtCarriers(viewer, tree.getState());
      const where = sets.size ? eye() : null;
      if (where) busy = update(where);
    }
    window.setTimeout(tick, busy ? 0 : EVERY);
  }

  window.stitchmeshYarns = {
    sets,
    // For the page and for tests: what each carrier shows.
    report() {
      const found = {};
      for (const [name, set] of sets) {
        const levels = set.levels.map(() => 0);
        let waiting = 0;
        for (const part of set.parts) {
          if (part.level >= 0) levels[part.level]++;
          if (part.level !== part.wanted || part.made !== set.version) waiting++;
        }
        found[name] = { parts: set.parts.length, levels, waiting, triangles: set.triangles, version: set.version };
      }
      return found;
    },
  };
  tick();
})();
