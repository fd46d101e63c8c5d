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
  bool supported = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                   __builtin_cpu_supports("bmi2");
#if CAIRN_CHECK_CPU >= 4
  supported = supported && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512vl");
#define CAIRN_CPU_NEEDS "AVX2, FMA, BMI and AVX-512, which this build needs (x86-64-v4)"
#else
#define CAIRN_CPU_NEEDS "AVX2, FMA and BMI, which this build needs (x86-64-v3)"
#endif
  if (supported) return;
  static const char kLine[] =
      "cairn: error: this CPU lacks one of " CAIRN_CPU_NEEDS "; build with -DCAIRN_ARCH=x86-64 for it\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kLine, sizeof(kLine) - 1);
  _exit(1);
}

}  // namespace
#endif
