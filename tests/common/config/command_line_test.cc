#include "common/config/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/check.h"

namespace cairn {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CommandLineTest : public testing::Test {
 protected:
  CommandLineTest() {
    app_.require_subcommand(1);
    CLI::App* train = app_.add_subcommand("train", "");
    train->add_option("file", file_)->required();
    train->add_option("--set", overrides_)->allow_extra_args(false);
    train->add_option("--actors", actors_);
    app_.add_subcommand("plan", "");
  }

  std::string ErrorOf(const std::vector<const char*>& arguments) {
    std::vector<const char*> argv{"cairn"};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    try {
      ParseCommandLine(&app_, static_cast<int>(argv.size()), argv.data());
    } catch (const UsageError& error) {
      return error.what();
    }
    return "no error";
  }

  CLI::App app_{"test", "cairn"};
  std::string file_;
  std::vector<std::string> overrides_;
  int actors_ = 0;
};

TEST_F(CommandLineTest, RepeatedOptionsKeepTheirOrder) {
  EXPECT_EQ(ErrorOf({"train", "--set", "a=[64,64]", "f", "--set", "b=1", "--actors", "2"}), "no error");
  EXPECT_EQ(overrides_, (std::vector<std::string>{"a=[64,64]", "b=1"}));
  EXPECT_EQ(file_, "f");
}

TEST_F(CommandLineTest, UnknownOptionAndCommandComeWithTheNearest) {
  EXPECT_THAT(ErrorOf({"train", "f", "--actor", "2"}), AllOf(HasSubstr("--actor"), HasSubstr("one is --actors")));
  EXPECT_THAT(ErrorOf({"trian"}), AllOf(HasSubstr("trian"), HasSubstr("nearest known one is train")));
}

TEST_F(CommandLineTest, MissingAndWrongValuesAreNamed) {
  EXPECT_THAT(ErrorOf({"train"}), HasSubstr("file"));
  EXPECT_THAT(ErrorOf({"train", "f", "--actors", "two"}), HasSubstr("two"));
}

}  // namespace
}  // namespace cairn
