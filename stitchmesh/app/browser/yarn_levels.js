// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
//
// Levels of detail of yarns: which level each part needs, as seen from the camera of this page.
//
// A level is used from a radius of the yarn on the screen. While there are more triangles than the budget, all parts
// take coarser levels. A scene at rest has the whole budget, and one that moves as much as this computer draws
// fluently. Yarns that move before a camera that stands stay tubes, whatever the budget, unless they are too many.
(() => {
  "use strict";
  if (window.stitchmeshLevels) return;

  const CLOSE = 0.85; // a finer level is left only when the yarn is this much thinner on the screen than its bound
  const FEWEST = 150000; // triangles that every computer draws fluently
  // Milliseconds of a frame from which the budget of a scene that moves shrinks, and up to which it grows.
  const SLOW = 60, QUICK = 34;
  const MOST_ROUND = 1200000; // triangles of the coarsest tubes up to which yarns that move are no lines
  const BEYOND = 0.12; // angle outside the screen up to which parts have detail, so that small turns show none [rad]
  const BACK = 0.5; // cosine of the turn of the camera from which the light of lines is computed anew
  const { sphere } = window.stitchmeshShapes;

  function eye() {
    const viewer = window.__viserMutable, camera = viewer.camera;
    if (!camera || !viewer.canvas) return null;
    const at = camera.matrixWorld.elements, height = viewer.canvas.clientHeight || 1;
    const half = Math.tan((camera.fov * Math.PI) / 360), width = viewer.canvas.clientWidth || 1;
    const spread = Math.atan(half * Math.hypot(1, width / height)) + BEYOND; // angle from the middle to a corner
    const pixels = height / 2 / half; // at a distance of one
    return { at: [at[12], at[13], at[14]], forward: [-at[8], -at[9], -at[10]], pixels, spread };
  }

  function trianglesOf(set, block, level) {
    const { runs, blocks } = set.data, { sides, samples, stride } = set.levels[level];
    const points = runs[blocks[block + 1]] - runs[blocks[block]];
    const rings = samples > 0 ? points * samples : points / stride;
    return sides === 0 ? rings : 2 * sides * rings;
  }

  // The camera in the coordinates of the carrier, whose parents may be turned.
  function inside(set, where) {
    const world = set.group.matrixWorld.elements, d = where.at.map((value, k) => value - world[12 + k]);
    const turn = (v) => [0, 1, 2].map((k) => v[0] * world[4 * k] + v[1] * world[4 * k + 1] + v[2] * world[4 * k + 2]);
    return { at: turn(d), forward: turn(where.forward), pixels: where.pixels, spread: where.spread };
  }

  // Radius of the yarn of a part on the screen [pixels], 0 outside it; keeps what else depends on the camera.
  function look(set, part, seen) {
    const [centre, radius] = sphere(set.data, part.block);
    const toward = [0, 1, 2].map((k) => centre[k] + part.copy[k] - seen.at[k]);
    const far = Math.hypot(...toward), distance = Math.max(far - radius, 0.2 * radius);
    const [x, y, z] = seen.forward, along = (toward[0] * x + toward[1] * y + toward[2] * z) / (far || 1);
    const ahead = far <= radius || Math.acos(Math.max(-1, Math.min(1, along))) - Math.asin(radius / far) < seen.spread;
    part.distance = ahead ? distance : distance + 1e6;
    part.view = toward.map((value) => -value / (far || 1));
    return ahead ? (set.data.radius[set.data.blocks[part.block]] * seen.pixels) / distance : 0;
  }

  function levelOf(set, part, size) {
    const level = set.levels.findIndex((one) => size >= one.least);
    const found = level < 0 ? set.levels.length - 1 : level;
    // A part that is at a boundary between two levels stays as it is.
    const stays = part.level >= 0 && part.level < found && size >= CLOSE * set.levels[part.level].least;
    return stays ? part.level : found;
  }

  // The coarsest level of tubes, if the whole drawing has few enough triangles in it; otherwise the last level.
  function coarsestRound(set) {
    const last = set.levels.length - 1, round = set.levels.findLastIndex((level) => level.sides > 0);
    const triangles = set.parts.reduce((sum, part) => sum + trianglesOf(set, part.block, round), 0);
    return triangles <= MOST_ROUND ? round : last;
  }

  // Choose the level of each part, within a budget of triangles; with `round`, parts whose yarn is thick enough on the
  // screen stay tubes.
  function choose(set, where, budget, round) {
    const seen = inside(set, where), sizes = set.parts.map((part) => look(set, part, seen));
    for (let attempt = 0, scale = 1; attempt < 24; attempt++, scale *= 0.8) {
      set.triangles = 0;
      set.parts.forEach((part, i) => {
        part.wanted = levelOf(set, part, sizes[i] * scale);
        set.triangles += trianglesOf(set, part.block, part.wanted);
      });
      if (set.triangles <= budget) break;
    }
    const coarsest = round ? coarsestRound(set) : set.levels.length - 1;
    set.triangles = 0;
    set.parts.forEach((part, i) => {
      if (part.wanted > coarsest) part.wanted = Math.max(coarsest, levelOf(set, part, sizes[i]));
      set.triangles += trianglesOf(set, part.block, part.wanted);
    });
    for (const part of set.parts) {
      const turned = part.lit && part.lit.reduce((sum, value, k) => sum + value * part.view[k], 0) < BACK;
      if (turned && set.levels[part.wanted].sides === 0) part.made = -1;
    }
  }

  // Time of a frame: the time between two calls of the browser, if the scene was drawn in between.
  let drawn = 0, at = 0, frame = 0;
  function measure(now) {
    const info = window.__viserTestpoints && window.__viserTestpoints.rendererInfo;
    if (info && info.render.frame !== drawn) {
      if (at) frame = frame ? 0.7 * frame + 0.3 * (now - at) : now - at;
      drawn = info.render.frame;
    }
    at = now;
    requestAnimationFrame(measure);
  }
  requestAnimationFrame(measure);

  // The budget of a scene that moves: smaller where frames take long, and larger again where they are quick.
  let last = 0;
  function adapt(sets, now) {
    if (!frame || now - last < 250) return;
    last = now;
    for (const set of sets.values()) {
      if (frame > SLOW) set.moving = Math.max(FEWEST, 0.6 * Math.min(set.moving, set.triangles || set.moving));
      else if (frame < QUICK) set.moving = Math.min(set.most, 1.3 * set.moving);
    }
  }

  function levelsOf(table) {
    const levels = [];
    for (let i = 0; i + 3 < table.length; i += 4) {
      levels.push({ least: table[i], sides: table[i + 1], samples: table[i + 2], stride: table[i + 3] });
    }
    return levels;
  }

  window.stitchmeshLevels = { eye, choose, adapt, levelsOf };
})();
