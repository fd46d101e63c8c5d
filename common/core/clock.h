#pragma once

#include <chrono>
#include <cstdint>

namespace cairn {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;
using Duration = Clock::duration;

/// Monotonic time in microseconds since an arbitrary origin; the same origin for all processes of one host.
int64_t MonotonicUs();

/// Wall-clock time (`utime` on the wire), microseconds since 1970.
int64_t WallUs();

/// Seconds since `start` on the monotonic clock.
double SecondsSince(TimePoint start);

}  // namespace cairn
