#include <charconv>
#include <vector>

#include "common/core/check.h"
#include "common/world/import/map_image.h"

namespace cairn {
namespace {

bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// Numbers and raw bytes of a PGM file; a '#' begins a comment that ends with its line.
class PgmReader {
 public:
  PgmReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  int64_t Number(const char* name, int64_t high) {
    SkipSpace();
    int64_t value = -1;
    const char* begin = bytes_.data() + at_;
    const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), value);
    if (at_ == bytes_.size()) ThrowUsageError("{}: torn: it ends where {} should stand", file_, name);
    if (error != std::errc() || value < 0 || value > high) {
      ThrowUsageError("{}: {} at byte {} is not a whole number from 0 to {}", file_, name, at_, high);
    }
    at_ += static_cast<size_t>(end - begin);
    return value;
  }

  // The one white-space character between the header and the bytes of P5.
  void EndHeader() {
    if (at_ >= bytes_.size() || !IsSpace(bytes_[at_])) {
      ThrowUsageError("{}: no white space after maxval, at byte {}", file_, at_);
    }
    ++at_;
  }

  void CheckLeft(double bytes, int64_t width, int64_t height) const {
    const size_t left = bytes_.size() - at_;
    if (static_cast<double>(left) >= bytes) return;
    ThrowUsageError("{}: torn: {} x {} pixels need at least {:.0f} bytes after the header, there are {}", file_, width,
                    height, bytes, left);
  }

  uint8_t Byte() { return static_cast<uint8_t>(bytes_[at_++]); }

 private:
  void SkipSpace() {
    while (at_ < bytes_.size() && (IsSpace(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_] == '#') at_ = std::min(bytes_.find('\n', at_), bytes_.size() - 1);
      ++at_;
    }
  }

  std::string_view bytes_;
  const std::string& file_;
  size_t at_ = 2;
};

}  // namespace

void ReadPgm(std::string_view bytes, const std::string& file, ImageSink* sink) {
  const std::string_view magic = bytes.substr(0, 2);
  if (magic != "P5" && magic != "P2") ThrowUsageError("{}: not a PGM image: it must begin with P5 or P2", file);
  const bool plain = magic == "P2";
  PgmReader reader(bytes, file);
  const int64_t width = reader.Number("width", INT32_MAX), height = reader.Number("height", INT32_MAX);
  const int64_t maxval = reader.Number("maxval", 65535);
  if (width == 0 || height == 0 || maxval == 0) {
    ThrowUsageError("{}: width {}, height {}, maxval {}: none may be 0", file, width, height, maxval);
  }
  if (!plain) reader.EndHeader();
  // A P2 pixel takes a digit and a space.
  const double pixel_bytes = plain || maxval > 255 ? 2 : 1;
  reader.CheckLeft(pixel_bytes * static_cast<double>(width) * static_cast<double>(height) - plain, width, height);
  sink->Begin(width, height, false);
  std::vector<Pixel> row(static_cast<size_t>(width));
  for (int64_t y = 0; y < height; ++y) {
    for (Pixel& pixel : row) {
      int64_t value = plain ? reader.Number("pixel", maxval) : reader.Byte();
      if (!plain && maxval > 255) value = value << 8 | reader.Byte();
      if (value > maxval) ThrowUsageError("{}: pixel {} in row {} exceeds maxval {}", file, value, y, maxval);
      const auto shade = static_cast<uint8_t>((value * 255 + maxval / 2) / maxval);
      pixel = {shade, shade, shade, 255};
    }
    sink->Row(y, row.data());
  }
}

}  // namespace cairn
