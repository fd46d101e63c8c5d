#include "common/core/version.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(VersionTest, RevisionIsTwelveDigitsOrUnknown) {
  EXPECT_THAT(GitRevision(), testing::MatchesRegex("([0-9a-f]{12}(-dirty)?|unknown)"));
}

TEST(VersionTest, ProjectVersionHasThreeParts) {
  EXPECT_THAT(ProjectVersion(), testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
}

}  // namespace
}  // namespace cairn
