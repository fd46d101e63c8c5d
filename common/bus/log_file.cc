#include "common/bus/log_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/core/check.h"

namespace cairn {
namespace {

// Of an event, all big-endian: sync word, number, time, length of channel and of data; then both.
constexpr uint32_t kSync = 0xEDA1DA01;
constexpr size_t kHeaderBytes = 28;
constexpr uint64_t kMaxChannel = 1000;  // as LCM's reader has it
constexpr uint64_t kMaxData = 64u << 20;

uint64_t Read(const uint8_t* at, int bytes) {
  uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = (value << 8) | at[i];
  return value;
}

}  // namespace

LogReader::LogReader(const std::string& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat info {};
  const bool opened = fd >= 0 && fstat(fd, &info) == 0;
  const int error = errno;
  void* mapped = nullptr;
  if (opened && S_ISREG(info.st_mode) && info.st_size > 0) {
    size_ = static_cast<size_t>(info.st_size);
    mapped = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
  }
  if (fd >= 0) close(fd);
  if (!opened) ThrowUsageError("log {}: {}", file, std::strerror(error));
  if (!S_ISREG(info.st_mode)) ThrowUsageError("log {}: it is not a file", file);
  if (mapped == MAP_FAILED) ThrowError("log {}: cannot be mapped: {}", file, std::strerror(errno));
  data_ = static_cast<const uint8_t*>(mapped);
  if (data_ != nullptr) madvise(mapped, size_, MADV_SEQUENTIAL);
}

LogReader::~LogReader() {
  if (data_ != nullptr) munmap(const_cast<uint8_t*>(data_), size_);
}

// Whether a whole message stands here: sane lengths, and behind it another one or the end.
bool LogReader::AtMessage(size_t at) const {
  if (size_ - at < kHeaderBytes || Read(data_ + at, 4) != kSync) return false;
  const uint64_t channel = Read(data_ + at + 20, 4), data = Read(data_ + at + 24, 4);
  if (channel == 0 || channel >= kMaxChannel || data > kMaxData) return false;
  const size_t left = size_ - at - kHeaderBytes;
  if (channel + data > left) return false;
  const size_t behind = at + kHeaderBytes + channel + data;
  return size_ - behind < 4 || Read(data_ + behind, 4) == kSync;
}

std::optional<LoggedMessage> LogReader::Next() {
  if (at_ < size_ && !AtMessage(at_)) {
    ++faults_;
    while (at_ < size_ && !AtMessage(at_)) {
      const void* next = at_ + 1 < size_ ? std::memchr(data_ + at_ + 1, kSync >> 24, size_ - at_ - 1) : nullptr;
      at_ = next == nullptr ? size_ : static_cast<size_t>(static_cast<const uint8_t*>(next) - data_);
    }
  }
  if (at_ >= size_) return std::nullopt;
  const uint8_t* event = data_ + at_;
  const uint64_t channel = Read(event + 20, 4), data = Read(event + 24, 4);
  const uint8_t* text = event + kHeaderBytes;
  LoggedMessage message{static_cast<int64_t>(Read(event + 12, 8)), std::string(text, text + channel),
                        Bytes(text + channel, text + channel + data)};
  at_ += kHeaderBytes + channel + data;
  return message;
}

}  // namespace cairn
