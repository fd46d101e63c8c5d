#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace cairn {

/// Fixed number of zero-initialised scalars on 64-byte (cache-line) boundaries.
template <typename Scalar>
class AlignedBuffer {
 public:
  AlignedBuffer() = default;
  explicit AlignedBuffer(size_t size)
      : size_(size), data_(static_cast<Scalar*>(::operator new (size * sizeof(Scalar), std::align_val_t{64}))) {
    if (size > 0) std::memset(data_.get(), 0, size * sizeof(Scalar));
  }

  Scalar* data() { return data_.get(); }
  const Scalar* data() const { return data_.get(); }
  size_t size() const { return size_; }
  Scalar& operator[](size_t i) { return data_[i]; }
  const Scalar& operator[](size_t i) const { return data_[i]; }
  Scalar* begin() { return data(); }
  Scalar* end() { return data() + size_; }
  const Scalar* begin() const { return data(); }
  const Scalar* end() const { return data() + size_; }

 private:
  struct Free {
    void operator()(Scalar* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  size_t size_ = 0;
  std::unique_ptr<Scalar[], Free> data_;
};

}  // namespace cairn
