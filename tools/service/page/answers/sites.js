/** The sites that are nearest by walking distance. */

import {element, exact} from '../dom.js';
import {counted, distance} from '../numbers.js';

/** Returns the sites of an answer. */
export function found(body) {
  return body.features.filter(feature => feature.properties.to).map(({properties, geometry}) => ({...properties, geometry}));
}

/** Returns a list of sites, each with its distance, that go to the site. */
export function list(sites, file, goTo) {
  const item = site => {
    const bounds = site.lower < site.upper && `between ${distance(site.lower, file.unit)} and ${distance(site.upper, file.unit)}`;
    const button = element(
      'button',
      {type: 'button', class: 'site', onclick: () => goTo(site.to), title: bounds || null},
      element('data', {class: 'name', value: site.site, 'data-name': 'site'}, site.site),
      exact(site.distance, distance(site.distance, file.unit), 'distance'),
    );
    return element('li', {}, button);
  };
  return element('ol', {class: 'sites'}, ...sites.map(item));
}

/** Returns what to show of the nearest sites. */
export function sites(body, state, file, goTo) {
  const all = found(body);
  const text = body.note ? [`${body.note[0].toUpperCase()}${body.note.slice(1)}.`] : [];
  return {title: all.length ? counted(all.length, 'nearest site') : 'No sites', text, parts: all.length ? [list(all, file, goTo)] : []};
}

/** Adds the sites and the ways there to the map. */
export function markSites(marks, body, state) {
  const all = found(body);
  for (const site of all) if (site.geometry.type === 'LineString') marks.line('way', site.geometry.coordinates);
  all.forEach((site, i) => marks.point('found', site.to, String(i + 1)));
  marks.point('end', state.at);
}
