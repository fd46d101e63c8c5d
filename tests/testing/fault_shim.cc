// Preloaded into a process under test (LD_PRELOAD), makes file system calls of its checkpoint writer fail or be its
// last:
//   CAIRN_FAULT=kill:N     the process is killed (SIGKILL) before the N-th call, N = 1, 2, …
//   CAIRN_FAULT=eio:N:M    calls N … M fail with EIO, as those of a dying disk
//   CAIRN_FAULT=count:FILE the number of calls is appended to FILE at the end of the process
// Counted are open, write, fsync, rename, unlink, pwrite and close of paths that contain /checkpoints/ and of their
// descriptors.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

namespace {

std::atomic<int> calls{0};
std::atomic<bool> watched[4096];

struct Plan {
  enum { kNone, kKill, kEio, kCount } kind = kNone;
  int from = 0, to = 0;
  const char* file = "";
  Plan() {
    const char* text = getenv("CAIRN_FAULT");
    if (text == nullptr) return;
    if (sscanf(text, "kill:%d", &from) == 1) {
      kind = kKill;
    } else if (sscanf(text, "eio:%d:%d", &from, &to) == 2) {
      kind = kEio;
    } else if (strncmp(text, "count:", 6) == 0) {
      kind = kCount;
      file = text + 6;
    }
  }
  ~Plan() {
    if (kind != kCount) return;
    FILE* out = fopen(file, "a");
    if (out == nullptr) return;
    fprintf(out, "%d\n", calls.load());
    fclose(out);
  }
};

const Plan& plan() {
  static Plan plan;
  return plan;
}

// True when this call shall fail with EIO.
bool Fault() {
  const int call = ++calls;
  if (plan().kind == Plan::kKill && call == plan().from) raise(SIGKILL);
  return plan().kind == Plan::kEio && call >= plan().from && call <= plan().to;
}

bool IsCheckpoint(const char* path) { return path != nullptr && strstr(path, "/checkpoints") != nullptr; }
bool IsWatched(int fd) { return fd >= 0 && fd < 4096 && watched[fd]; }

template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

int Open(const char* name, const char* path, int flags, mode_t mode) {
  static const auto real = Next<int (*)(const char*, int, ...)>("open");
  const bool ours = IsCheckpoint(path) && strstr(path, "/progress") == nullptr;
  if (ours && Fault()) {
    errno = EIO;
    return -1;
  }
  static_cast<void>(name);
  const int fd = real(path, flags, mode);
  if (fd >= 0 && fd < 4096) watched[fd] = ours;
  return fd;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open("open64", path, flags, mode);
}

ssize_t write(int fd, const void* data, size_t size) {
  static const auto real = Next<ssize_t (*)(int, const void*, size_t)>("write");
  if (IsWatched(fd) && Fault()) {
    errno = EIO;
    return -1;
  }
  return real(fd, data, size);
}

int fsync(int fd) {
  static const auto real = Next<int (*)(int)>("fsync");
  if (IsWatched(fd) && Fault()) {
    errno = EIO;
    return -1;
  }
  return real(fd);
}

int close(int fd) {
  static const auto real = Next<int (*)(int)>("close");
  if (IsWatched(fd)) {
    watched[fd] = false;
    Fault();  // a close may be the last call; it does not fail here
  }
  return real(fd);
}

int rename(const char* from, const char* to) {
  static const auto real = Next<int (*)(const char*, const char*)>("rename");
  if (IsCheckpoint(to) && Fault()) {
    errno = EIO;
    return -1;
  }
  return real(from, to);
}

int unlink(const char* path) {
  static const auto real = Next<int (*)(const char*)>("unlink");
  if (IsCheckpoint(path) && Fault()) {
    errno = EIO;
    return -1;
  }
  return real(path);
}

int remove(const char* path) {
  static const auto real = Next<int (*)(const char*)>("remove");
  if (IsCheckpoint(path) && Fault()) {
    errno = EIO;
    return -1;
  }
  return real(path);
}

}  // extern "C"
