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

constexpr int kBytes = 60;  // always the same, so that a rewrite needs no new block

}  // namespace

ProgressFile::ProgressFile(const std::string& path) : fd_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (fd_ < 0) ThrowError("cannot open {}: {}", path, std::strerror(errno));
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    const int error = errno;
    close(fd_);
    if (error == EWOULDBLOCK) ThrowUsageError("{}: another learner works in this run directory", path);
    ThrowError("cannot lock {}: {}", path, std::strerror(error));
  }
  char text[kBytes + 1] = {};
  if (pread(fd_, text, kBytes, 0) == kBytes) {
    char* end = nullptr;
    env_steps_before_ = std::strtoll(text, &end, 10);
    rolled_back_before_ = std::strtoll(end, &end, 10);
    incarnation_ = std::strtoll(end, nullptr, 10) + 1;
  }
  if (TryWrite(env_steps_before_, rolled_back_before_) && fdatasync(fd_) == 0) return;
  const int error = errno;
  close(fd_);
  ThrowError("cannot write {}: {}", path, std::strerror(error));
}

ProgressFile::~ProgressFile() { close(fd_); }

bool ProgressFile::TryWrite(int64_t env_steps, int64_t rolled_back) {
  const std::string text = fmt::format("{:<19} {:<19} {:<19}\n", env_steps, rolled_back, incarnation_);
  return pwrite(fd_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
}

void ProgressFile::Write(int64_t env_steps, int64_t rolled_back) { TryWrite(env_steps, rolled_back); }

}  // namespace cairn::learner
