/** The answer to a question: on the panel and on the map. */

import {element, exact} from './dom.js';
import {counted, grouped} from './numbers.js';
import {Marks} from './marks.js';
import {explain} from './answers/statuses.js';
import {here, markHere} from './answers/here.js';
import {markSites, sites} from './answers/sites.js';
import {markReach, reach} from './answers/reach.js';
import {markPath, path} from './answers/path.js';

const SHOWS = {sites, reach, path};
const DRAWS = {here: markHere, sites: markSites, reach: markReach, path: markPath};

/** Returns what the answer took, in words. */
function cost(headers) {
  const time = /dur=([\d.]+)/.exec(headers.get('server-timing') ?? '');
  const tiles = headers.get('tiles-read');
  if (!time || tiles === null) return null;
  const milliseconds = Number(time[1]);
  const shown = milliseconds < 10 ? milliseconds.toFixed(1) : grouped(milliseconds);
  const children = [
    exact(tiles, counted(Number(tiles), 'tile'), 'tiles_read'),
    ' read in ',
    exact(time[1], `${shown}\u202fms`, 'time'),
  ];
  return element('p', {class: 'cost'}, ...children);
}

/** Fills the panel's answer with a title, a text and parts. */
function fill(panel, status, {title, text = [], parts = []}, ...more) {
  panel.dataset.status = status;
  const paragraph = text.length ? element('p', {}, ...text) : null;
  panel.replaceChildren(...[element('h3', {}, title), paragraph, ...parts, ...more].filter(Boolean));
}

/** Shows an answer. `context` has the file, the plane, the zoom, and what to do on clicks. */
export function showAnswer(panel, body, headers, state, context) {
  const {file, plane, zoom, ground, goTo, use} = context;
  const isHere = state.ask === 'here';
  const problem = explain(body, state, file);
  let fix = null;
  if (problem?.fix) {
    const {label, which, point} = problem.fix;
    fix = element('button', {type: 'button', class: 'action', onclick: () => use(which, point)}, label);
  }
  let shown = problem;
  if (isHere) {
    shown = here(body, state, file, plane, zoom, ground);
    if (body.status === 'inside_obstacle') shown.text = problem.text;
  } else if (!problem) {
    shown = SHOWS[state.ask](body, state, file, goTo);
  } else if (body.status === 'out_of_budget' && state.ask !== 'path') {
    shown.parts = SHOWS[state.ask](body, state, file, goTo).parts;
  }
  fill(panel, body.status, shown, fix, cost(headers));
}

/** Returns the marks of an answer. Without one, those of the points of the question. */
export function marksOf(body, state, plane) {
  const marks = new Marks(plane);
  if (!body) {
    if (state.ask === 'path') markPath(marks, null, state);
    else if (state.at) marks.point('end', state.at);
    return marks;
  }
  if (body.nearest_free && body.inside_point) {
    marks.line('detour', [body.inside_point, body.nearest_free]).point('free', body.nearest_free);
  }
  DRAWS[state.ask](marks, body, state);
  return marks;
}

/** Shows why there is no answer. */
export function showProblem(panel, problem, again) {
  const button = element('button', {type: 'button', class: 'action', onclick: again}, 'Ask again');
  fill(panel, 'error', {title: problem.message, text: [problem.advice ?? ''].filter(Boolean)}, button);
}

/** Shows no answer. */
export function clearAnswer(panel) {
  delete panel.dataset.status;
  panel.replaceChildren();
}
