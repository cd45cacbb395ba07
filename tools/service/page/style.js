/** The style of the map: sources and layers for MapLibre. */

import {drawn} from './layers.js';
import {mapZoom} from './plane.js';
import {address} from './service.js';
import {answerLayers, answerSource} from './marks.js';

/** How many zooms deeper than single edges the map goes. */
const DEEPER = 6;

/** Returns the deepest zoom of the map. */
export function deepest(file) {
  return mapZoom(file.grids.native.max_zoom + DEEPER) - 1;
}

/** Returns the addresses of the tiles of a layer in this version of the file. */
function tiles(file, layer, ending) {
  return [address(`${file.id}/native/${layer}/`) + `{z}/{x}/{y}.${ending}?v=${file.version}`];
}

/** Returns the addresses of the tiles of each source. */
export function addresses(file) {
  const all = {shade: tiles(file, 'shade', 'png'), mesh: tiles(file, 'mesh', 'mvt')};
  if (file.coloured_heights) all.heights = all.ground = [`${tiles(file, 'terrarium', 'png')[0]}&opaque=true`];
  return all;
}

/** The height of a terrarium tile whose colour is black, in metres. */
const BLACK = -32_768;

/** Returns the encoding of tiles of heights above the lowest one. So the ground does not drop where there are no tiles. */
function aboveLowest({lowest_height: lowest}) {
  return {encoding: 'custom', redFactor: 256, greenFactor: 1, blueFactor: 1 / 256, baseShift: lowest - BLACK};
}

function sources(file, plane) {
  const bounds = plane.boundsOnMap().flat();
  const zooms = {minzoom: mapZoom(file.minZoom), maxzoom: mapZoom(file.grids.native.max_zoom + DEEPER)};
  const types = {
    shade: {type: 'raster', tileSize: 256},
    heights: {type: 'raster-dem', tileSize: 256, encoding: 'terrarium'},
    ground: {type: 'raster-dem', tileSize: 256, ...aboveLowest(file)},
    mesh: {type: 'vector', minzoom: mapZoom(0)},
  };
  const of = ([name, tiles]) => [name, {...zooms, bounds, tiles, ...types[name]}];
  return Object.fromEntries(Object.entries(addresses(file)).map(of));
}

/** Returns the style of a file, whose first pictures appear at once. `look` says whether it is dark. Round the data, nothing is
 * drawn: there is the background of the page. */
export function styleOf(file, plane, layers, look) {
  const base = mapZoom(file.grids.native.max_zoom) - 1;
  const shown = drawn(file, base).flatMap(({name, layers: all}) =>
    all.map(layer => ({...layer, layout: {...layer.layout, visibility: layers.has(name) ? 'visible' : 'none'}})),
  );
  for (const layer of shown) if (layer.type === 'raster') layer.paint = rasterPaint({...look, still: true});
  return {
    version: 8,
    projection: {type: 'identity'},
    sources: {...sources(file, plane), answer: answerSource()},
    layers: [...shown, ...answerLayers()],
    transition: {duration: look.still ? 0 : 150},
  };
}

/** Returns how pictures are drawn: in the dark, less bright. */
export function rasterPaint(look) {
  const dark = {'raster-brightness-max': 0.72, 'raster-saturation': -0.1};
  return {'raster-fade-duration': look.still ? 0 : 120, ...(look.dark ? dark : {})};
}
