/** The page: what it shows follows from the state, which the address holds. */

import {byId, element} from './dom.js';
import {Controls} from './controls.js';
import {Files} from './files.js';
import {Idle} from './idle.js';
import {Inquiry} from './inquiry.js';
import {atFirst, layersOf} from './layers.js';
import {showLegend} from './legend.js';
import {notify} from './notice.js';
import {counted, round125} from './numbers.js';
import {Plane} from './plane.js';
import {listen, placeCross} from './pointing.js';
import {hint} from './questions.js';
import {Readout} from './readout.js';
import {describe} from './service.js';
import {Sheet} from './sheet.js';
import {format, parse} from './state.js';
import {Watch} from './watch.js';

/** How long a slider rests before its question is asked, in milliseconds. */
const REST = 120;
/** The first radius is the extent divided by this. */
const FIRST_RADIUS = 12;
const DARK = matchMedia('(prefers-color-scheme: dark)');
const STILL = matchMedia('(prefers-reduced-motion: reduce)');
const look = () => ({dark: DARK.matches, still: STILL.matches});

class Page {
  constructor(ids, Chart) {
    this.ids = ids;
    this.idle = new Idle(document.querySelector('main'));
    this.idle.begin('file');
    this.chart = new Chart('map', look());
    this.idle.watch(this.chart.map);
    this.files = new Files(ids, id => this.choose(id));
    this.controls = new Controls((changed, more) => this.change(changed, more));
    this.sheet = new Sheet(() => this.pad(true));
    this.readout = new Readout(this.chart);
    this.inquiry = new Inquiry(this.chart, this.idle, {
      goTo: point => this.chart.goTo(point),
      use: (which, point) => this.change({[which]: point}),
      failed: () => this.watch.look(),
      answered: () => this.sheet.open(byId('answer')),
    });
    this.watch = new Watch({
      changed: () => this.renew(),
      gone: problem => notify(`${problem.message} ${problem.advice} This page goes on asking.`, {stays: true}),
      back: () => this.again(),
    });
    this.listen();
  }

  listen() {
    const {map} = this.chart;
    listen(this.chart, {point: point => this.point(point), clear: () => this.clear()});
    map.on('moveend', () => this.remember(false));
    map.on('idle', () => this.showOmitted());
    map.on('error', ({error}) => {
      if (!error?.status && error?.name !== 'AbortError') this.watch.look();
    });
    byId('zoom-in').addEventListener('click', () => this.chart.move({zoom: map.getZoom() + 1}));
    byId('zoom-out').addEventListener('click', () => this.chart.move({zoom: map.getZoom() - 1}));
    byId('fit').addEventListener('click', () => this.chart.fit());
    byId('clear').addEventListener('click', () => this.clear());
    for (const media of [DARK, STILL]) media.addEventListener('change', () => this.chart.setLook(look()));
    addEventListener('popstate', () => this.open(parse(location.hash)));
  }

  /** Shows a state: that of the address, or a new one. `described` is what is known of its file. */
  async open(state, described = null) {
    this.idle.begin('file');
    const missing = state.file !== null && !this.ids.includes(state.file);
    const id = missing || state.file === null ? this.ids[0] : state.file;
    if (missing) notify(`There is no file “${state.file}” here. This is ${id}.`);
    try {
      if (this.file?.id !== id) await this.setFile(await (described ?? describe(id)), state);
      this.setState({...state, file: id});
      this.remember(false);
    } catch (problem) {
      notify(`${problem.message} ${problem.advice ?? ''}`, {stays: true});
    } finally {
      reveal();
      this.idle.end('file');
    }
  }

  /** Takes another file. */
  async setFile(file, state) {
    const grid = file.grids.native;
    if (grid.missing) throw new Error(`${file.id} has nothing to show: ${grid.missing}.`);
    this.file = file;
    this.plane = new Plane(grid.tile_0, grid.bounds, file.unit);
    this.files.current = file.id;
    this.controls.setFile(file, this.plane);
    this.watch.follow(file);
    this.describe();
    reveal();
    await this.chart.show(file, this.plane, state.layers ?? atFirst(file));
  }

  /** Shows the name of the file, and what it has. */
  describe() {
    const {id, counts} = this.file;
    document.title = `${id} – tile files`;
    byId('name').textContent = id;
    const parts = [counted(counts.triangles, 'triangle'), counted(counts.vertices, 'vertex', 'vertices')];
    if (counts.sites > 0) parts.push(counted(counts.sites, 'site'));
    byId('summary').replaceChildren(...parts.map(part => element('span', {}, part)));
  }

