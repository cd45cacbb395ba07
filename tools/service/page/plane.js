/**
 * The plane of a file, and its place on the map.
 *
 * The map has the projection `identity` of MapLibre: longitudes and latitudes from -90 to 90 are a square, linearly. The
 * square of the grid `native` is one tile of that square, with room round it. So tiles fit, and coordinates of the file are
 * linear on the map.
 */

/** The tile of the map that is tile 0/0/0 of the file. */
const ROOT = {zoom: 3, column: 3, row: 3};
/** The side of the map, in its degrees. */
const WORLD = 180;
const SIDE = WORLD / 2 ** ROOT.zoom;
const WEST = -90 + ROOT.column * SIDE;
const SOUTH = 90 - (ROOT.row + 1) * SIDE;
/** The side of the map at zoom 0, in pixels. */
const PIXELS = 512;
/** The deepest zoom of tiles that MapLibre knows. */
const DEEPEST = 25;
/** The length of a degree of latitude, in metres. */
const DEGREE = 111_320;

export class Plane {
  /** `square` is the square of tile 0/0/0: west, south, east and north. */
  constructor(square, bounds, unit) {
    [this.west, this.south] = square;
    this.side = square[2] - square[0];
    this.bounds = bounds;
    this.unit = unit;
  }

  /** Returns the place of a point on the map. */
  toMap([x, y]) {
    return [WEST + ((x - this.west) / this.side) * SIDE, SOUTH + ((y - this.south) / this.side) * SIDE];
  }

  /** Returns the point at a place of the map. */
  toPlane({lng, lat}) {
    return [this.west + ((lng - WEST) / SIDE) * this.side, this.south + ((lat - SOUTH) / SIDE) * this.side];
  }

  /** Returns the rectangle of the data on the map: the south-west and the north-east. */
  boundsOnMap() {
    const [west, south, east, north] = this.bounds;
    return [this.toMap([west, south]), this.toMap([east, north])];
  }

  /** Returns the length of a pixel at a zoom of the map. */
  pixel(zoom) {
    return ((this.side / SIDE) * WORLD) / (PIXELS * 2 ** zoom);
  }

  /** Returns a point with the decimals that can be told apart at a zoom. */
  rounded([x, y], zoom) {
    const decimals = Math.min(15, Math.max(0, Math.ceil(-Math.log10(this.pixel(zoom) / 8))));
    return [x, y].map(value => Number(value.toFixed(decimals)));
  }

  /** Returns whether a point is within the rectangle of the data. */
  has([x, y]) {
    const [west, south, east, north] = this.bounds;
    return x >= west && x <= east && y >= south && y <= north;
  }

  /** Returns the larger side of the rectangle of the data. */
  extent() {
    const [west, south, east, north] = this.bounds;
    return Math.max(east - west, north - south) || 1;
  }

  /** Returns by how much heights in metres are multiplied to be in proportion to the plane. */
  proportion() {
    const metres = this.unit.name === 'degrees' ? DEGREE : (this.unit.metres ?? 1);
    return SIDE / (this.side * metres);
  }
}

/** Returns the zoom of the map's tiles for one of the file's tiles. */
export function mapZoom(zoom) {
  return Math.min(DEEPEST, zoom + ROOT.zoom);
}

/** Replaces the numbers of a tile of the map by those of the file's grid. Other addresses stay. */
export function nativeUrl(url) {
  return url.replace(/\/native\/(\w+)\/(\d+)\/(\d+)\/(\d+)\./, (_, layer, zoom, column, row) => {
    const own = Number(zoom) - ROOT.zoom;
    const [x, y] = [Number(column) - ROOT.column * 2 ** own, Number(row) - ROOT.row * 2 ** own];
    return `/native/${layer}/${own}/${x}/${y}.`;
  });
}
