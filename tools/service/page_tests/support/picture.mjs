// What a picture shows, in numbers.

// Returns the mean luminance of a picture from 0 to 255, and how far its pixels are from it (standard deviation): of all of
// it, or of a square of 16 pixels around a point.
export async function luminance(browser, png, around) {
  const page = await browser.blank;
  return page.evaluate(async ({ base64, around }) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = around
      ? context.getImageData(around[0] - 8, around[1] - 8, 16, 16)
      : context.getImageData(0, 0, image.width, image.height);
    let sum = 0, squares = 0;
    for (let at = 0; at < data.length; at += 4) {
      const grey = 0.2126 * data[at] + 0.7152 * data[at + 1] + 0.0722 * data[at + 2];
      sum += grey;
      squares += grey * grey;
    }
    const pixels = data.length / 4;
    const mean = sum / pixels;
    return { mean, deviation: Math.sqrt(Math.max(0, squares / pixels - mean * mean)) };
  }, { base64: png.toString('base64'), around });
}

// Returns the share of pixels in which two pictures of one size differ.
export async function difference(browser, one, other) {
  const page = await browser.blank;
  return page.evaluate(async (pictures) => {
    const [one, other] = await Promise.all(pictures.map(async (base64) => {
      const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height).data;
    }));
    let differing = 0;
    for (let at = 0; at < one.length; at += 4) {
      const distance = Math.abs(one[at] - other[at]) + Math.abs(one[at + 1] - other[at + 1]) + Math.abs(one[at + 2] - other[at + 2]);
      if (distance > 24) differing += 1;
    }
    return differing / (one.length / 4);
  }, [one.toString('base64'), other.toString('base64')]);
}
