#pragma once

#include <string>
#include <vector>

namespace cairn {

/// Number of inserted, deleted or replaced characters between two words (Levenshtein), letter case ignored.
int EditDistance(const std::string& a, const std::string& b);

/// The candidate with the smallest edit distance to `name`, the first of equals; empty when there are none.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace cairn
