#include "actors/sim/ode_library.h"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <string>

#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn::actors {
namespace {

std::string FormatMessage(const char* format, va_list arguments) {
  char text[512];
  std::vsnprintf(text, sizeof(text), format, arguments);
  return text;
}

// ODE aborts (dDebug) or exits (dError) as soon as its handler returns, so these two must not return.
void ThrowOdeError(int number, const char* format, va_list arguments) {
  ThrowError("ODE error {}: {}", number, FormatMessage(format, arguments));
}

void LogOdeMessage(int number, const char* format, va_list arguments) {
  log::Warning("ODE message {}: {}", number, FormatMessage(format, arguments));
}

void InitOnce() {
  if (!dCheckConfiguration("ODE_double_precision")) {
    ThrowError("ODE: libode is a single-precision build; Cairn needs double precision (Debian's libode8)");
  }
  dSetErrorHandler(ThrowOdeError);
  dSetDebugHandler(ThrowOdeError);
  dSetMessageHandler(LogOdeMessage);
  if (!dInitODE2(0)) ThrowError("ODE: dInitODE2 failed");
}

}  // namespace

void InitOde() {
  static std::once_flag once;
  std::call_once(once, InitOnce);
}

}  // namespace cairn::actors
