/** The scale bar, and the coordinates under the pointer or at the centre. */

import {byId} from './dom.js';
import {coordinate, distance, round125} from './numbers.js';

/** The length of the longest scale bar, in pixels. */
const LONGEST = 130;

export class Readout {
  constructor(chart) {
    this.chart = chart;
    this.pointer = null;
    chart.map.on('move', () => this.show());
    chart.map.on('mousemove', event => this.at(event.point));
    chart.map.on('mouseout', () => this.at(null));
    // The keyboard asks at the centre.
    chart.map.getCanvas().addEventListener('keydown', () => this.at(null));
  }

  at(pixel) {
    this.pointer = pixel;
    this.show();
  }

  show() {
    const {plane, map, file} = this.chart;
    if (!plane) return;
    const pixel = plane.pixel(map.getZoom());
    const length = round125(pixel * LONGEST);
    byId('scale-text').textContent = distance(length, file.unit);
    byId('scale-bar').style.width = `${length / pixel}px`;
    byId('scale').hidden = map.getPitch() > 0;
    const [x, y] = plane.toPlane(this.pointer ? map.unproject(this.pointer) : map.getCenter());
    byId('coordinates').textContent = `${coordinate(x, pixel)}, ${coordinate(y, pixel)}`;
  }
}
