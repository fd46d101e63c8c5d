// LD_PRELOAD shim: caps the receive buffer at CAIRN_RMEM_MAX bytes, as net.core.rmem_max does for the whole machine.
#include <dlfcn.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

extern "C" int setsockopt(int fd, int level, int name, const void* value, socklen_t size) {
  using Real = int (*)(int, int, int, const void*, socklen_t);
  static const auto real = reinterpret_cast<Real>(dlsym(RTLD_NEXT, "setsockopt"));
  const char* limit = std::getenv("CAIRN_RMEM_MAX");
  if (limit == nullptr || level != SOL_SOCKET || name != SO_RCVBUF || size != sizeof(int)) {
    return real(fd, level, name, value, size);
  }
  int bytes = 0;
  std::memcpy(&bytes, value, sizeof(bytes));
  bytes = std::min(bytes, std::atoi(limit));
  return real(fd, level, name, &bytes, sizeof(bytes));
}
