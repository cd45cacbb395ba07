/** What the page shows, as the address holds it. */

export const ASKS = ['here', 'sites', 'reach', 'path'];

/** The names of the parameters that hold points. */
const POINTS = ['at', 'from', 'to'];
/** The parameters that hold numbers, and what they are if they are missing. */
const NUMBERS = {x: null, y: null, zoom: null, bearing: 0, pitch: null, k: 8, radius: null, height: 1};

/** Returns a point of a text `X,Y`; `null` if it is none. */
export function point(text) {
  const parts = (text ?? '').split(',').map(part => (part.trim() === '' ? NaN : Number(part)));
  return parts.length === 2 && parts.every(Number.isFinite) ? parts : null;
}

/** Returns the state of an address. Whatever is wrong in it is as if it were missing. */
export function parse(hash) {
  const found = new URLSearchParams(hash.replace(/^#/, ''));
  const state = {file: found.get('file'), three: found.get('three') === '1'};
  for (const name of POINTS) state[name] = point(found.get(name));
  for (const [name, missing] of Object.entries(NUMBERS)) {
    const text = found.get(name);
    const number = Number(text);
    state[name] = text !== null && text !== '' && Number.isFinite(number) ? number : missing;
  }
  state.k = Math.min(100, Math.max(1, Math.round(state.k)));
  if (!(state.radius > 0)) state.radius = null;
  state.height = Math.min(20, Math.max(0.5, state.height));
  const ask = found.get('ask');
  state.ask = ASKS.includes(ask) ? ask : 'here';
  state.mode = found.get('mode') === 'fast' ? 'fast' : 'exact';
  const layers = found.get('layers');
  state.layers = layers === null ? null : new Set(layers.split(',').filter(Boolean));
  return state;
}

/** Returns the address of a state. */
export function format(state) {
  const parts = [];
  const add = (name, value) => parts.push(`${name}=${value}`);
  add('file', state.file);
  for (const name of ['x', 'y', 'zoom']) if (state[name] !== null) add(name, state[name]);
  if (state.layers) add('layers', [...state.layers].join(','));
  add('ask', state.ask);
  for (const name of POINTS) if (state[name]) add(name, state[name].join(','));
  if (state.ask === 'sites') add('k', state.k);
  if (state.ask === 'reach' && state.radius) add('radius', state.radius);
  if (state.ask !== 'here') add('mode', state.mode);
  if (state.three) add('three', 1);
  if (state.three) for (const name of ['pitch', 'bearing', 'height']) add(name, state[name]);
  return `#${parts.join('&')}`;
}
