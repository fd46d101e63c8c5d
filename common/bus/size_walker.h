#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cairn {

/// Walks over the encoded fields of a message without allocating, to prove before the generated decode that the counts
/// in it agree with its length. Once something does not fit, everything after is a no-op and Done() is false.
class SizeWalker {
 public:
  explicit SizeWalker(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  void Skip(size_t n) {
    ok_ = ok_ && n <= bytes_.size() - at_;
    if (ok_) at_ += n;
  }

  /// A non-negative big-endian int32 that counts elements to come; at most the bytes that are left (each element has
  /// at least one), so products with element sizes cannot overflow.
  size_t Count() {
    const size_t start = at_;
    Skip(4);
    if (!ok_) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = (value << 8) | bytes_[start + i];
    ok_ = value <= bytes_.size() - at_;
    return ok_ ? value : 0;
  }

  void Array(size_t count, size_t element_bytes) { Skip(count * element_bytes); }

  /// A string: length with the final NUL, then the bytes, of which the last and no other must be NUL: one inside would
  /// come back from the decoder and make the encoder count wrong.
  void String() {
    const size_t length = Count();
    ok_ = ok_ && length >= 1;
    const size_t start = at_;
    Skip(length);
    if (!ok_) return;
    const std::span<const uint8_t> text = bytes_.subspan(start, length);
    ok_ = std::find(text.begin(), text.end(), 0) == text.end() - 1;
  }

  /// True when everything fitted and nothing is left over.
  bool Done() const { return ok_ && at_ == bytes_.size(); }

 private:
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace cairn
