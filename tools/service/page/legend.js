/** The legend: the colours that are on the map. */

import {byId, element} from './dom.js';
import {COLOURS, HEIGHTS, RELIEF} from './layers.js';
import {ANSWER_COLOURS} from './marks.js';
import {grouped} from './numbers.js';

/** Returns a drawing of a colour: an area, a veil, a line, a thin line, a broken line or a dot. */
function swatch(kind, colour) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 16');
  svg.setAttribute('aria-hidden', 'true');
  const shapes = {
    area: ['rect', {x: 2, y: 2, width: 20, height: 12, rx: 2, fill: colour}],
    veil: ['rect', {x: 3, y: 2, width: 18, height: 12, rx: 2, fill: colour, 'fill-opacity': 0.2, stroke: colour, 'stroke-width': 1.5}],
    line: ['path', {d: 'M2 12 9 5l6 5 7-6', fill: 'none', stroke: colour, 'stroke-width': 2.4}],
    thin: ['path', {d: 'M2 13 12 3l10 10zM12 3v10', fill: 'none', stroke: colour, 'stroke-width': 1}],
    broken: ['path', {d: 'M2 3h20v10H2z', fill: 'none', stroke: colour, 'stroke-width': 1.4, 'stroke-dasharray': '4 2'}],
    dot: ['circle', {cx: 12, cy: 8, r: 5, fill: colour, stroke: '#fff', 'stroke-width': 1.5}],
  };
  const [name, attributes] = shapes[kind];
  const shape = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) shape.setAttribute(key, value);
  svg.append(shape);
  return svg;
}

function entry(kind, colour, title) {
  return element('li', {}, swatch(kind, colour), element('span', {}, title));
}

/** Returns the entry of a scale of heights. */
function scale(title, colours, [low, high]) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', `0 0 ${(colours.length - 1) * 20} 10`);
  svg.setAttribute('preserveAspectRatio', 'none');
  svg.setAttribute('aria-hidden', 'true');
  const id = `scale-${title.replace(/\W/g, '')}`;
  const stops = colours.map((colour, i) => `<stop offset="${i / (colours.length - 1)}" stop-color="${colour}"/>`);
  // All of it is constant but for the colours of this program.
  svg.innerHTML = `<defs><linearGradient id="${id}">${stops.join('')}</linearGradient></defs><rect width="100%" height="10" fill="url(#${id})"/>`;
  const decimals = Math.min(3, Math.max(0, 2 - Math.floor(Math.log10(high - low || 1))));
  const end = height => element('span', {}, `${grouped(height, decimals)}\u202fm`);
  const ends = element('span', {class: 'ends'}, end(low), end(high));
  return element('li', {class: 'scale'}, element('span', {}, title), svg, ends);
}

/** Returns the entries of a picture. */
function picture(file) {
  const heights = file.coloured_heights;
  const ground = heights ? scale('Height, shaded', RELIEF, heights) : entry('area', COLOURS.free, 'Free ground');
  const hole = file.counts.hole_triangles > 0 ? [entry('area', COLOURS.hole, 'Obstacle or hole')] : [];
  const entries = [ground, ...hole];
  // In the dark, pictures are dimmed.
  for (const part of entries) part.classList.add('picture');
  return entries;
}

const ENTRIES = {
  shade: picture,
  heights: file => [scale('Height', HEIGHTS, file.coloured_heights)],
  holes: () => [entry('area', COLOURS.holes, 'Hole')],
  triangles: () => [entry('thin', COLOURS.triangles, 'Triangle')],
  cells: () => [entry('broken', COLOURS.cells, 'Cell of a tile')],
  lines: () => [entry('line', COLOURS.lines, 'Break line')],
  walls: file => [
    ...(file.line_kinds.includes('wall') ? [entry('line', COLOURS.walls, 'Wall')] : []),
    ...(file.line_kinds.includes('obstacle') ? [entry('line', COLOURS.outline, 'Rim of an obstacle')] : []),
  ],
  sites: () => [entry('dot', COLOURS.sites, 'Site')],
};

const ANSWERS = {
  path: () => [entry('line', ANSWER_COLOURS.path, 'Path')],
  sites: () => [entry('line', ANSWER_COLOURS.path, 'Way to a site')],
  reach: () => [entry('veil', ANSWER_COLOURS.area, 'Within reach')],
  here: () => [],
};

/** Shows the legend of a state. */
export function showLegend(file, state) {
  const shown = Object.keys(ENTRIES).filter(name => state.layers.has(name));
  const entries = shown.flatMap(name => ENTRIES[name](file));
  byId('legend-list').replaceChildren(...entries, ...ANSWERS[state.ask]());
  byId('legend').hidden = entries.length === 0;
}
