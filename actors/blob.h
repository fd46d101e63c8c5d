#pragma once

#include <cstring>
#include <string>
#include <type_traits>

#include "common/core/check.h"

namespace cairn::actors {

/// Appends the bytes of plain values to an opaque string: exact states for Save and Load on the same kind of machine.
class BlobWriter {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void PutBytes(const std::string& bytes) {
    Put(static_cast<uint64_t>(bytes.size()));
    bytes_ += bytes;
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads back what BlobWriter wrote, in the same order. Throws Error when the blob is too short or has bytes left.
class BlobReader {
 public:
  /// `blob` must outlive the reader.
  explicit BlobReader(const std::string& blob) : bytes_(blob) {}

  template <typename T>
  void Get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Need(sizeof(T));
    std::memcpy(static_cast<void*>(&value), bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
  }
  std::string GetBytes() {
    uint64_t size = 0;
    Get(size);
    Need(size);
    position_ += size;
    return bytes_.substr(position_ - size, size);
  }
  void Finish() const {
    if (position_ != bytes_.size()) {
      ThrowError("environment blob: {} bytes left over after {}", bytes_.size() - position_, position_);
    }
  }

 private:
  void Need(uint64_t size) const {
    if (size > bytes_.size() - position_) {
      ThrowError("environment blob: ends after {} of at least {} bytes", bytes_.size(), position_ + size);
    }
  }

  const std::string& bytes_;
  size_t position_ = 0;
};

}  // namespace cairn::actors
