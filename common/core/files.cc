#include "common/core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "common/core/check.h"

namespace cairn {
namespace {

// 0 or the errno of what failed.
int Write(int fd, const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const ssize_t written = write(fd, text.data() + at, text.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written == 0 ? ENOSPC : errno;
    at += static_cast<size_t>(written);
  }
  return 0;
}

// 0 or the errno of what failed.
int SyncDirectory(const std::string& path) {
  const size_t slash = path.rfind('/');
  const std::string directory = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int fd = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return errno;
  const int error = fsync(fd) == 0 ? 0 : errno;
  close(fd);
  return error;
}

// A device, a pipe: nothing that another file could take the place of.
void WriteThrough(const std::string& path, const std::string& text) {
  const int fd = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) ThrowError("cannot write {}: {}", path, std::strerror(errno));
  const int error = Write(fd, text);
  close(fd);
  if (error != 0) ThrowError("cannot write {}: {}", path, std::strerror(error));
}

}  // namespace

void WriteFileAtomically(const std::string& name, const std::string& text) {
  std::error_code none;
  if (std::filesystem::exists(name, none) && !std::filesystem::is_regular_file(name, none) &&
      !std::filesystem::is_directory(name, none)) {
    return WriteThrough(name, text);
  }
  // The file that a link leads to is replaced, not the link.
  const bool is_link = std::filesystem::is_symlink(name, none) && std::filesystem::exists(name, none);
  const std::string path = is_link ? std::filesystem::canonical(name).string() : name;
  const std::string beside = path + ".tmp";
  const int fd = open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) ThrowError("cannot write {}: {}", path, std::strerror(errno));
  int error = Write(fd, text);
  if (error == 0 && fsync(fd) != 0) error = errno;
  if (close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    unlink(beside.c_str());
    ThrowError("cannot write {}: {}", path, std::strerror(error));
  }
  SyncDirectoryOf(path);
}

void SyncDirectoryOf(const std::string& path) {
  const int error = SyncDirectory(path);
  if (error != 0) ThrowError("cannot sync the directory of {}: {}", path, std::strerror(error));
}

std::string ReadFile(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) ThrowError("cannot read {}: {}", path, std::strerror(errno));
  std::string text;
  const off_t size = lseek(fd, 0, SEEK_END);
  text.reserve(size > 0 ? static_cast<size_t>(size) : 0);
  lseek(fd, 0, SEEK_SET);
  char block[1 << 16];
  ssize_t n = 0;
  while ((n = read(fd, block, sizeof(block))) > 0 || (n < 0 && errno == EINTR)) {
    if (n > 0) text.append(block, static_cast<size_t>(n));
  }
  const int error = n < 0 ? errno : 0;
  close(fd);
  if (error != 0) ThrowError("cannot read {}: {}", path, std::strerror(error));
  return text;
}

}  // namespace cairn
