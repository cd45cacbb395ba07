/** Elements of the page. */

/** Returns the element of an id. */
export function byId(id) {
  return document.getElementById(id);
}

/** Creates an element with attributes and children; texts are never read as markup. */
export function element(name, attributes = {}, ...children) {
  const created = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'onclick') created.addEventListener('click', value);
    else if (value === true) created.setAttribute(key, '');
    else if (value !== false && value != null) created.setAttribute(key, value);
  }
  created.append(...children.filter(child => child != null));
  return created;
}

/** Creates an element that shows a number and has all of its digits in `value`. `name` is its key in the answer. */
export function exact(value, text, name = null) {
  return element('data', {value: String(value), 'data-name': name}, text);
}

/** Creates a list of names and values. */
export function facts(rows) {
  const parts = rows.filter(Boolean).flatMap(([name, ...values]) => [
    element('dt', {}, name),
    ...values.map(value => element('dd', {}, value)),
  ]);
  return element('dl', {class: 'facts'}, ...parts);
}
