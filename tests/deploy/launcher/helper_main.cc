// Stands for Cairn's processes in the tests of the launcher: deploy_test_helper MODE ARGUMENTS…
#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "deploy/launcher/supervisor.h"

namespace {

using cairn::deploy::Command;

// Locks `file` for as long as this process lives (a zombie holds no lock), then says so on the FIFO `file`.ready, if
// there is one; that waits for a reader.
void HoldLock(const std::string& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0 || flock(fd, LOCK_EX) != 0) _exit(70);
  const int ready = open((file + ".ready").c_str(), O_WRONLY | O_CLOEXEC);
  if (ready < 0) return;
  dprintf(ready, "%d", getpid());
  close(ready);
}

[[noreturn]] void Pause() {
  for (;;) pause();
}

// Fails until it has been started `enough` times.
int CountStarts(const std::string& file, int enough) {
  std::FILE* log = std::fopen(file.c_str(), "a");
  std::fputc('x', log);
  const long starts = std::ftell(log);
  std::fclose(log);
  return starts < enough ? 1 : 0;
}

void PrintDescriptors() {
  DIR* directory = opendir("/proc/self/fd");
  while (const dirent* entry = readdir(directory)) {
    const int fd = std::atoi(entry->d_name);
    if (entry->d_name[0] != '.' && fd != dirfd(directory)) std::printf("fd %d\n", fd);
  }
  closedir(directory);
}

// Ends with the pipe alone: without the kernel's parent-death signal.
int WaitForParent(int fd, const std::string& file) {
  prctl(PR_SET_PDEATHSIG, 0);
  HoldLock(file);
  char byte;
  return read(fd, &byte, 1) == 0 ? 0 : 1;
}

// A launcher with four processes that hold locks `directory`/0 … 3.
int Supervise(const std::string& self, const std::string& directory) {
  using cairn::deploy::Role;
  cairn::deploy::SignalEvents signals;
  cairn::deploy::Supervisor supervisor(&signals, {});
  const std::string fd = std::to_string(supervisor.parent_fd());
  const auto add = [&](int i, Role role) {
    const std::string file = directory + "/" + std::to_string(i);
    const std::vector<std::string> arguments =
        i == 3 ? std::vector<std::string>{"parent", fd, file} : std::vector<std::string>{"hold", file};
    const Command command{file, self, arguments, file + ".log"};
    supervisor.Add({file, role, [command](int) { return command; }});
  };
  add(0, Role::kService);
  add(1, Role::kMain);
  add(2, Role::kWorker);
  add(3, Role::kWorker);
  return supervisor.Run().exit_code;
}

int Exit(int argc, char** argv) {
  if (argc > 3) std::fprintf(stderr, "%s\n", argv[3]);
  return std::atoi(argv[2]);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "exit") return Exit(argc, argv);
  if (mode == "crash") std::abort();
  if (mode == "fds") PrintDescriptors();
  if (mode == "group") std::printf("leads its group: %d\n", getpgrp() == getpid());
  if (mode == "count") return CountStarts(argv[2], std::atoi(argv[3]));
  if (mode == "die" && CountStarts(argv[2], std::atoi(argv[3])) != 0) raise(SIGKILL);
  if (mode == "parent") return WaitForParent(std::atoi(argv[2]), argv[3]);
  if (mode == "supervise") return Supervise(argv[0], argv[2]);
  if (mode == "stubborn") std::signal(SIGTERM, SIG_IGN);
  if (mode == "hold" || mode == "stubborn") {
    HoldLock(argv[2]);
    Pause();
  }
  return 0;
}
