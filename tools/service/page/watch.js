/** Whether the server answers, and whether the file is still the same. */

import {ask} from './service.js';

/** How often the file is looked at, in milliseconds. */
const EVERY = 3000;

export class Watch {
  /** `tell` has functions for what is seen: `changed`, `gone` and `back`. */
  constructor(tell) {
    this.tell = tell;
    this.isGone = false;
    setInterval(() => document.visibilityState === 'visible' && this.look(), EVERY);
    document.addEventListener('visibilitychange', () => document.visibilityState === 'visible' && this.look());
  }

  /** Watches a file in the state that is known. */
  follow(file) {
    this.file = file;
  }

  /** Looks at the file now. */
  async look() {
    if (!this.file || this.isLooking) return;
    this.isLooking = true;
    const {id, version} = this.file;
    try {
      const {body} = await ask(id);
      if (this.isGone) this.tell.back();
      this.isGone = false;
      if (id === this.file.id && body.version !== version && body.version !== this.file.version) await this.tell.changed();
    } catch (problem) {
      if (!this.isGone) this.tell.gone(problem);
      this.isGone = true;
    } finally {
      this.isLooking = false;
    }
  }
}
