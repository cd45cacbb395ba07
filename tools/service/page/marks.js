/** What the map shows of an answer: places, paths, areas. */

const BLUE = '#1257a8';
const WHITE = '#ffffff';
/** The colours of answers, for the legend. */
export const ANSWER_COLOURS = {path: BLUE, area: BLUE, found: '#a8327a', triangle: '#c2410c'};

/** Returns the source of answers, which is empty at first. */
export function answerSource() {
  return {type: 'geojson', data: {type: 'FeatureCollection', features: []}, maxzoom: 24, tolerance: 0.1};
}

function layer(id, type, kind, paint, layout = {}) {
  return {id: `answer-${id}`, type, source: 'answer', filter: ['==', ['get', 'mark'], kind], paint, layout};
}

/** Returns the layers that draw answers. */
export function answerLayers() {
  const round = {'line-join': 'round', 'line-cap': 'round'};
  const text = (size, anchor, offset) => ({
    'text-field': ['get', 'label'],
    'text-font': ['sans-serif'],
    'text-size': size,
    'text-anchor': anchor,
    'text-offset': offset,
    'text-allow-overlap': true,
    'text-ignore-placement': true,
  });
  return [
    layer('area', 'fill', 'area', {'fill-color': BLUE, 'fill-opacity': 0.2}),
    layer('area-edge', 'line', 'area', {'line-color': BLUE, 'line-width': 1.5, 'line-opacity': 0.8}, round),
    layer('triangle', 'fill', 'triangle', {'fill-color': ANSWER_COLOURS.triangle, 'fill-opacity': 0.25}),
    layer('triangle-edge', 'line', 'triangle', {'line-color': ANSWER_COLOURS.triangle, 'line-width': 2}, round),
    layer('edge', 'line', 'edge', {'line-color': ANSWER_COLOURS.triangle, 'line-width': 3}, round),
    layer('casing', 'line', 'path', {'line-color': WHITE, 'line-width': 6, 'line-opacity': 0.9}, round),
    layer('path', 'line', 'path', {'line-color': BLUE, 'line-width': 3.2}, round),
    layer('way', 'line', 'way', {'line-color': BLUE, 'line-width': 2, 'line-opacity': 0.55}, round),
    layer('detour', 'line', 'detour', {'line-color': '#b42318', 'line-width': 2, 'line-dasharray': [2, 2]}, round),
    layer('bend', 'circle', 'bend', {
      'circle-color': WHITE,
      'circle-radius': 3.5,
      'circle-stroke-color': BLUE,
      'circle-stroke-width': 2,
    }),
    layer('found', 'circle', 'found', {
      'circle-color': ANSWER_COLOURS.found,
      'circle-radius': ['case', ['==', ['get', 'label'], ''], 6, 10],
      'circle-stroke-color': WHITE,
      'circle-stroke-width': 2,
    }),
    layer('found-label', 'symbol', 'found', {'text-color': WHITE}, text(11, 'center', [0, 0])),
    layer('corner', 'circle', 'corner', {
      'circle-color': ANSWER_COLOURS.triangle,
      'circle-radius': 4,
      'circle-stroke-color': WHITE,
      'circle-stroke-width': 1.5,
    }),
    layer('free', 'circle', 'free', {
      'circle-color': WHITE,
      'circle-radius': 5,
      'circle-stroke-color': '#b42318',
      'circle-stroke-width': 2.5,
    }),
    layer('end', 'circle', 'end', {
      'circle-color': '#10202e',
      'circle-radius': ['case', ['==', ['get', 'label'], ''], 6, 11],
      'circle-stroke-color': WHITE,
      'circle-stroke-width': 2.5,
    }),
    layer('end-label', 'symbol', 'end', {'text-color': WHITE}, text(12, 'center', [0, 0])),
  ];
}

/** Collects what an answer shows, in coordinates of the file. */
export class Marks {
  constructor(plane) {
    this.plane = plane;
    this.features = [];
  }

  add(mark, type, coordinates, label = '') {
    const place = value => (typeof value[0] === 'number' ? this.plane.toMap(value) : value.map(place));
    const geometry = {type, coordinates: place(coordinates)};
    this.features.push({type: 'Feature', properties: {mark, label}, geometry});
    return this;
  }

  point(mark, at, label) {
    return this.add(mark, 'Point', at, label);
  }

  line(mark, points) {
    return points.length > 1 ? this.add(mark, 'LineString', points) : this;
  }

  collection() {
    return {type: 'FeatureCollection', features: this.features};
  }
}
