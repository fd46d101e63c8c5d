#include "deploy/doctor/host_checks.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "common/bus/key_file.h"
#include "common/bus/receive_buffer.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/nn/gemm.h"
#include "deploy/launcher/cpus.h"

namespace cairn::deploy {
namespace {

std::string FirstLine(const std::string& path, const std::string& otherwise) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) ? line : otherwise;
}

// Cost of a reading [ns]: of the fastest batch, since a busy machine may take us off the processor in any of them.
double ClockReadingNs() {
  constexpr int kBatches = 20;
  constexpr int kReadings = 1000;
  double fastest = 1.0;
  for (int batch = 0; batch < kBatches; ++batch) {
    const TimePoint start = Clock::now();
    for (int i = 0; i < kReadings; ++i) Clock::now();
    fastest = std::min(fastest, SecondsSince(start));
  }
  return 1e9 * fastest / kReadings;
}

// Writes a file of `bytes` and removes it; 0 or errno.
int TryToWrite(const std::string& directory, size_t bytes) {
  std::string name = directory + "/.cairn-doctor-XXXXXX";
  const int fd = mkostemp(name.data(), O_CLOEXEC);
  if (fd < 0) return errno;
  unlink(name.c_str());
  const std::string block(bytes, '\0');
  errno = ENOSPC;  // what a short write means
  const bool written = write(fd, block.data(), block.size()) == static_cast<ssize_t>(block.size()) && fsync(fd) == 0;
  const int error = errno;
  close(fd);
  return written ? 0 : error;
}

std::string Megabytes(uint64_t bytes) { return fmt::format("{} MB", bytes >> 20); }

}  // namespace

Finding CheckReceiveBuffer() {
  const int given = EffectiveReceiveBuffer();
  const std::string limit = FirstLine("/proc/sys/net/core/rmem_max", "unknown");
  const std::string seen = fmt::format("{} of {} bytes (net.core.rmem_max = {})", given, kWantedReceiveBuffer, limit);
  if (given >= kWantedReceiveBuffer) return Ok("receive buffer", seen);
  return Warn("receive buffer", "the kernel gives " + seen + ", so that more is lost and sent again",
              "sudo sysctl -w net.core.rmem_max=4194304 (to keep it: echo net.core.rmem_max=4194304 | sudo tee "
              "/etc/sysctl.d/60-cairn.conf)");
}

Finding CheckClock() {
  const std::string source =
      FirstLine("/sys/devices/system/clocksource/clocksource0/current_clocksource", "unknown source");
  const double ns = ClockReadingNs();
  timex state{};
  const bool synchronised = adjtimex(&state) != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
  const std::string seen = fmt::format("{}, {:.0f} ns a reading, wall clock {}", source, ns,
                                       synchronised ? "synchronised" : "free running (only time stamps show it)");
  constexpr int64_t kUs2020 = 1577836800LL * 1000000;
  if (WallUs() < kUs2020) return Warn("clock", seen + ", before 2020", "set it: sudo timedatectl set-ntp true");
  if (ns <= 1000) return Ok("clock", seen);
  return Warn("clock", seen + ": slow", "boot with a faster one (kernel option clocksource=tsc)");
}

Finding CheckCpu(const Subject& subject) {
  const std::string target = GemmTarget();
  const std::string seen = fmt::format("{} for this process, matrix kernels '{}'", AvailableCpus(), target);
  if (subject.transport.leaves_host() && !subject.insecure) {
    try {
      RequireKeyedFrames();
    } catch (const Error& error) {
      return Fail("cpu", seen + "; " + error.what(),
                  "another host; in a virtual machine pass aes and pclmulqdq through");
    }
  }
  if (target != "loop") return Ok("cpu", seen);
  return Warn("cpu", seen + ": plain loops, many times slower", "build with libxsmm on an x86-64 processor with AVX2");
}

Finding CheckDisk(const Subject& subject) {
  constexpr size_t kTried = 1 << 20;
  struct statvfs info {};
  if (statvfs(subject.disk.c_str(), &info) != 0) {
    return Fail("disk", fmt::format("{}: {}", subject.disk, std::strerror(errno)), "another --run-dir");
  }
  const uint64_t free = static_cast<uint64_t>(info.f_bavail) * info.f_frsize;
  const auto needed = static_cast<uint64_t>(subject.disk_bytes);
  const std::string seen = fmt::format("{} free in {}; a run of this size writes up to {}", Megabytes(free),
                                       subject.disk, Megabytes(needed));
  const std::string cure = fmt::format("free {} there, or take a --run-dir on another disk", Megabytes(needed));
  if (const int error = TryToWrite(subject.disk, kTried); error != 0) {
    const std::string why =
        fmt::format("cannot write to {}: {} ({} free)", subject.disk, std::strerror(error), Megabytes(free));
    return Fail("disk", why, error == ENOSPC || error == EDQUOT ? cure : "a --run-dir that this user may write to");
  }
  // Most of a run that is under way is written already.
  if (free < needed && subject.live_pid == 0) return Fail("disk", seen, cure);
  return Ok("disk", seen);
}

}  // namespace cairn::deploy
