// A field as a colour map over time (to the right) and space (upwards).

class FieldMap {
  constructor(field, colours) {
    Object.assign(this, { field, colours, bitmap: null, key: "" });
    this.words = Uint32Array.from(colours.palette, ([r, g, b]) => 0xff000000 | (b << 16) | (g << 8) | r);
  }

  draw(chart, context) {
    const { left, top, width, height } = chart.box;
    const key = [width, height, ...chart.shown("x"), ...chart.shown("y")].join();
    if (key !== this.key) {
      this.bitmap = this.paint(Math.round(width), Math.round(height), chart.shown("x"), chart.shown("y"));
      this.key = key;
    }
    context.drawImage(this.bitmap, left, top, width, height);
  }

  paint(width, height, [begin, end], [bottom, top]) {
    const { field, colours, words } = this, nodes = field.x.length;
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = height;
    const context = canvas.getContext("2d"), image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const places = Array.from({ length: height }, (_, j) =>
      Field.locate(field.x, top + ((bottom - top) * (j + 0.5)) / height));
    for (let i = 0; i < width; ++i) {
      const profile = field.profile(begin + ((end - begin) * (i + 0.5)) / width);
      for (let j = 0; j < height; ++j) {
        const [node, part] = places[j];
        pixels[j * width + i] = words[colours.index(Field.between(profile, node, part))];
      }
    }
    context.putImageData(image, 0, 0);
    return canvas;
  }
}
