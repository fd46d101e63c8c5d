#include "common/core/files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/core/check.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

class FilesTest : public testing::Test {
 protected:
  FilesTest() {
    std::string name = (fs::temp_directory_path() / "cairn_files_XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
  }
  ~FilesTest() override { fs::remove_all(directory_); }

  std::string Read(const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(directory_ / name, std::ios::binary).rdbuf();
    return text.str();
  }

  fs::path directory_;
};

TEST_F(FilesTest, WritesAndReplacesWholeFiles) {
  const std::string path = directory_ / "a";
  WriteFileAtomically(path, std::string("long\0text", 9));
  EXPECT_EQ(Read("a"), std::string("long\0text", 9));
  WriteFileAtomically(path, "");
  EXPECT_EQ(Read("a"), "");
}

TEST_F(FilesTest, LeavesNothingBesideTheFile) {
  WriteFileAtomically(directory_ / "a", "text");
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()), 1);
}

TEST_F(FilesTest, APipeIsWrittenToAndWhatALinkLeadsToIsReplaced) {
  const std::string pipe = directory_ / "pipe", file = directory_ / "file", link = directory_ / "link";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDWR);  // so that nobody waits
  WriteFileAtomically(pipe, "text");
  char text[5] = {};
  EXPECT_EQ(read(reader, text, 4), 4);
  close(reader);
  EXPECT_STREQ(text, "text");
  EXPECT_TRUE(fs::is_fifo(pipe));
  WriteFileAtomically(file, "old");
  fs::create_symlink(file, link);
  WriteFileAtomically(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(ReadFile(file), "new");
}

TEST_F(FilesTest, FailureNamesPathAndReasonAndKeepsTheOldFile) {
  fs::create_directory(directory_ / "a");
  fs::create_directory(directory_ / "a/in_the_way");
  try {
    WriteFileAtomically(directory_ / "a", "text");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr((directory_ / "a").string() + ": Is a directory"));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()), 1);
  EXPECT_THROW(WriteFileAtomically(directory_ / "no/such/file", "text"), Error);
}

}  // namespace
}  // namespace cairn
