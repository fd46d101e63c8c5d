#include "learner/checkpoint/progress_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

constexpr int kBytes = 20;  // always the same, so that a rewrite needs no new block

}  // namespace

ProgressFile::ProgressFile(const std::string& path) : fd_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (fd_ < 0) ThrowError("cannot open {}: {}", path, std::strerror(errno));
  if (flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  close(fd_);
  if (error == EWOULDBLOCK) ThrowUsageError("{}: another learner works in this run directory", path);
  ThrowError("cannot lock {}: {}", path, std::strerror(error));
}

ProgressFile::~ProgressFile() { close(fd_); }

int64_t ProgressFile::Read() const {
  char text[kBytes + 1] = {};
  if (pread(fd_, text, kBytes, 0) != kBytes) return 0;
  return std::strtoll(text, nullptr, 10);
}

void ProgressFile::Write(int64_t env_steps) {
  const std::string text = fmt::format("{:<{}}\n", env_steps, kBytes - 1);
  [[maybe_unused]] const ssize_t written = pwrite(fd_, text.data(), text.size(), 0);
}

}  // namespace cairn::learner
