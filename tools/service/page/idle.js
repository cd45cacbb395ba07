/** Whether the map and the query are at rest: `data-idle` of the page's main element. */

export class Idle {
  constructor(main) {
    this.main = main;
    this.tasks = new Set();
  }

  /** Begins something that is named. */
  begin(task) {
    this.tasks.add(task);
    this.show();
  }

  /** Ends something that is named. */
  end(task) {
    this.tasks.delete(task);
    this.show();
  }

  /** Watches a map: it is at rest when it has drawn all that it asked for. */
  watch(map) {
    this.begin('map');
    for (const event of ['movestart', 'dataloading', 'render', 'styledata']) map.on(event, () => this.begin('map'));
    map.on('idle', () => this.end('map'));
  }

  /** Shows work at once, and rest when the page has been painted. */
  show() {
    if (this.tasks.size > 0) this.main.dataset.idle = 'false';
    else requestAnimationFrame(() => requestAnimationFrame(() => (this.main.dataset.idle = String(this.tasks.size === 0))));
  }
}
