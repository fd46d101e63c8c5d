#pragma once

#include <string>

namespace cairn::deploy {

enum class FindingState {
  kOk,
  kWarn,  ///< Cairn runs, but slower or less safely, or it helps itself
  kFail   ///< Cairn cannot run like this
};

/// One line of `cairn doctor`.
struct Finding {
  std::string name;  ///< what was looked at
  FindingState state = FindingState::kOk;
  std::string detail;  ///< what was seen
  std::string cure;    ///< what to type or to change; empty when the state is ok
};

inline Finding Ok(std::string name, std::string detail) {
  return {std::move(name), FindingState::kOk, std::move(detail), ""};
}
inline Finding Warn(std::string name, std::string detail, std::string cure) {
  return {std::move(name), FindingState::kWarn, std::move(detail), std::move(cure)};
}
inline Finding Fail(std::string name, std::string detail, std::string cure) {
  return {std::move(name), FindingState::kFail, std::move(detail), std::move(cure)};
}

}  // namespace cairn::deploy
