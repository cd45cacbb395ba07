/** One message over the map. */

import {byId} from './dom.js';

/** How long a message stays that needs no answer, in milliseconds. */
const STAYS = 12_000;

let timer = 0;

/** Shows a message: for some time, or until it is replaced. */
export function notify(text, {stays = false} = {}) {
  clearTimeout(timer);
  byId('notice-text').textContent = text;
  byId('notice').hidden = false;
  if (!stays) timer = setTimeout(hide, STAYS);
}

function hide() {
  byId('notice').hidden = true;
}

byId('notice-close').addEventListener('click', hide);
