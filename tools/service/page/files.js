/** The list of files, with what is known of each. */

import {byId, element, exact, facts} from './dom.js';
import {bytes, coordinate, grouped} from './numbers.js';
import {ask} from './service.js';

/** Returns the facts of a file. */
function about(file) {
  const count = number => exact(number, grouped(number));
  const {counts, bounds} = file;
  const pixel = bounds ? Math.max(bounds[2] - bounds[0], bounds[3] - bounds[1]) / 10_000 || 1 : 1;
  const range = (from, to) => `${coordinate(from, pixel)} … ${coordinate(to, pixel)}`;
  return facts([
    ['Triangles', count(counts.triangles)],
    ['Vertices', count(counts.vertices)],
    ['Sites', count(counts.sites)],
    ['Heights', file.has_z ? 'yes' : 'no'],
    ['Reference system', file.crs?.summary ?? 'not named'],
    bounds && ['x', range(bounds[0], bounds[2])],
    bounds && ['y', range(bounds[1], bounds[3])],
    ['Overviews', count(counts.overviews)],
    ['Generation', count(file.generation)],
    ['Size', exact(file.bytes, bytes(file.bytes))],
  ]);
}

/** Shows the list of files. `choose` is called with the one that the visitor chooses. */
export class Files {
  constructor(ids, choose) {
    this.ids = ids;
    this.choose = choose;
    this.dialog = byId('files');
    byId('choose').addEventListener('click', () => this.open());
    byId('files-close').addEventListener('click', () => this.dialog.close());
    this.dialog.addEventListener('click', event => event.target === this.dialog && this.dialog.close());
  }

  /** Opens the list; the facts follow. */
  async open() {
    const items = this.ids.map(id => this.item(id));
    byId('file-list').replaceChildren(...items.map(item => item.element));
    this.dialog.showModal();
    await Promise.all(items.map(item => item.load()));
  }

  item(id) {
    const isCurrent = id === this.current;
    const show = () => {
      this.dialog.close();
      if (!isCurrent) this.choose(id);
    };
    const button = element('button', {type: 'button', class: 'quiet', onclick: show}, isCurrent ? 'Back to the map' : `Show ${id}`);
    const body = element('div', {}, element('p', {class: 'note'}, 'Loading …'));
    const item = element('li', {'aria-current': isCurrent ? 'true' : null}, element('h3', {}, id), body, button);
    const load = async () => {
      try {
        body.replaceChildren(about((await ask(id)).body));
      } catch (problem) {
        body.replaceChildren(element('p', {}, problem.message));
      }
    };
    return {element: item, load};
  }
}
