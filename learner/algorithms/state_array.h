#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "common/core/bytes.h"

namespace cairn::learner {

/// Raw numbers under a name: a network's weights, an optimizer's moments.
struct StateArray {
  std::string name;
  Bytes data;
};

/// Visits the numbers of something that is saved and loaded, in a fixed order, under names that never change.
/// `network`: what init_from takes from another run; the rest is optimizers and counters.
using StateVisitor = std::function<void(const std::string& name, bool network, std::span<std::byte> numbers)>;

template <typename T>
void VisitNumbers(const StateVisitor& visit, const std::string& name, bool network, T* values, size_t count) {
  visit(name, network, std::as_writable_bytes(std::span<T>(values, count)));
}

}  // namespace cairn::learner
