// Preloaded into processes under test (LD_PRELOAD), makes their wall clock jump: what clock_gettime (the realtime
// clocks), gettimeofday and time tell is right at first, then an hour ahead, then an hour behind, and so on, changing
// after CAIRN_CLOCK_JUMP_CALLS looks at it (default 100; each process starts elsewhere in this cycle, so that they jump
// at different moments). Monotonic clocks stay as they are, as they do when somebody sets a host's clock. Each jump
// appends a line "program offset" to the file CAIRN_CLOCK_JUMP_LOG.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>

namespace {

constexpr long kHour = 3600;
constexpr long kOffsets[] = {0, kHour, -kHour};

// Other functions of the C library must not be met here with a jump of their own.
void Note(long offset) {
  const char* name = getenv("CAIRN_CLOCK_JUMP_LOG");
  if (name == nullptr) return;
  const int fd = open(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return;
  char line[128];
  const int size = snprintf(line, sizeof line, "%s %ld\n", program_invocation_short_name, offset);
  const ssize_t written = write(fd, line, static_cast<size_t>(size));
  static_cast<void>(written);
  close(fd);
}

long CallsBetweenJumps() {
  const char* text = getenv("CAIRN_CLOCK_JUMP_CALLS");
  const long calls = text == nullptr ? 0 : atol(text);
  return calls > 0 ? calls : 100;
}

// Offset of this look at the wall clock [s].
long NextOffset() {
  static const long between = CallsBetweenJumps();
  static std::atomic<long> calls{getpid() % between};
  const long call = ++calls;
  const long offset = kOffsets[call / between % 3];
  if (call % between == 0) Note(offset);
  return offset;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  static const auto real = reinterpret_cast<int (*)(clockid_t, timespec*)>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int status = real(clock, now);
  const bool wall = clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
  if (status == 0 && wall) now->tv_sec += NextOffset();
  return status;
}

int gettimeofday(timeval* now, void* zone) noexcept {
  static const auto real = reinterpret_cast<int (*)(timeval*, void*)>(dlsym(RTLD_NEXT, "gettimeofday"));
  const int status = real(now, zone);
  if (status == 0) now->tv_sec += NextOffset();
  return status;
}

time_t time(time_t* out) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (out != nullptr) *out = now.tv_sec;
  return now.tv_sec;
}

}  // extern "C"
