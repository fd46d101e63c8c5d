#include "common/bus/key_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/check.h"
#include "common/core/files.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class KeyFileTest : public testing::Test {
 protected:
  KeyFileTest() {
    std::string name = (fs::temp_directory_path() / "cairn-key-XXXXXX").string();
    CAIRN_CHECK(mkdtemp(name.data()) != nullptr);
    directory_ = name;
    path_ = name + "/key";
  }
  ~KeyFileTest() override { fs::remove_all(directory_); }

  void WriteKey(const std::string& text, mode_t mode = 0600) {
    std::ofstream(path_) << text;
    chmod(path_.c_str(), mode);
  }

  std::string ReadFailure() {
    try {
      ReadKeyFile(path_);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path directory_;
  std::string path_;
};

TEST_F(KeyFileTest, NewKeyIsPrivateHexadecimalAndReadsBack) {
  const mode_t before = umask(0);
  const RunKey key = CreateKeyFile(path_);
  umask(before);
  struct stat info {};
  ASSERT_EQ(stat(path_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0600u);
  EXPECT_THAT(ReadFile(path_), testing::ContainsRegex("^[0-9a-f]{64}\n$"));
  EXPECT_EQ(ReadKeyFile(path_), key);
}

TEST_F(KeyFileTest, TwoKeysDiffer) { EXPECT_NE(CreateKeyFile(path_), CreateKeyFile(path_ + "2")); }

TEST_F(KeyFileTest, ExistingFileIsNeverOverwritten) {
  WriteKey("precious");
  EXPECT_THROW(CreateKeyFile(path_), Error);
  EXPECT_EQ(ReadFile(path_), "precious");
  EXPECT_THROW(CreateKeyFile(path_ + "/none"), Error);
}

TEST_F(KeyFileTest, DigitsMayBeUpperCase) {
  WriteKey(std::string(64, 'A') + "\n");
  RunKey key;
  key.fill(0xAA);
  EXPECT_EQ(ReadKeyFile(path_), key);
}

TEST_F(KeyFileTest, AccessOfOthersIsRefusedWithTheMode) {
  const std::string text = std::string(64, '1') + "\n";
  for (const mode_t mode : {0640u, 0604u, 0644u, 0620u, 0602u, 0610u, 0777u}) {
    WriteKey(text, mode);
    EXPECT_THAT(ReadFailure(), HasSubstr(fmt::format("key file {}: mode {:04o}; ", path_, mode)));
    EXPECT_THAT(ReadFailure(), HasSubstr("chmod 600"));
  }
  for (const mode_t mode : {0600u, 0400u}) {
    WriteKey(text, mode);
    EXPECT_EQ(ReadFailure(), "no error") << mode;
    fs::remove(path_);
  }
}

TEST_F(KeyFileTest, MissingFileAndOtherThingsAreNamed) {
  EXPECT_THAT(ReadFailure(), HasSubstr(path_ + ": No such file"));
  fs::create_directory(path_);
  chmod(path_.c_str(), 0700);
  EXPECT_THAT(ReadFailure(), HasSubstr("regular file"));
  fs::remove(path_);
  mkfifo(path_.c_str(), 0600);
  EXPECT_THAT(ReadFailure(), HasSubstr("regular file"));
}

TEST_F(KeyFileTest, WrongLengthIsNamed) {
  for (const size_t digits : {0, 1, 63, 65, 1000}) {
    WriteKey(std::string(digits, '1') + "\n");
    EXPECT_THAT(ReadFailure(), HasSubstr(fmt::format("{}: {} bytes; it must hold 64", path_, digits + 1)));
  }
  WriteKey(std::string(64, '1'));
  EXPECT_THAT(ReadFailure(), HasSubstr("64 bytes; it must hold 64 hexadecimal digits and a newline"));
}

TEST_F(KeyFileTest, WrongDigitIsNamedByItsPlaceAndNoDigitIsShown) {
  for (const size_t at : {0, 1, 31, 62, 63, 64}) {
    for (const char wrong : {'g', ' ', ':', '\0', '\n'}) {
      if (at == 64 && wrong == '\n') continue;
      std::string text = std::string(64, '7') + "\n";
      text[at] = wrong;
      WriteKey(text);
      EXPECT_THAT(ReadFailure(), HasSubstr(fmt::format(": byte {} is wrong; it must hold 64", at + 1)));
      EXPECT_THAT(ReadFailure(), testing::Not(HasSubstr("77")));
    }
  }
}

}  // namespace
}  // namespace cairn
