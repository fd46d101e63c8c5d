#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

constexpr const char* kEmulator = "/usr/bin/qemu-x86_64";

TEST(CpuCheckTest, CpuWithoutAvx2GetsOneClearLine) {
#ifdef __AVX2__
  if (access(kEmulator, X_OK) != 0) GTEST_SKIP() << "no qemu-x86_64 (package qemu-user) to stand for an old CPU";
  const ProgramResult result = RunProgram({kEmulator, "-cpu", "Nehalem", CAIRN_PROGRAM, "--version"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, testing::StartsWith("cairn: error: this CPU lacks one of AVX2"));
#else
  GTEST_SKIP() << "this build runs on any CPU";
#endif
}

}  // namespace
}  // namespace cairn::deploy
