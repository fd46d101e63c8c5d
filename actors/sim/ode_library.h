#pragma once

namespace cairn::actors {

/// Starts ODE once per process (any thread, any number of times): checks that it was built in double precision, and
/// turns its errors into exceptions, since its own handlers end the process. Throws Error when the build does not fit.
void InitOde();

}  // namespace cairn::actors
