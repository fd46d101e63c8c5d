#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <vector>

#include "common/core/check.h"
#include "common/world/import/map_image.h"

namespace cairn {
namespace {

constexpr png_alloc_size_t kMaxChunk = 8 << 20;  // [B] of an inflated text or profile

// libpng reports errors by longjmp: each function below that calls it holds nothing with a destructor.
class PngReader {
 public:
  explicit PngReader(std::string_view bytes) : bytes_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, &Fail, &Ignore);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  bool ReadHeader() {
    if (info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, &Read);
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_chunk_malloc_max(png_, kMaxChunk);
    png_read_info(png_, info_);
    return true;
  }

  // Rows become 8-bit RGBA, whatever the file holds.
  bool StartRows() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_expand(png_);
    png_set_scale_16(png_);
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 255, PNG_FILLER_AFTER);
    png_read_update_info(png_, info_);
    return true;
  }

  bool ReadRow(uint8_t* row) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_row(png_, row, nullptr);
    return true;
  }

  bool ReadEnd() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_end(png_, nullptr);
    return true;
  }

  int64_t width() const { return png_get_image_width(png_, info_); }
  int64_t height() const { return png_get_image_height(png_, info_); }
  bool has_alpha() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_ALPHA) != 0 ||
           png_get_valid(png_, info_, PNG_INFO_tRNS) != 0;
  }
  bool interlaced() const { return png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE; }
  size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  const char* what() const { return what_; }

 private:
  [[noreturn]] static void Fail(png_structp png, png_const_charp message) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->what_, message, sizeof(reader->what_) - 1);
    png_longjmp(png, 1);
  }

  static void Ignore(png_structp, png_const_charp) {}

  static void Read(png_structp png, png_bytep to, png_size_t count) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->bytes_.size()) png_error(png, "torn: the file ends early");
    std::memcpy(to, reader->bytes_.data(), count);
    reader->bytes_.remove_prefix(count);
  }

  std::string_view bytes_;  // not read yet
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char what_[128] = "out of memory";
};

}  // namespace

void ReadPng(std::string_view bytes, const std::string& file, ImageSink* sink) {
  PngReader reader(bytes);
  const auto check = [&](bool good) {
    if (!good) ThrowUsageError("{}: not a sound PNG image: {}", file, reader.what());
  };
  check(reader.ReadHeader());
  if (reader.interlaced()) ThrowUsageError("{}: interlaced PNG images are not read; save it without interlacing", file);
  const int64_t width = reader.width(), height = reader.height();
  sink->Begin(width, height, reader.has_alpha());
  check(reader.StartRows());
  if (reader.row_bytes() != 4 * static_cast<size_t>(width)) ThrowUsageError("{}: not an RGBA row", file);
  std::vector<uint8_t> row(reader.row_bytes());
  std::vector<Pixel> pixels(static_cast<size_t>(width));
  for (int64_t y = 0; y < height; ++y) {
    check(reader.ReadRow(row.data()));
    for (size_t x = 0; x < pixels.size(); ++x) {
      pixels[x] = {row[4 * x], row[4 * x + 1], row[4 * x + 2], row[4 * x + 3]};
    }
    sink->Row(y, pixels.data());
  }
  check(reader.ReadEnd());
}

}  // namespace cairn
