#pragma once

#include <png.h>

#include <cstdint>
#include <string>
#include <vector>

namespace cairn {

/// An image to be written as PNG by libpng: `samples` row by row, of one or two bytes (most significant first).
struct PngImage {
  int width = 0, height = 0;
  int bit_depth = 8;
  int color_type = PNG_COLOR_TYPE_GRAY;
  std::vector<uint8_t> samples;
  bool interlaced = false;
};

inline std::string WritePng(const PngImage& image) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto write = [](png_structp p, png_bytep data, png_size_t size) {
    static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<const char*>(data), size);
  };
  png_set_write_fn(png, &bytes, write, [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
               image.bit_depth, image.color_type, image.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (image.color_type == PNG_COLOR_TYPE_PALETTE) {
    const png_color colors[3] = {{255, 255, 255}, {0, 0, 0}, {128, 128, 128}};
    png_set_PLTE(png, info, colors, 3);
  }
  png_write_info(png, info);
  const size_t row = image.samples.size() / static_cast<size_t>(image.height);
  std::vector<png_bytep> rows;
  for (int y = 0; y < image.height; ++y) rows.push_back(const_cast<png_bytep>(image.samples.data()) + row * y);
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace cairn
