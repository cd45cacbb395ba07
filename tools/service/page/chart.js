/** The map: MapLibre with the tiles of one file. */

import {Map as MapLibre} from './vendor/maplibre-gl/maplibre-gl.mjs';
import {nativeUrl} from './plane.js';
import {drawn} from './layers.js';
import {addresses, deepest, rasterPaint, styleOf} from './style.js';

/** Room round the data, in pixels, when all of it is shown: for the legend too, where there is space. */
const ROOM = 28;
const WIDE = matchMedia('(min-width: 1000px)');
const ROOM_OF_LEGEND = 215;
const ROOM_OF_SCALE = 52;
/** The slope of the view at which 3D begins. */
const PITCH = 55;

export class Chart {
  /** `look` says whether it is dark, and whether nothing shall move by itself. */
  constructor(container, look) {
    this.look = look;
    this.map = new MapLibre({
      container,
      attributionControl: false,
      renderWorldCopies: false,
      minZoom: 1,
      maxPitch: 75,
      pitchWithRotate: false,
      dragRotate: false,
      fadeDuration: 0,
      maxTileCacheSize: 80,
      transformRequest: url => ({url: nativeUrl(url)}),
    });
    this.map.touchZoomRotate.disableRotation();
    this.map.touchPitch.disable();
    this.map.keyboard.disableRotation();
    this.map.getCanvas().setAttribute('aria-label', 'Map: arrows move it, plus and minus zoom, Enter asks at the cross');
  }

  /** Shows a file. Ends when the map knows what to draw. */
  async show(file, plane, layers) {
    Object.assign(this, {file, plane, layers});
    if (this.map.getTerrain()) this.map.setTerrain(null);
    const styled = new Promise(resolve => this.map.once('style.load', resolve));
    this.map.setMaxZoom(Math.min(24, deepest(file)));
    this.map.setStyle(styleOf(file, plane, layers, this.look), {diff: false});
    await styled;
    // From then on, pictures fade in.
    this.map.once('idle', () => this.map.once('movestart', () => this.setLook(this.look)));
  }

  /** Shows a new version of the same file, in the same square. Tiles stay until the new ones are there. */
  renew(file, plane) {
    Object.assign(this, {file, plane});
    for (const [name, tiles] of Object.entries(addresses(file))) this.map.getSource(name)?.setTiles(tiles);
  }

  /** Shows these layers only. */
  setLayers(layers) {
    this.layers = layers;
    for (const {name, layers: all} of drawn(this.file, 0)) {
      const visibility = layers.has(name) ? 'visible' : 'none';
      for (const {id} of all) this.map.setLayoutProperty(id, 'visibility', visibility);
    }
  }

  /** Shows an answer. */
  setMarks(marks) {
    this.map.getSource('answer').setData(marks.collection());
  }

  /** Shows the terrain in 3D, or the plane. Heights are multiplied by `height`. */
  setThree(on, height) {
    const handlers = [this.map.dragRotate, this.map.touchPitch];
    for (const handler of handlers) handler[on ? 'enable' : 'disable']();
    this.map.touchZoomRotate[on ? 'enableRotation' : 'disableRotation']();
    this.map.keyboard[on ? 'enableRotation' : 'disableRotation']();
    if (on) this.map.setTerrain({source: 'ground', exaggeration: this.plane.proportion() * height});
    else if (this.map.getTerrain()) this.map.setTerrain(null);
  }

  /** Tilts the view for 3D, or lets it look straight down. */
  tilt(on) {
    this.move({pitch: on ? PITCH : 0, bearing: 0});
  }

  /** Returns the view, as the address has it. */
  view() {
    const zoom = Number(this.map.getZoom().toFixed(2));
    const [x, y] = this.plane.rounded(this.plane.toPlane(this.map.getCenter()), zoom);
    const [bearing, pitch] = [this.map.getBearing(), this.map.getPitch()].map(angle => Math.round(angle));
    return {x, y, zoom, bearing, pitch};
  }

  /** Shows a view of the address, or everything. */
  setView({x, y, zoom, three, ...angles}) {
    const bearing = three ? angles.bearing : 0;
    const pitch = three ? (angles.pitch ?? PITCH) : 0;
    if (x === null || y === null) this.fit({duration: 0, bearing, pitch});
    else this.map.jumpTo({center: this.plane.toMap([x, y]), zoom: zoom ?? this.map.getZoom(), bearing, pitch});
  }

  /** Shows all of the file. */
  fit(options = {}) {
    const [right, bottom] = WIDE.matches ? [ROOM_OF_LEGEND, ROOM_OF_SCALE] : [ROOM, ROOM];
    this.map.fitBounds(this.plane.boundsOnMap(), {
      padding: {top: ROOM, left: ROOM, right, bottom},
      duration: this.look.still ? 0 : 500,
      bearing: this.map.getBearing(),
      pitch: this.map.getPitch(),
      ...options,
    });
  }

  /** Moves to a view, softly unless the visitor wants no movement. */
  move(options) {
    this.map.easeTo({duration: this.look.still ? 0 : 350, ...options});
  }

  /** Moves to a point, if it is not in sight. */
  goTo(point) {
    this.move({center: this.plane.toMap(point)});
  }

  /** Keeps the centre out from under the panel. */
  setPadding(padding, softly) {
    if (softly) this.move({padding});
    else this.map.setPadding(padding);
  }

  /** Takes another look: dark or light, moving or still. */
  setLook(look) {
    this.look = look;
    if (!this.file) return;
    const paint = {'raster-brightness-max': 1, 'raster-saturation': 0, ...rasterPaint(look)};
    for (const [name, value] of Object.entries(paint)) this.map.setPaintProperty('shade', name, value);
  }

  /** Returns the point of the file under the centre, and under a pixel. */
  centre() {
    return this.plane.rounded(this.plane.toPlane(this.map.getCenter()), this.map.getZoom());
  }

  /** Returns the point of the file at a place of the map, with the digits that the zoom shows. */
  pointAt(place) {
    return this.plane.rounded(this.plane.toPlane(place), this.map.getZoom());
  }

  /** Returns the names of layers that are left out in a tile in sight because they have too much. */
  omitted() {
    const found = this.map.querySourceFeatures('mesh', {sourceLayer: 'info'});
    return new Set(found.flatMap(({properties}) => (properties.omitted ?? '').split(/[ ,]+/)).filter(Boolean));
  }
}
