// SPDX-FileCopyrightText: StitchMesh contributors
// SPDX-License-Identifier: Apache-2.0
//
// Shapes of yarns: the triangles of tubes, or the lines, of a block of yarns at a level of detail.
//
// A block is a list of runs, each with the control points of its own B-spline (render/yarn_blocks.py). A level says how
// many sides a tube has (none for lines), and how many rings: `samples` for each segment, or one after every `stride`
// segments.
(() => {
  "use strict";
  if (window.stitchmeshShapes) return;

  function attribute(template, array, itemSize, normalized) {
    const made = template.clone();
    made.array = array;
    made.itemSize = itemSize;
    made.count = array.length / itemSize;
    made.normalized = !!normalized;
    return made;
  }

  // Number of the rings of a run of m segments.
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

  function sizes(data, block, level) {
    let rings = 0, runs = data.blocks[block + 1] - data.blocks[block];
    for (let run = data.blocks[block]; run < data.blocks[block + 1]; run++) {
      rings += sampleCount(data.runs[run + 1] - data.runs[run] - 3, level);
    }
    if (level.sides === 0) return { vertices: rings, indices: 2 * (rings - runs) };
    return { vertices: rings * level.sides, indices: 6 * (rings - runs) * level.sides + 6 * runs * (level.sides - 2) };
  }

  function build(carrier, data, block, level, geometry, view) {
    const template = carrier.geometry.attributes.position;
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
    bound(carrier, data, block, geometry);
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
    for (let k = 0; k < n; k++) {
      cos.push(Math.cos((2 * Math.PI * k) / n));
      sin.push(Math.sin((2 * Math.PI * k) / n));
    }
    const position = out.position.array, normal = out.normal.array, colour = out.color.array;
    // On average over its sides, a tube looks as wide as the yarn: a polygon's mean width is its perimeter over pi.
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

  function bound(carrier, data, block, geometry) {
    const [centre, radius] = sphere(data, block);
    if (!geometry.boundingSphere) {
      geometry.boundingSphere = carrier.geometry.boundingSphere.clone();
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

  window.stitchmeshShapes = { build, sphere };
})();
