/** The panel's controls: they show the state, and tell what the visitor changes. */

import {byId, element} from './dom.js';
import {layersOf} from './layers.js';

/** The slider of the radius goes from this part of the extent to this one. */
const LEAST = 1 / 2000;
const MOST = 1;
/** The number of steps of that slider. */
const STEPS = 200;

/** Returns the radius of a step of the slider, with three digits. */
function radiusAt(step, extent) {
  return Number((extent * LEAST * (MOST / LEAST) ** (step / STEPS)).toPrecision(3));
}

function stepAt(radius, extent) {
  return Math.round((Math.log(radius / (extent * LEAST)) / Math.log(MOST / LEAST)) * STEPS);
}

export class Controls {
  /** `change` is called with what the visitor changed, and whether more of it may follow at once. */
  constructor(change) {
    this.change = change;
    for (const name of ['ask', 'mode']) {
      for (const input of document.querySelectorAll(`input[name=${name}]`)) {
        input.addEventListener('change', () => change({[name]: input.value}));
      }
    }
    this.listen('k', 'change', input => ({k: Math.min(100, Math.max(1, Math.round(Number(input.value)) || 1))}));
    this.listen('radius', 'change', input => (Number(input.value) > 0 ? {radius: Number(input.value)} : null));
    this.listen('radius-slider', 'input', input => ({radius: radiusAt(Number(input.value), this.extent)}), true);
    this.listen('three', 'change', input => ({three: input.checked}));
    this.listen('height', 'input', input => ({height: Number((2 ** Number(input.value)).toPrecision(2))}), true);
  }

  listen(id, event, read, more = false) {
    const input = byId(id);
    input.addEventListener(event, () => {
      const changed = read(input);
      if (changed) this.change(changed, more);
    });
  }

  /** Shows the controls that a file has. */
  setFile(file, plane) {
    this.extent = plane.extent();
    const unit = file.unit.name === 'coordinate units' ? 'units' : file.unit.name;
    byId('radius-unit').textContent = unit;
    byId('three-section').hidden = !file.coloured_heights;
    const sites = document.querySelector('input[name=ask][value=sites]');
    sites.disabled = file.counts.sites === 0;
    sites.parentElement.title = sites.disabled ? 'This file has no sites' : '';
    const layer = ({name, title}) => {
      const input = element('input', {type: 'checkbox', role: 'switch', value: name});
      input.addEventListener('change', () => this.change({layers: this.layers()}));
      return element('label', {class: 'switch'}, input, element('span', {}, title));
    };
    byId('layers').replaceChildren(...layersOf(file).map(layer));
  }

  /** Returns the layers that are on. */
  layers() {
    return new Set([...byId('layers').querySelectorAll('input:checked')].map(input => input.value));
  }

  /** Shows a state. */
  show(state) {
    for (const name of ['ask', 'mode']) {
      document.querySelector(`input[name=${name}][value=${state[name]}]`).checked = true;
    }
    for (const part of document.querySelectorAll('[data-for]')) {
      part.hidden = !part.dataset.for.split(' ').includes(state.ask);
    }
    for (const input of byId('layers').querySelectorAll('input')) input.checked = state.layers.has(input.value);
    byId('k').value = state.k;
    byId('radius').value = state.radius;
    byId('radius-slider').value = stepAt(state.radius, this.extent);
    byId('three').checked = state.three;
    byId('three-options').hidden = !state.three;
    byId('height').value = Math.log2(state.height);
    byId('height-shown').textContent = state.height === 1 ? 'true to scale' : `× ${state.height}`;
  }
}
