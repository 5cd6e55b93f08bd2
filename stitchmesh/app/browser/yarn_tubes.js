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
  const FEWEST = 150000; // triangles that every computer draws fluently
  const CLOSE = 0.85; // a finer level is left only when the yarn is this much thinner on the screen than its bound

  const sets = new Map(); // by the name of the carrier
  const parse = (props) => ({
    points: props.yarn_points, low: props.yarn_low, step: props.yarn_step, runs: props.yarn_runs,
    blocks: props.yarn_blocks, radius: props.yarn_radius, index: props.yarn_index, palette: props.yarn_palette,
    copies: props.yarn_copies, levels: props.yarn_levels, budget: props.yarn_budget,
  });

  // ---- three.js objects, from the constructors of the carrier -------------------------------------------------------

  function attribute(template, array, itemSize, normalized) {
    const made = template.clone();
    made.array = array;
    made.itemSize = itemSize;
    made.count = array.length / itemSize;
    made.normalized = !!normalized;
    return made;
  }

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

  // ---- curves -------------------------------------------------------------------------------------------------------

  const linear = new Float32Array(256);
  for (let i = 0; i < 256; i++) {
    const c = i / 255;
    linear[i] = c <= 0.04045 ? c / 12.92 : Math.pow((c + 0.055) / 1.055, 2.4);
  }

  // Parameters of the samples of a run of m segments: s for each segment, or one after every `stride` segments.
  function sampleCount(m, level) {
    return level.samples > 0 ? m * level.samples + 1 : Math.ceil(m / level.stride) + 1;
  }

  const control = new Float32Array(3 * 4096);
  const here = new Float64Array(7); // position, unit tangent, parameter to the nearest control point

  function unpack(data, block, first, last) {
    const { points, low, step } = data;
    for (let p = first, j = 0; p < last; p++) {
      for (let k = 0; k < 3; k++, j++) control[j] = low[3 * block + k] + step[3 * block + k] * points[3 * p + k];
    }
  }

  // The point of a cubic B-spline and its unit tangent.
  function evaluate(segment, u) {
    const v = 1 - u, a = (v * v * v) / 6, b = (3 * u * u * u - 6 * u * u + 4) / 6;
    const c = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6, d = (u * u * u) / 6;
    const e = -(v * v) / 2, f = (3 * u * u - 4 * u) / 2, g = (-3 * u * u + 2 * u + 1) / 2, h = (u * u) / 2;
    let length = 0;
    for (let k = 0; k < 3; k++) {
      const i = 3 * segment + k, p = control[i], q = control[i + 3], r = control[i + 6], s = control[i + 9];
      here[k] = a * p + b * q + c * r + d * s;
      const t = e * p + f * q + g * r + h * s;
      here[3 + k] = t;
      length += t * t;
    }
    const scale = length > 0 ? 1 / Math.sqrt(length) : 0;
    for (let k = 3; k < 6; k++) here[k] *= scale;
    if (scale === 0) here[5] = 1;
  }

  function place(sample, m, level) {
    const t = level.samples > 0 ? sample / level.samples : Math.min(sample * level.stride, m);
    const segment = Math.min(Math.floor(t), m - 1);
    evaluate(segment, t - segment);
    return segment + (t - segment < 0.5 ? 1 : 2); // the nearest control point of the run
  }

  // ---- geometry of a block at a level -------------------------------------------------------------------------------

  function sizes(data, block, level) {
    let rings = 0, runs = data.blocks[block + 1] - data.blocks[block];
    for (let run = data.blocks[block]; run < data.blocks[block + 1]; run++) {
      rings += sampleCount(data.runs[run + 1] - data.runs[run] - 3, level);
    }
    if (level.sides === 0) return { vertices: rings, indices: 2 * (rings - runs) };
    return { vertices: rings * level.sides, indices: 6 * (rings - runs) * level.sides + 6 * runs * (level.sides - 2) };
  }

  function build(set, block, level, geometry, view) {
    const { data, carrier } = set, template = carrier.geometry.attributes.position;
    const size = sizes(data, block, level);
    if (!geometry || geometry.attributes.position.array.length !== 3 * size.vertices) {
      if (geometry) geometry.dispose();
      geometry = new carrier.geometry.constructor();
      geometry.setAttribute("position", attribute(template, new Float32Array(3 * size.vertices), 3));
      geometry.setAttribute("normal", attribute(template, new Int8Array(4 * size.vertices), 4, true));
      geometry.setAttribute("color", attribute(template, new Uint8Array(4 * size.vertices), 4, true));
      geometry.setIndex(attribute(template, new Uint32Array(size.indices), 1));
      connect(data, block, level, geometry.index.array);
    }
    const out = geometry.attributes;
    if (level.sides === 0) lines(data, block, level, out, view);
    else tubes(data, block, level, out);
    for (const name of ["position", "normal", "color"]) out[name].needsUpdate = true;
    bound(set, block, geometry);
    return geometry;
  }

  function connect(data, block, level, index) {
    let ring = 0, i = 0;
    const n = level.sides;
    for (let run = data.blocks[block]; run < data.blocks[block + 1]; run++) {
      const count = sampleCount(data.runs[run + 1] - data.runs[run] - 3, level);
      for (let s = 0; s + 1 < count; s++) {
        if (n === 0) { index[i++] = ring + s; index[i++] = ring + s + 1; continue; }
        const a = (ring + s) * n, b = a + n;
        for (let k = 0; k < n; k++) {
          const l = (k + 1) % n;
          index[i++] = a + k; index[i++] = a + l; index[i++] = b + l;
          index[i++] = a + k; index[i++] = b + l; index[i++] = b + k;
        }
      }
      if (n > 0) {
        const first = ring * n, last = (ring + count - 1) * n;
        for (let k = 1; k + 1 < n; k++) {
          index[i++] = first; index[i++] = first + k + 1; index[i++] = first + k;
          index[i++] = last; index[i++] = last + k; index[i++] = last + k + 1;
        }
      }
      ring += count;
    }
  }

  function paint(data, point, out, vertex, count) {
    const c = data.table, i = 3 * data.index[point];
    for (let k = 0, j = 4 * vertex; k < count; k++, j += 4) {
      out[j] = c[i]; out[j + 1] = c[i + 1]; out[j + 2] = c[i + 2]; out[j + 3] = 255;
    }
  }

  function tubes(data, block, level, out) {
    const n = level.sides, cos = [], sin = [];
    for (let k = 0; k < n; k++) { cos.push(Math.cos((2 * Math.PI * k) / n)); sin.push(Math.sin((2 * Math.PI * k) / n)); }
    const position = out.position.array, normal = out.normal.array, colour = out.color.array;
    // On average over its sides, a tube looks as wide as the yarn: the mean width of a polygon is its perimeter over pi.
    const wider = Math.PI / (n * Math.sin(Math.PI / n));
    let vertex = 0;
    for (let run = data.blocks[block]; run < data.blocks[block + 1]; run++) {
      const first = data.runs[run], last = data.runs[run + 1], m = last - first - 3, radius = wider * data.radius[run];
      unpack(data, block, first, last);
      let ux = 0, uy = 0, uz = 0;
      for (let s = 0, count = sampleCount(m, level); s < count; s++) {
        const point = first + place(s, m, level);
        const tx = here[3], ty = here[4], tz = here[5];
        if (s === 0) {
          // Any normal of the tangent begins the frame; the axis of the smallest part of the tangent gives a good one.
          const ax = Math.abs(tx), ay = Math.abs(ty), az = Math.abs(tz);
          if (ax <= ay && ax <= az) { ux = 0; uy = tz; uz = -ty; }
          else if (ay <= az) { ux = -tz; uy = 0; uz = tx; }
          else { ux = ty; uy = -tx; uz = 0; }
        }
        const along = ux * tx + uy * ty + uz * tz;
        ux -= along * tx; uy -= along * ty; uz -= along * tz;
        const size = 1 / (Math.sqrt(ux * ux + uy * uy + uz * uz) || 1);
        ux *= size; uy *= size; uz *= size;
        const vx = ty * uz - tz * uy, vy = tz * ux - tx * uz, vz = tx * uy - ty * ux;
        paint(data, point, colour, vertex, n);
        for (let k = 0; k < n; k++, vertex++) {
          const nx = cos[k] * ux + sin[k] * vx, ny = cos[k] * uy + sin[k] * vy, nz = cos[k] * uz + sin[k] * vz;
          position[3 * vertex] = here[0] + radius * nx;
          position[3 * vertex + 1] = here[1] + radius * ny;
          position[3 * vertex + 2] = here[2] + radius * nz;
          normal[4 * vertex] = 127 * nx; normal[4 * vertex + 1] = 127 * ny; normal[4 * vertex + 2] = 127 * nz;
        }
      }
    }
  }

  // Lines have the light of the side that faces the camera.
  function lines(data, block, level, out, view) {
    const position = out.position.array, normal = out.normal.array, colour = out.color.array;
    let vertex = 0;
    for (let run = data.blocks[block]; run < data.blocks[block + 1]; run++) {
      const first = data.runs[run], last = data.runs[run + 1], m = last - first - 3;
      unpack(data, block, first, last);
      for (let s = 0, count = sampleCount(m, level); s < count; s++, vertex++) {
        const point = first + place(s, m, level);
        paint(data, point, colour, vertex, 1);
        const along = view[0] * here[3] + view[1] * here[4] + view[2] * here[5];
        let nx = view[0] - along * here[3], ny = view[1] - along * here[4], nz = view[2] - along * here[5];
        const size = 127 / (Math.sqrt(nx * nx + ny * ny + nz * nz) || 1);
        normal[4 * vertex] = nx * size; normal[4 * vertex + 1] = ny * size; normal[4 * vertex + 2] = nz * size;
        for (let k = 0; k < 3; k++) position[3 * vertex + k] = here[k];
      }
    }
  }

  function bound(set, block, geometry) {
    const [centre, radius] = sphere(set.data, block);
    if (!geometry.boundingSphere) {
      geometry.boundingSphere = set.carrier.geometry.boundingSphere.clone();
    }
    geometry.boundingSphere.center.set(centre[0], centre[1], centre[2]);
    geometry.boundingSphere.radius = radius;
  }

  function sphere(data, block) {
    const centre = [0, 0, 0];
    let square = 0;
    for (let k = 0; k < 3; k++) {
      const half = (data.step[3 * block + k] * 65535) / 2;
      centre[k] = data.low[3 * block + k] + half;
      square += half * half;
    }
    return [centre, Math.sqrt(square) + data.radius[data.blocks[block]]];
  }

  // ---- levels -------------------------------------------------------------------------------------------------------

  function eye() {
    const viewer = window.__viserMutable, camera = viewer.camera;
    if (!camera || !viewer.canvas) return null;
    const at = camera.matrixWorld.elements, height = viewer.canvas.clientHeight || 1;
    const pixels = height / 2 / Math.tan((camera.fov * Math.PI) / 360); // at a distance of one
    return { at: [at[12], at[13], at[14]], forward: [-at[8], -at[9], -at[10]], pixels };
  }

  function trianglesOf(set, block, level) {
    const level_ = set.levels[level], points = set.data.runs[set.data.blocks[block + 1]] - set.data.runs[set.data.blocks[block]];
    const rings = level_.samples > 0 ? points * level_.samples : points / level_.stride;
    return level_.sides === 0 ? rings : 2 * level_.sides * rings;
  }

  // The camera in the coordinates of the carrier, whose parents may be turned.
  function inside(set, where) {
    const world = set.group.matrixWorld.elements, d = where.at.map((value, k) => value - world[12 + k]);
    const turn = (v) => [0, 1, 2].map((k) => v[0] * world[4 * k] + v[1] * world[4 * k + 1] + v[2] * world[4 * k + 2]);
    return { at: turn(d), forward: turn(where.forward), pixels: where.pixels };
  }

  function choose(set, where) {
    const seen = inside(set, where);
    const wanted = set.parts.map((part) => {
      const [centre, radius] = sphere(set.data, part.block);
      const toward = [0, 1, 2].map((k) => centre[k] + part.copy[k] - seen.at[k]);
      const far = Math.hypot(...toward), distance = Math.max(far - radius, 0.2 * radius);
      // What lies behind the camera needs no detail.
      const ahead = toward[0] * seen.forward[0] + toward[1] * seen.forward[1] + toward[2] * seen.forward[2] > -radius;
      part.distance = ahead ? distance : distance + 1e6;
      part.view = toward.map((value) => -value / (far || 1));
      return ahead ? (set.data.radius[set.data.blocks[part.block]] * seen.pixels) / distance : 0;
    });
    let scale = 1;
    for (let attempt = 0; attempt < 24; attempt++, scale *= 0.8) {
      let total = 0;
      set.parts.forEach((part, i) => {
        let level = set.levels.findIndex((one) => wanted[i] * scale >= one.least);
        if (level < 0) level = set.levels.length - 1;
        // A block that is at a boundary between two levels stays as it is.
        if (part.level >= 0 && part.level < level && wanted[i] * scale >= CLOSE * set.levels[part.level].least) {
          level = part.level;
        }
        part.wanted = level;
        total += trianglesOf(set, part.block, level);
      });
      set.triangles = total;
      if (total <= set.budget) return;
    }
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
  }

  function discard(set) {
    for (const part of set.parts) if (part.object) set.group.remove(part.object);
    for (const geometry of set.shapes.values()) geometry.value.dispose();
    if (set.material) set.material.dispose();
    set.parts = [];
    set.shapes.clear();
  }

  // Geometries by block and level; those that no part shows are kept while they are few.
  function work(set, where, deadline) {
    const waiting = set.parts.filter((part) => part.wanted !== part.level || part.made !== set.version);
    if (!waiting.length) return false;
    // Parts that are not there yet come first, then the nearest.
    waiting.sort((a, b) => (a.level < 0 ? 0 : 1) - (b.level < 0 ? 0 : 1) || a.distance - b.distance);
    for (const part of waiting) {
      const key = part.block * 16 + part.wanted;
      let shape = set.shapes.get(key);
      if (!shape || shape.version !== set.version) {
        const value = build(set, part.block, set.levels[part.wanted], shape && shape.value, part.view);
        shape = { value, version: set.version };
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

  function levelsOf(table) {
    const levels = [];
    for (let i = 0; i + 3 < table.length; i += 4) {
      levels.push({ least: table[i], sides: table[i + 1], samples: table[i + 2], stride: table[i + 3] });
    }
    return levels;
  }

  function linearTable(palette) {
    return Uint8Array.from(palette, (value) => Math.round(255 * linear[value]));
  }

  function meshBelow(group) {
    return group.children.find((child) => child.isMesh && child.geometry && child.geometry.attributes.position);
  }

  function receive(name, props, group) {
    let set = sets.get(name);
    const data = parse(props);
    if (!data.points || !data.blocks || !data.index || data.index.length * 3 !== data.points.length) return;
    if (data.runs[data.runs.length - 1] !== data.index.length || data.low.length !== 3 * (data.blocks.length - 1)) return;
    if (set && (set.group !== group || set.data.blocks !== data.blocks || set.data.levels !== data.levels ||
                set.data.copies.length !== data.copies.length)) {
      discard(set);
      set = undefined;
    }
    if (!set) {
      const carrier = meshBelow(group);
      if (!carrier || !carrier.geometry.boundingSphere) return;
      set = { group, carrier, material: materialOf(carrier), shapes: new Map(), parts: [], version: 0, rate: 1 };
      set.levels = levelsOf(data.levels);
      for (let copy = 0; copy < data.copies.length; copy += 3) {
        for (let block = 0; block + 1 < data.blocks.length; block++) {
          set.parts.push({ block, copy: Array.from(data.copies.slice(copy, copy + 3)), level: -1, wanted: 0, made: 0 });
        }
      }
      sets.set(name, set);
    }
    const old = set.data;
    if (old && old.copies !== data.copies) {
      set.parts.forEach((part, i) => {
        const copy = Math.floor(i / (data.blocks.length - 1));
        part.copy = Array.from(data.copies.slice(3 * copy, 3 * copy + 3));
        if (part.object) part.object.position.set(...part.copy);
      });
      old.copies = data.copies;
      window.__viserMutable.requestRender();
    }
    if (!old || old.points !== data.points || old.index !== data.index || old.palette !== data.palette) {
      data.table = old && old.palette === data.palette ? old.table : linearTable(data.palette);
      set.data = data;
      set.version++;
      set.changed = performance.now();
    }
    set.most = data.budget;
    set.budget = Math.min(set.budget || data.budget, data.budget);
  }

  // Fewer triangles where frames take long; more again where they are quick.
  let frames = 0, seenAt = 0, rate = 0, drawn = 0;
  function adapt(now, moved) {
    const info = window.__viserTestpoints && window.__viserTestpoints.rendererInfo;
    if (!info) return;
    drawn = info.render.triangles;
    const count = info.render.frame - frames, seconds = (now - seenAt) / 1000;
    if (seconds < 0.5) return;
    rate = count / seconds;
    frames = info.render.frame;
    seenAt = now;
    if (!moved) return;
    for (const set of sets.values()) {
      if (rate < 15 && count > 1) set.budget = Math.max(FEWEST, set.budget * 0.7);
      else if (rate > 28) set.budget = Math.min(set.most, set.budget * 1.3);
    }
  }

  let last = "", movedAt = 0, still = true;
  function tick() {
    const viewer = window.__viserMutable, tree = window.__viserSceneTree;
    let delay = EVERY;
    if (viewer && tree && viewer.scene) {
      const state = tree.getState(), where = eye();
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
      if (where && sets.size) {
        const now = performance.now(), pose = where.at.concat(where.forward, where.pixels).map((v) => v.toFixed(4)).join();
        if (pose !== last) { last = pose; movedAt = now; still = false; }
        if (!still && now - movedAt > 600) { // a view that rests has all its detail
          still = true;
          for (const set of sets.values()) set.budget = set.most;
        }
        adapt(now, !still);
        let busy = false;
        for (const set of sets.values()) {
          choose(set, where);
          busy = work(set, where, now + SLICE) || busy;
        }
        if (busy) delay = 0;
      }
    }
    window.setTimeout(tick, delay);
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
    frames: () => ({ rate, drawn }),
  };
  tick();
})();
