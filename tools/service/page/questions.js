/** What the page asks the service. */

import {distance} from './numbers.js';

/** Returns the path of the question of a state; `null` if a point is missing. */
export function question(file, state) {
  const of = (query, parameters) => {
    const texts = Object.entries(parameters).map(([name, value]) => `${name}=${value}`);
    return `${file.id}/query/${query}?${texts.join('&')}`;
  };
  const {at, from, to, mode} = state;
  switch (state.ask) {
    case 'path':
      return from && to && of('path', {from, to, mode});
    case 'sites':
      return at && of('knn', {at, k: state.k, mode});
    case 'reach':
      return at && of('range', {at, radius: state.radius, area: true, mode});
    default:
      return at && of('locate', {at});
  }
}

/** Returns the path of the question for the height of the ground, in holes too. */
export function groundAt(file, at) {
  return `${file.id}/query/z?at=${at}&all=true`;
}

/** Returns what to do next, in words. */
export function hint(file, state) {
  if (state.ask === 'path') {
    if (!state.from) return 'Click where the path begins.';
    return state.to ? 'Click to begin another path.' : 'Click where the path ends.';
  }
  const what = {
    here: 'what is there',
    sites: 'for the sites that are nearest by walking distance',
    reach: `what can be reached within ${distance(state.radius, file.unit)}`,
  };
  return `Click the map to ask ${what[state.ask]}.`;
}
