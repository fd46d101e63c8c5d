#include "common/config/read_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "common/core/check.h"

namespace cairn::config {

std::string ReadFileToText(const char* what, const std::string& path) {
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  std::string text;
  char block[4096];
  while (file != nullptr) {
    const size_t got = std::fread(block, 1, sizeof(block), file.get());
    text.append(block, got);
    if (got < sizeof(block)) break;
  }
  if (file == nullptr || std::ferror(file.get()) != 0) {
    ThrowUsageError("{} {}: {}", what, path, std::strerror(errno));
  }
  return text;
}

}  // namespace cairn::config
