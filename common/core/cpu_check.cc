// Ends the program with one clear line when the CPU lacks the instructions this build uses.
//
// Compiled for plain x86-64 and run as the very first constructor, before any static initialiser that may hold newer
// instructions. Only functions of the C library are called: an inline C++ function could come from a file that was
// compiled for the newer instruction set.
#if defined(__x86_64__) && defined(CAIRN_CHECK_CPU)

#include <unistd.h>

namespace {

[[gnu::constructor(101)]] void CheckCpu() {
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                  __builtin_cpu_supports("bmi2");
  if (v3) return;
  static const char kLine[] =
      "cairn: error: this CPU has no AVX2/FMA/BMI2, but this build needs them (x86-64-v3); "
      "build with -DCAIRN_ARCH=x86-64 on this machine\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kLine, sizeof(kLine) - 1);
  _exit(1);
}

}  // namespace
#endif
