/** How a visitor points at places of the map: clicks, and the keyboard with a cross in the centre. */

import {byId} from './dom.js';

/** Calls `point` with the places that the visitor points at, and `clear` to end the question. */
export function listen(chart, {point, clear}) {
  const canvas = chart.map.getCanvas();
  const cross = byId('cross');
  chart.map.on('click', event => {
    // The second click of a double click zooms.
    if (event.originalEvent.detail < 2) point(chart.pointAt(event.lngLat));
  });
  canvas.addEventListener('keydown', event => {
    if (event.key === 'Enter') point(chart.centre());
  });
  document.addEventListener('keydown', event => {
    if (event.key === 'Escape' && !document.querySelector('dialog[open]')) clear();
  });
  // The cross shows where Enter asks, for those who use the keyboard.
  canvas.addEventListener('focus', () => (cross.hidden = !canvas.matches(':focus-visible')));
  canvas.addEventListener('keydown', () => (cross.hidden = false));
  canvas.addEventListener('blur', () => (cross.hidden = true));
  canvas.addEventListener('pointerdown', () => (cross.hidden = true));
  cross.hidden = true;
}

/** Puts the cross at the centre of the part of the map that nothing covers. */
export function placeCross(padding) {
  const cross = byId('cross');
  cross.style.left = `calc(50% + ${(padding.left - padding.right) / 2}px)`;
  cross.style.top = `calc(50% + ${(padding.top - padding.bottom) / 2}px)`;
}
