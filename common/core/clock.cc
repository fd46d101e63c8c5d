#include "common/core/clock.h"

namespace cairn {

using std::chrono::duration_cast;
using std::chrono::microseconds;

int64_t MonotonicUs() { return duration_cast<microseconds>(Clock::now().time_since_epoch()).count(); }

int64_t WallUs() { return duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count(); }

double SecondsSince(TimePoint start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace cairn
