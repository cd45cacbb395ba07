/** The panel: at the side, or on a phone a sheet at the bottom that can be pulled down. */

import {byId} from './dom.js';

/** Up to this width, the panel is a sheet. */
const PHONE = matchMedia('(max-width: 640px)');
/** How far a finger must pull, in pixels. */
const PULL = 30;

export class Sheet {
  /** `moved` is called after the panel covers another part of the map. */
  constructor(moved) {
    this.panel = byId('panel');
    this.grip = byId('grip');
    this.moved = moved;
    let start = null;
    this.grip.addEventListener('click', () => this.toggle());
    this.grip.addEventListener('touchstart', event => (start = event.touches[0].clientY), {passive: true});
    // Otherwise a pull is a fling of the browser too, and Chromium ignores taps for a while after it.
    this.grip.addEventListener('touchmove', event => event.preventDefault(), {passive: false});
    this.grip.addEventListener('touchend', event => {
      const pulled = event.changedTouches[0].clientY - start;
      // A touch without a pull is a click, too.
      if (Math.abs(pulled) > PULL) this.toggle(pulled < 0);
    });
    PHONE.addEventListener('change', () => this.moved());
    addEventListener('resize', () => this.moved());
  }

  toggle(open = this.grip.getAttribute('aria-expanded') === 'false') {
    this.grip.setAttribute('aria-expanded', String(open));
    this.panel.classList.toggle('down', !open);
    byId('sheet').inert = !open;
    this.moved();
  }

  /** Opens the sheet on a phone, and shows an answer. */
  open(answer) {
    if (!PHONE.matches) return;
    if (this.panel.classList.contains('down')) this.toggle(true);
    answer.scrollIntoView({block: 'nearest'});
  }

  /** Returns the part of the map that the panel covers. */
  padding() {
    const none = {top: 0, right: 0, bottom: 0, left: 0};
    if (!PHONE.matches) return {...none, left: this.panel.getBoundingClientRect().right};
    const covered = this.panel.classList.contains('down') ? this.grip.offsetHeight : this.panel.offsetHeight;
    return {...none, bottom: covered};
  }
}
