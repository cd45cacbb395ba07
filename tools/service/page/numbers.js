/** Numbers for people, with units. */

/** The space between groups of three digits. */
const NARROW = '\u202f';

/** Formats a number with groups of digits. */
export function grouped(value, decimals = 0) {
  const [whole, part] = Math.abs(value).toFixed(decimals).split('.');
  const digits = whole.replace(/\B(?=(\d{3})+$)/g, NARROW);
  const isZero = Number(whole) === 0 && !Number(part);
  return `${value < 0 && !isZero ? '−' : ''}${digits}${part ? `.${part}` : ''}`;
}

/** Formats a number with about five digits. */
export function rounded(value) {
  const size = Math.abs(value);
  if (size === 0 || !Number.isFinite(value)) return String(value);
  if (size < 1e-5 || size >= 1e15) return value.toExponential(4);
  const decimals = Math.max(0, Math.min(8, 4 - Math.floor(Math.log10(size))));
  const text = grouped(value, size >= 1e4 ? 0 : decimals);
  return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
}

/** Returns the name of a unit after a number. */
function name(unit) {
  return unit.name === 'coordinate units' ? 'units' : unit.name;
}

/** Formats a distance with its unit. */
export function distance(value, unit) {
  if (unit.name === 'degrees') return `${rounded(value)}°`;
  if (unit.name === 'm' && Math.abs(value) >= 10_000) return `${rounded(value / 1000)}${NARROW}km`;
  return `${rounded(value)}${NARROW}${name(unit)}`;
}

/** Formats an area with its unit. */
export function area(value, unit) {
  if (unit.name === 'm' && value >= 1e6) return `${rounded(value / 1e6)}${NARROW}km²`;
  if (unit.metres) return `${rounded(value)}${NARROW}${unit.name}²`;
  return `${rounded(value)} square ${name(unit)}`;
}

/** Formats a coordinate with the decimals that a pixel of this length needs. */
export function coordinate(value, pixel) {
  return grouped(value, Math.min(9, Math.max(0, Math.ceil(-Math.log10(pixel)))));
}

/** Formats a count with its noun. */
export function counted(count, one, many = `${one}s`) {
  return `${grouped(count)} ${count === 1 ? one : many}`;
}

/** Formats a number of bytes. */
export function bytes(count) {
  const units = ['B', 'KiB', 'MiB', 'GiB', 'TiB'];
  const step = Math.min(units.length - 1, Math.floor(Math.log2(Math.max(1, count)) / 10));
  return `${grouped(count / 1024 ** step, step && count / 1024 ** step < 100 ? 1 : 0)}${NARROW}${units[step]}`;
}

/** Returns the largest of 1, 2, 5, 10, 20 … that is not larger than a number. */
export function round125(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const first = value / power;
  return (first >= 5 ? 5 : first >= 2 ? 2 : 1) * power;
}
