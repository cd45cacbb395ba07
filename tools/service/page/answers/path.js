/** The shortest path between two points. */

import {element, exact, facts} from '../dom.js';
import {counted, distance} from '../numbers.js';

/** The number of bends that are listed before the others are folded away. */
const LISTED = 5;

/** Returns what a path bends round. */
function around(bend) {
  const lines = bend.lines.map(line => `${line.kind} ${line.line}`);
  const unique = [...new Set(lines)];
  return unique.length ? unique.join(', ') : 'a corner';
}

function bendList(bends, goTo) {
  const item = bend =>
    element('li', {}, element('button', {type: 'button', class: 'site', onclick: () => goTo(bend.at)},
      element('span', {class: 'name'}, around(bend)), element('span', {}, `turns ${bend.turns}`)));
  const list = element('ol', {class: 'sites'}, ...bends.map(item));
  return element('details', {open: bends.length <= LISTED}, element('summary', {}, `Bends at ${counted(bends.length, 'corner')}`), list);
}

/** Returns what to show of a path. */
export function path(body, state, file, goTo) {
  const shown = (value, name) => exact(value, distance(value, file.unit), name);
  const beeline = Math.hypot(state.to[0] - state.from[0], state.to[1] - state.from[1]);
  const rows = facts([
    ['At least', shown(body.lower, 'lower')],
    ['At most', shown(body.upper, 'upper')],
    ['As the crow flies', shown(beeline)],
  ]);
  const bends = body.bends ?? [];
  const parts = [element('p', {class: 'large'}, shown(body.distance, 'distance')), rows];
  parts.push(bends.length ? bendList(bends, goTo) : element('p', {}, 'The path is straight.'));
  return {title: state.mode === 'fast' ? 'A short path' : 'The shortest path', text: [], parts};
}

/** Adds the path and its ends to the map. */
export function markPath(marks, body, state) {
  for (const {geometry} of body?.features ?? []) {
    if (geometry?.type !== 'LineString') continue;
    marks.line('path', geometry.coordinates);
    for (const bend of geometry.coordinates.slice(1, -1)) marks.point('bend', bend);
  }
  if (state.from) marks.point('end', state.from, 'A');
  if (state.to) marks.point('end', state.to, 'B');
}
