#include "learner/metrics/log_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn::learner {
namespace {

constexpr size_t kFlushBytes = 1 << 16;
constexpr size_t kMaxPending = 1 << 26;
constexpr double kFlushInterval = 1.0;  // s

}  // namespace

LogFile::LogFile(const std::string& path, bool append)
    : path_(path),
      fd_(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (append ? 0 : O_TRUNC), 0644)),
      last_flush_(Clock::now()) {
  if (fd_ < 0) Fail("create");
  if (append) size_ = ::lseek(fd_, 0, SEEK_END);
}

LogFile::~LogFile() {
  try {
    Flush();
  } catch (const Error& error) {
    log::Warning("{}", error.what());
  }
  ::close(fd_);
}

void LogFile::Append(std::string_view record) {
  if (pending_.size() > kMaxPending) Fail("keep more records while it cannot be written");
  pending_ += record;
  if (pending_.size() >= kFlushBytes || SecondsSince(last_flush_) >= kFlushInterval) Flush();
}

void LogFile::Flush() {
  last_flush_ = Clock::now();
  if (torn_ && (::ftruncate(fd_, size_) != 0 || ::lseek(fd_, size_, SEEK_SET) != size_)) Fail("cut back");
  torn_ = false;
  for (size_t done = 0; done < pending_.size();) {
    const ssize_t n = ::write(fd_, pending_.data() + done, pending_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      torn_ = done > 0;
      Fail("write");
    }
    done += static_cast<size_t>(n);
  }
  size_ += static_cast<int64_t>(pending_.size());
  pending_.clear();
}

void LogFile::Fail(const char* what) const { ThrowError("{}: cannot {}: {}", path_, what, std::strerror(errno)); }

}  // namespace cairn::learner
