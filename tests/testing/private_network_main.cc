// The main of tests that talk over LCM: it moves the process into a private network first, so that the traffic of a
// test meets nothing else on the machine, other tests included.
#include <gtest/gtest.h>

#include <cstdio>

#include "common/core/check.h"
#include "deploy/launcher/network.h"

int main(int argc, char** argv) {
  constexpr int kSkipped = 77;  // SKIP_RETURN_CODE in CMake
  ::testing::InitGoogleTest(&argc, argv);
  if (!::testing::GTEST_FLAG(list_tests)) {
    try {
      cairn::deploy::EnterPrivateNetwork("239.255.76.67");
    } catch (const cairn::Error& error) {
      if (!cairn::deploy::HasMulticastRoute("239.255.76.67")) {
        std::printf("skipped: no private network (%s) and no multicast route\n", error.what());
        return kSkipped;
      }
    }
  }
  return RUN_ALL_TESTS();
}
