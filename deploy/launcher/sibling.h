#pragma once

#include <string>

namespace cairn::deploy {

/// Directory of the running program.
std::string ProgramDirectory();

/// Path of a program that is installed beside this one ("cairn-actor"). Throws Error when it is not there.
std::string SiblingProgram(const std::string& name);

}  // namespace cairn::deploy
