#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cairn {

/// One pixel, 8 bits a channel; grey images have three equal ones. `alpha` 255: opaque.
struct Pixel {
  uint8_t red = 0, green = 0, blue = 0, alpha = 255;
};

/// Takes an image row by row, so that the cells are all that is ever held.
class ImageSink {
 public:
  virtual ~ImageSink() = default;
  /// Called once with what the header says; throws to refuse it before anything is allocated.
  virtual void Begin(int64_t width, int64_t height, bool has_alpha) = 0;
  /// Row `y`, the top one is 0; `width` pixels.
  virtual void Row(int64_t y, const Pixel* pixels) = 0;
};

/// Reads a PGM file's bytes (P2 or P5, any maxval to 65535). Throws UsageError naming `file` and what is wrong.
void ReadPgm(std::string_view bytes, const std::string& file, ImageSink* sink);

/// Reads a PNG file's bytes: any colour type and depth, not interlaced. Throws UsageError naming `file` and what is
/// wrong, which with a torn file is at the latest its missing end.
void ReadPng(std::string_view bytes, const std::string& file, ImageSink* sink);

}  // namespace cairn
