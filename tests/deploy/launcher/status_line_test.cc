#include "deploy/launcher/status_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

RunStatus Halfway() { return {125000, 250000, 12345.4, 1234.5, 0.985, 40000, "training"}; }

class StatusLineTest : public testing::Test {
 protected:
  StatusLineTest() : file_(std::fopen((directory_ / "out").c_str(), "w+")) {}
  ~StatusLineTest() override { std::fclose(file_); }

  std::string Written() {
    std::fflush(file_);
    return ReadText(directory_ / "out");
  }

  TemporaryDirectory directory_;
  FILE* file_;
};

TEST_F(StatusLineTest, LineTellsAll) {
  EXPECT_EQ(FormatStatus(Halfway()),
            "training  125,000 / 250,000  50 %  12,345 steps/s  1,235 updates/s  success 98.5 %  consumption 40,000"
            "  ETA 0:11");
}

TEST_F(StatusLineTest, WhatIsNotKnownYetIsADash) {
  RunStatus status;
  status.phase = "starting";
  status.total_env_steps = 1000;
  EXPECT_EQ(FormatStatus(status), "starting  0 / 1,000  0 %  0 steps/s  0 updates/s  success -  consumption -  ETA -");
}

TEST_F(StatusLineTest, LongEtaHasHoursAndAFinishedRunNone) {
  RunStatus status = Halfway();
  status.env_steps_per_s = 10;
  EXPECT_THAT(FormatStatus(status), testing::HasSubstr("ETA 3:28:20"));
  status.env_steps = status.total_env_steps;
  EXPECT_THAT(FormatStatus(status), testing::Not(testing::HasSubstr("ETA")));
}

TEST_F(StatusLineTest, PipeGetsWholeLinesFirstAndLast) {
  RunStatus status = Halfway();
  {
    StatusLine line(file_, StatusLine::Mode::kPlain, std::chrono::hours(1));
    line.Update(status);
    status.env_steps = 126000;
    line.Update(status);  // within the period: held back
    status.env_steps = 250000;
    line.Update(status);
    EXPECT_EQ(Written(), FormatStatus(Halfway()) + "\n");
  }
  EXPECT_EQ(Written(), FormatStatus(Halfway()) + "\n" + FormatStatus(status) + "\n");
}

TEST_F(StatusLineTest, TerminalLineIsRewrittenInPlaceAndNotesStayAboveIt) {
  StatusLine line(file_, StatusLine::Mode::kTerminal);
  line.Update(Halfway());
  const std::string shown = FormatStatus(Halfway()).substr(0, 79);
  EXPECT_EQ(Written(), "\r\x1b[K" + shown);
  line.Note("actor-1 died");
  EXPECT_EQ(Written(), "\r\x1b[K" + shown + "\r\x1b[Kactor-1 died\n\r\x1b[K" + shown);
  line.Finish();
  EXPECT_EQ(Written(), "\r\x1b[K" + shown + "\r\x1b[Kactor-1 died\n\r\x1b[K" + shown + "\r\x1b[K" +
                           FormatStatus(Halfway()) + "\n");
  line.Note("done");
  EXPECT_THAT(Written(), testing::EndsWith(FormatStatus(Halfway()) + "\ndone\n"));
}

TEST_F(StatusLineTest, QuietWritesNothing) {
  {
    StatusLine line(file_, StatusLine::Mode::kQuiet);
    line.Update(Halfway());
    line.Note("note");
  }
  EXPECT_EQ(Written(), "");
}

TEST_F(StatusLineTest, AReaderThatGoesAwayEndsTheLineAndNothingElse) {
  std::signal(SIGPIPE, SIG_IGN);
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  FILE* out = fdopen(ends[1], "w");
  StatusLine line(out, StatusLine::Mode::kPlain, Duration::zero());
  line.Note("heard");
  close(ends[0]);
  line.Note("not heard");
  line.Update(Halfway());
  line.Finish();
  EXPECT_EQ(std::ferror(out), 0);
  std::fclose(out);
  std::signal(SIGPIPE, SIG_DFL);
}

TEST_F(StatusLineTest, ModeFollowsTheFile) {
  EXPECT_EQ(StatusLine::ModeFor(file_, false), StatusLine::Mode::kPlain);
  EXPECT_EQ(StatusLine::ModeFor(file_, true), StatusLine::Mode::kQuiet);
}

}  // namespace
}  // namespace cairn::deploy
