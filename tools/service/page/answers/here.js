/** What is at a point. */

import {element, exact, facts} from '../dom.js';
import {coordinate, distance} from '../numbers.js';

/** Returns the name of what is at the point. */
function title(body) {
  if (body.element === 'outside') return 'Beyond the data';
  return body.status === 'inside_obstacle' ? 'Inside an obstacle' : 'Free ground';
}

function text(body) {
  if (body.element !== 'outside') return [];
  const passes = body.status === 'inside_obstacle' ? 'and paths may not pass here' : 'but paths may pass here';
  return [`There are no triangles here, ${passes}.`];
}

/** Returns the row of the vertices, each with its height if there are heights. */
function corners(body, file) {
  const one = (id, i) => {
    const z = body.vertex_z[i];
    const height = z == null ? null : exact(z, `, ${distance(z, file.z_unit)}`);
    return element('span', {}, id, height);
  };
  return body.vertices.length > 0 && [body.vertices.length > 1 ? 'Vertices' : 'Vertex', ...body.vertices.map(one)];
}

/** Returns what to show of a place. `ground` is the height of the ground, where paths may not pass. */
export function here(body, state, file, plane, zoom, ground) {
  // The point was rounded to an eighth of a pixel.
  const pixel = plane.pixel(zoom) / 8;
  const [x, y] = state.at;
  const z = body.z ?? ground;
  const names = {triangle: 'in a triangle', edge: 'on an edge', vertex: 'on a vertex'};
  const rows = facts([
    ['x', exact(x, coordinate(x, pixel), 'x')],
    ['y', exact(y, coordinate(y, pixel), 'y')],
    z != null && ['Height', exact(z, distance(z, file.z_unit), 'z')],
    body.element !== 'outside' && ['Where', element('data', {value: body.element, 'data-name': 'element'}, names[body.element])],
    body.region !== null && file.counts.regions > 0 && ['Region', exact(body.region, String(body.region), 'region')],
    corners(body, file),
  ]);
  return {title: title(body), text: text(body), parts: [rows]};
}

/** Adds the triangle, edge or vertex to the map. */
export function markHere(marks, body, state) {
  const points = body.points;
  if (points.length === 3) marks.add('triangle', 'Polygon', [[...points, points[0]]]);
  if (points.length === 2) marks.line('edge', points);
  for (const corner of points) marks.point('corner', corner);
  marks.point('end', state.at);
}
