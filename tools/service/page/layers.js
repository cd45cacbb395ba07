/** What the map can show of a file: its layers, their colours, and what MapLibre needs to draw them. */

/** The colours of pictures, as the service draws them, and of vectors. */
export const COLOURS = {
  free: '#f2f0ea',
  hole: '#c1c9cf',
  holes: '#7f93a3',
  lines: '#2f7d4f',
  walls: '#4a2c1d',
  outline: '#5f6f7b',
  sites: '#a8327a',
  triangles: '#23313d',
  cells: '#b3541e',
};

/** The colours of heights from the lowest to the highest; each is lighter than the one before. */
export const HEIGHTS = ['#3b4a7a', '#3f6f8f', '#4b928f', '#6db386', '#a6cb78', '#e0d983', '#fbf3c9'];
/** The colours of heights in pictures. */
export const RELIEF = ['#587c8e', '#68909a', '#7ea2a0', '#99b2a0', '#bbc6a3', '#d9d6ac', '#eee5bf', '#fbf4dc'];

/** Heights of tiles are rounded to this, in metres. */
const STEP = 1 / 256;

/** All layers in the order in which they are drawn: name, title, and whether a file has it. */
const LAYERS = [
  {name: 'shade', title: 'Picture', is: () => true},
  {name: 'heights', title: 'Heights', is: file => Boolean(file.coloured_heights)},
  {name: 'holes', title: 'Holes', is: file => file.counts.hole_triangles > 0},
  {name: 'triangles', title: 'Triangles', is: () => true},
  {name: 'cells', title: 'Cells of tiles', is: () => true},
  {name: 'lines', title: 'Break lines', is: file => file.line_kinds.includes('break line')},
  {name: 'walls', title: 'Walls', is: file => file.line_kinds.some(kind => kind !== 'break line')},
  {name: 'sites', title: 'Sites', is: file => file.counts.sites > 0},
];

/** The layers that are on at first. */
const AT_FIRST = ['shade', 'lines', 'walls', 'sites'];

/** Returns the layers of a file. */
export function layersOf(file) {
  return LAYERS.filter(layer => layer.is(file));
}

/** Returns the names of the layers that a file shows at first. */
export function atFirst(file) {
  return new Set(layersOf(file).map(layer => layer.name).filter(name => AT_FIRST.includes(name)));
}

/** Widths and sizes that grow with the zoom beyond `base`, where edges can be told apart. */
function growing(base, ...stops) {
  return ['interpolate', ['linear'], ['zoom'], ...stops.flatMap(([zoom, value]) => [base + zoom, value])];
}

/** Returns what colours heights. Where there is no surface, the tiles have the lowest height: it has no colour. */
function colouredHeights({coloured_heights: [low, high], lowest_height: lowest}) {
  const steps = HEIGHTS.length - 1;
  const first = Math.max(low, lowest + 2 * STEP);
  const span = high > first ? high - first : 1;
  const stops = HEIGHTS.flatMap((colour, step) => [first + (span * step) / steps, colour]);
  return ['interpolate', ['linear'], ['elevation'], lowest, 'rgba(59,74,122,0)', lowest + STEP, HEIGHTS[0], ...stops];
}

/** Returns the layers of MapLibre for a layer of the page. `base` is the zoom of single edges. */
export function drawn(file, base) {
  const mesh = (id, of, type, paint, more = {}) => ({id, type, source: 'mesh', 'source-layer': of, paint, ...more});
  const kind = (...kinds) => ({filter: ['in', ['get', 'kind'], ['literal', kinds]]});
  const round = {layout: {'line-join': 'round', 'line-cap': 'round'}};
  const width = (thin, thick) => growing(base, [-4, thin], [3, thick]);
  const all = {
    shade: [{id: 'shade', type: 'raster', source: 'shade', paint: {'raster-fade-duration': 120}}],
    heights: [],
    holes: [mesh('holes', 'holes', 'fill', {'fill-color': COLOURS.holes, 'fill-opacity': 0.55, 'fill-antialias': false})],
    triangles: [
      mesh('triangles', 'triangles', 'line', {
        'line-color': COLOURS.triangles,
        'line-width': growing(base, [-3, 0.35], [3, 0.8]),
        'line-opacity': 0.45,
      }),
    ],
    cells: [mesh('cells', 'cells', 'line', {'line-color': COLOURS.cells, 'line-width': 1.4, 'line-dasharray': [4, 2]})],
    lines: [mesh('lines', 'lines', 'line', {'line-color': COLOURS.lines, 'line-width': width(0.6, 2.4)}, {...kind('break'), ...round})],
    walls: [
      mesh('outlines', 'lines', 'line', {'line-color': COLOURS.outline, 'line-width': width(0.5, 2)}, {...kind('obstacle'), ...round}),
      mesh('walls', 'lines', 'line', {'line-color': COLOURS.walls, 'line-width': width(0.8, 3)}, {...kind('wall'), ...round}),
    ],
    sites: [
      mesh('sites', 'sites', 'circle', {
        'circle-color': COLOURS.sites,
        'circle-radius': growing(base, [-5, 1], [-1, 3], [3, 5.5]),
        'circle-stroke-color': '#ffffff',
        'circle-stroke-width': growing(base, [-3, 0], [-1, 1], [3, 1.5]),
        'circle-opacity': growing(base, [-6, 0.5], [-2, 1]),
      }),
      mesh('site-names', 'sites', 'symbol', {'text-color': COLOURS.sites, 'text-halo-color': '#ffffff', 'text-halo-width': 1.6}, {
        minzoom: Math.max(0, base + 1),
        layout: {
          'text-field': ['to-string', ['coalesce', ['get', 'id'], ['get', 'number']]],
          'text-font': ['sans-serif'],
          'text-size': 12,
          'text-anchor': 'top',
          'text-offset': [0, 0.5],
        },
      }),
    ],
  };
  if (file.coloured_heights) {
    const paint = {'color-relief-color': colouredHeights(file), 'color-relief-opacity': 0.8};
    all.heights = [{id: 'heights', type: 'color-relief', source: 'heights', paint}];
  }
  return layersOf(file).map(({name}) => ({name, layers: all[name]}));
}
