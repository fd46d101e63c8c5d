#include "common/bus/key_file.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/core/check.h"
#include "common/core/files.h"

namespace cairn {
namespace {

constexpr size_t kHexDigits = 2 * sizeof(RunKey);
constexpr size_t kFileBytes = kHexDigits + 1;  // and the newline

class File {
 public:
  File(const std::string& path, int flags) : fd_(open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

std::string ToHex(const RunKey& key) {
  std::string digits(kHexDigits + 1, '\0');  // sodium_bin2hex ends it with a NUL
  sodium_bin2hex(digits.data(), digits.size(), key.data(), key.size());
  digits.back() = '\n';
  return digits;
}

void CheckMode(const std::string& path, const struct stat& info) {
  if (!S_ISREG(info.st_mode)) ThrowUsageError("key file {}: it must be a regular file", path);
  if ((info.st_mode & 077) == 0) return;
  ThrowUsageError("key file {}: mode {:04o}; group and others must have no access: chmod 600 {}", path,
                  static_cast<unsigned>(info.st_mode & 07777), path);
}

// More is asked for than a key has, so that a file that is too long shows.
std::string ReadText(const std::string& path, int fd) {
  char text[kFileBytes + 1];
  const ssize_t size = read(fd, text, sizeof text);
  if (size < 0) ThrowUsageError("key file {}: {}", path, std::strerror(errno));
  return {text, static_cast<size_t>(size)};
}

}  // namespace

void RequireKeyedFrames() {
  CAIRN_CHECK(sodium_init() >= 0);
  if (crypto_aead_aes256gcm_is_available() == 1) return;
  ThrowUsageError(
      "a key needs a processor with AES instructions (aes, pclmulqdq), which this one lacks; without a key: "
      "--insecure");
}

RunKey CreateKeyFile(const std::string& path) {
  RequireKeyedFrames();
  RunKey key;
  randombytes_buf(key.data(), key.size());
  const std::string text = ToHex(key);
  const File file(path, O_WRONLY | O_CREAT | O_EXCL);
  if (file.fd() < 0) ThrowError("cannot make the key file {}: {}", path, std::strerror(errno));
  errno = ENOSPC;  // what a short write means
  // An inherited umask may have taken more than group's and others' bits.
  const bool written = fchmod(file.fd(), 0600) == 0 &&
                       write(file.fd(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
                       fsync(file.fd()) == 0;
  if (!written) {
    const int error = errno;
    unlink(path.c_str());
    ThrowError("cannot write the key file {}: {}", path, std::strerror(error));
  }
  SyncDirectoryOf(path);
  return key;
}

RunKey ReadKeyFile(const std::string& path) {
  RequireKeyedFrames();
  // Not blocking: a FIFO of that name must not hang the process.
  const File file(path, O_RDONLY | O_NONBLOCK);
  if (file.fd() < 0) ThrowUsageError("key file {}: {}", path, std::strerror(errno));
  struct stat info {};
  if (fstat(file.fd(), &info) != 0) ThrowUsageError("key file {}: {}", path, std::strerror(errno));
  CheckMode(path, info);
  const std::string text = ReadText(path, file.fd());
  constexpr const char* kRule = "it must hold 64 hexadecimal digits and a newline";
  if (text.size() != kFileBytes) ThrowUsageError("key file {}: {} bytes; {}", path, info.st_size, kRule);
  const size_t digits = text.find_first_not_of("0123456789abcdefABCDEF");
  if (digits != kHexDigits || text.back() != '\n') {
    ThrowUsageError("key file {}: byte {} is wrong; {}", path, std::min(digits, kHexDigits) + 1, kRule);
  }
  RunKey key;
  sodium_hex2bin(key.data(), key.size(), text.data(), kHexDigits, nullptr, nullptr, nullptr);
  return key;
}

}  // namespace cairn