  /** Takes a state: view, layers and question. */
  setState(state) {
    const known = new Set(layersOf(this.file).map(layer => layer.name));
    const layers = state.layers ?? atFirst(this.file);
    const next = {
      ...state,
      layers: new Set([...layers].filter(name => known.has(name))),
      radius: state.radius ?? round125(this.plane.extent() / FIRST_RADIUS),
      three: state.three && Boolean(this.file.coloured_heights),
      ask: state.ask === 'sites' && this.file.counts.sites === 0 ? 'here' : state.ask,
    };
    // Until the map shows the view, its moves are not remembered.
    this.state = null;
    this.pad(false);
    this.chart.setLayers(next.layers);
    this.chart.setThree(next.three, next.height);
    this.chart.setView(next);
    this.state = next;
    this.show();
    this.ask();
  }

  /** Takes what the visitor changed. `more` may follow at once, so the question waits. */
  change(changed, more = false) {
    const before = this.state;
    this.state = {...before, ...changed};
    if (changed.layers) this.chart.setLayers(changed.layers);
    if ('three' in changed || 'height' in changed) this.chart.setThree(this.state.three, this.state.height);
    if ('three' in changed) this.chart.tilt(changed.three);
    this.show();
    this.remember(!more);
    if ('layers' in changed || 'three' in changed || 'height' in changed) return;
    clearTimeout(this.resting);
    this.idle.begin('query');
    if (more) this.resting = setTimeout(() => this.ask(), REST);
    else this.ask();
  }

  /** Asks at a point. */
  point(point) {
    if (this.state.ask !== 'path') this.change({at: point});
    else if (this.state.from && !this.state.to) this.change({to: point});
    else this.change({from: point, to: null});
  }

  /** Ends the question. */
  clear() {
    if (this.state.at || this.state.from) this.change({at: null, from: null, to: null});
  }

  ask() {
    this.inquiry.run(this.file, this.plane, this.state);
  }

  /** Shows the state on the panel. */
  show() {
    const {state, file} = this;
    this.controls.show(state);
    showLegend(file, state);
    byId('hint').textContent = hint(file, state);
    byId('clear').hidden = !(state.ask === 'path' ? state.from : state.at);
  }

  /** Says which layers are left out because they have too much. */
  showOmitted() {
    if (!this.state) return;
    const left = this.chart.omitted();
    const titles = layersOf(this.file).filter(({name}) => this.state.layers.has(name) && left.has(name));
    const note = byId('omitted');
    note.hidden = titles.length === 0;
    note.textContent = `Too much to draw at this zoom: ${titles.map(({title}) => title.toLowerCase()).join(', ')}. Zoom in.`;
  }

  /** Writes the state to the address, as a new step back or in place of the present one. */
  remember(asStep) {
    if (!this.state) return;
    Object.assign(this.state, this.chart.view());
    const address = `${location.pathname}${location.search}${format(this.state)}`;
    if (asStep && address !== `${location.pathname}${location.search}${location.hash}`) history.pushState(null, '', address);
    else history.replaceState(null, '', address);
  }

  choose(id) {
    history.pushState(null, '', `${location.pathname}${location.search}#file=${id}`);
    this.open(parse(location.hash));
  }

  /** Shows the file in its new state. */
  async renew() {
    const file = await describe(this.file.id);
    const before = this.file;
    const isSameSquare = String(file.grids.native.tile_0) === String(before.grids.native.tile_0);
    const names = of => layersOf(of).map(({name}) => name).join();
    const isSameKind = names(file) === names(before) && file.minZoom === before.minZoom;
    if (isSameSquare && isSameKind) {
      this.file = file;
      this.plane = new Plane(file.grids.native.tile_0, file.grids.native.bounds, file.unit);
      this.chart.renew(file, this.plane);
      this.watch.follow(file);
      this.describe();
      this.ask();
    } else {
      await this.setFile(file, this.state);
      this.setState(this.state);
    }
    notify(`The file was replaced. The map shows its new state, generation ${file.generation}.`);
  }

  /** Asks again for all that the server did not answer. */
  again() {
    notify('The server is back.');
    this.chart.renew(this.file, this.plane);
    if (byId('answer').dataset.status === 'error') this.ask();
  }

  /** Keeps the centre of the map out from under the panel. */
  pad(softly) {
    const padding = this.sheet.padding();
    placeCross(padding);
    this.chart.setPadding(padding, softly);
  }
}

/** Shows the controls, which do nothing before a file is there or has failed. */
function reveal() {
  for (const id of ['panel', 'tools', 'readout']) byId(id).hidden = false;
}

async function start() {
  const ids = JSON.parse(byId('ids').textContent);
  const state = parse(location.hash);
  // The file is described while the map's code is on its way.
  const described = describe(ids.includes(state.file) ? state.file : ids[0]);
  described.catch(() => {});
  const {Chart} = await import('./chart.js');
  const page = new Page(ids, Chart);
  await page.open(state, described);
}

start().catch(error => {
  const isGraphics = /webgl/i.test(error.message);
  notify(isGraphics ? 'This page needs WebGL, which this browser does not have or has turned off.' : error.message, {stays: true});
  throw error;
});
