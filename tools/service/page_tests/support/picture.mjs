// What a picture shows, in numbers.

// Differences of colours up to this, summed over red, green and blue, are not seen.
const NOT_SEEN = 24;

// Returns a page that has a function `pixels`, which decodes a PNG.
async function decoder(browser) {
  const page = await browser.blank;
  await page.evaluate(() => {
    window.pixels ??= async (base64) => {
      const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height);
    };
  });
  return page;
}

// Returns the mean luminance of a picture from 0 to 255, and how far its pixels are from it (standard deviation).
export async function luminance(browser, png) {
  const page = await decoder(browser);
  return page.evaluate(async (base64) => {
    const { data } = await window.pixels(base64);
    let sum = 0;
    let squares = 0;
    for (let at = 0; at < data.length; at += 4) {
      const grey = 0.2126 * data[at] + 0.7152 * data[at + 1] + 0.0722 * data[at + 2];
      sum += grey;
      squares += grey * grey;
    }
    const pixels = data.length / 4;
    const mean = sum / pixels;
    return { mean, deviation: Math.sqrt(Math.max(0, squares / pixels - mean * mean)) };
  }, png.toString('base64'));
}

// Returns the share of pixels in which two pictures of one size differ.
export async function difference(browser, one, other) {
  const page = await decoder(browser);
  return page.evaluate(async ({ pictures, notSeen }) => {
    const [{ data: one }, { data: other }] = await Promise.all(pictures.map(window.pixels));
    const channel = (at) => Math.abs(one[at] - other[at]);
    let differing = 0;
    for (let at = 0; at < one.length; at += 4) {
      if (channel(at) + channel(at + 1) + channel(at + 2) > notSeen) differing += 1;
    }
    return differing / (one.length / 4);
  }, { pictures: [one, other].map((png) => png.toString('base64')), notSeen: NOT_SEEN });
}
