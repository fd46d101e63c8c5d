#include "tests/deploy/launcher/test_support.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace cairn::deploy {
namespace {

void Redirect(const std::string& file, int to) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(fd, to);
  close(fd);
}

void ApplyEnvironment(const std::vector<std::string>& environment) {
  for (const std::string& entry : environment) {
    const size_t equals = entry.find('=');
    if (equals == std::string::npos) {
      unsetenv(entry.c_str());
    } else {
      setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
    }
  }
}

}  // namespace

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "cairn_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "mkdtemp " << name;
  path_ = name;
  std::filesystem::permissions(path_, std::filesystem::perms::all);
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string ReadText(const std::string& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void WriteText(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

void MakeReadyFifo(const std::string& file) { ASSERT_EQ(mkfifo((file + ".ready").c_str(), 0666), 0); }

int WaitUntilHeld(const std::string& file) { return std::atoi(ReadText(file + ".ready").c_str()); }

void WaitUntilReleased(const std::string& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
  EXPECT_GE(fd, 0) << file;
  EXPECT_EQ(flock(fd, LOCK_EX), 0);
  close(fd);
}

int StartProgram(const std::vector<std::string>& arguments, const std::string& out, const std::string& err,
                 const std::vector<std::string>& environment) {
  std::vector<std::string> words = arguments;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return pid;
  Redirect(out, STDOUT_FILENO);
  Redirect(err, STDERR_FILENO);
  ApplyEnvironment(environment);
  execv(argv[0], argv.data());
  _exit(127);
}

int WaitForProgram(int pid) {
  int status = 0;
  if (waitpid(pid, &status, 0) != pid) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

ProgramResult RunProgram(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  const TemporaryDirectory directory;
  ProgramResult result;
  const int pid = StartProgram(arguments, directory / "out", directory / "err", environment);
  result.exit_code = WaitForProgram(pid);
  result.out = ReadText(directory / "out");
  result.err = ReadText(directory / "err");
  return result;
}

int InChildProcess(const std::function<int()>& body) {
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return WaitForProgram(pid);
  int result = 99;
  try {
    result = body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  std::fflush(nullptr);
  _exit(result);
}

}  // namespace cairn::deploy
