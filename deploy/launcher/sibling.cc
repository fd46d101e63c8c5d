#include "deploy/launcher/sibling.h"

#include <unistd.h>

#include <filesystem>

#include "common/core/check.h"

namespace cairn::deploy {

std::string ProgramDirectory() { return std::filesystem::read_symlink("/proc/self/exe").parent_path().string(); }

std::string SiblingProgram(const std::string& name) {
  const std::string path = ProgramDirectory() + "/" + name;
  if (access(path.c_str(), X_OK) == 0) return path;
  ThrowError("cannot find the program {} beside cairn, in {}; is the build complete?", name, ProgramDirectory());
}

}  // namespace cairn::deploy
