/** Answers that are no result, in words. */

import {distance} from '../numbers.js';
import {exact} from '../dom.js';

/** Returns whether two points are the same. */
function same(a, b) {
  return Boolean(a && b) && a[0] === b[0] && a[1] === b[1];
}

/** Returns what a point of a question is called, and its parameter. */
function role(state, point) {
  if (state.ask !== 'path') return {which: 'at', called: 'This point'};
  return same(point, state.from) ? {which: 'from', called: 'The start'} : {which: 'to', called: 'The end'};
}

function insideObstacle(body, state, file) {
  const {which, called} = role(state, body.inside_point);
  const free = body.nearest_free;
  const shown = {title: `${called} is inside an obstacle`, text: []};
  if (!free) return {...shown, text: ['There is no free point in this file.']};
  const away = Math.hypot(free[0] - body.inside_point[0], free[1] - body.inside_point[1]);
  const text = ['The nearest free point is ', exact(away, distance(away, file.unit), 'nearest_free'), ' away.'];
  return {...shown, text, fix: {label: 'Use the nearest free point', which, point: free}};
}

function outOfBudget(body, state, file) {
  const least = exact(body.lower_bound, distance(body.lower_bound, file.unit), 'lower_bound');
  const known = {
    path: ['What is known: the path is at least ', least, ' long.'],
    sites: ['What is known: all other sites are at least ', least, ' away.'],
    reach: ['What is known: all that was not found is at least ', least, ' away.'],
    here: [],
  };
  const text = ['The server limits how many tiles a question may read, and for how long. ', ...known[state.ask]];
  if (state.ask !== 'here' && state.mode === 'exact') text.push(' A fast answer may need less.');
  return {title: 'The search reached its limit', text};
}

/** Returns a title, a text and perhaps what would help; `null` for an answer that is a result. */
export function explain(body, state, file) {
  switch (body.status) {
    case 'inside_obstacle':
      return insideObstacle(body, state, file);
    case 'out_of_budget':
      return outOfBudget(body, state, file);
    case 'unreachable':
      return {
        title: 'There is no path',
        text: ['Walls and obstacles lie all round the start or the end, so no path leads from one to the other.'],
      };
    default:
      return null;
  }
}
