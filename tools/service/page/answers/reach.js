/** What can be reached within a walking distance. */

import {element, exact} from '../dom.js';
import {area, counted, distance} from '../numbers.js';
import {found, list} from './sites.js';

/** Returns what to show of what can be reached. */
export function reach(body, state, file, goTo) {
  const all = found(body);
  const parts = [];
  if (body.area != null) parts.push(element('p', {class: 'large'}, exact(body.area, area(body.area, file.unit), 'area')));
  if (file.counts.sites > 0) parts.push(element('p', {}, `${counted(all.length, 'site')} within reach`));
  if (all.length) parts.push(list(all, file, goTo));
  return {title: `Within ${distance(state.radius, file.unit)}`, text: [], parts};
}

/** Adds the area and the sites to the map. */
export function markReach(marks, body, state) {
  for (const {geometry} of body.features) {
    if (geometry?.type === 'MultiPolygon') marks.add('area', 'MultiPolygon', geometry.coordinates);
  }
  for (const site of found(body)) marks.point('found', site.to);
  marks.point('end', state.at);
}
