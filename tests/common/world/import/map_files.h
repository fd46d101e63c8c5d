#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "common/core/check.h"
#include "common/world/import/cell_grid.h"

namespace cairn {

/// A directory for one test; gone with it.
class MapDirectory {
 public:
  MapDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "cairn-map-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~MapDirectory() { std::filesystem::remove_all(path_); }

  std::string Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return (path_ / name).string();
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The cells as text, top row first: '.' free, '?' unknown, '#' occupied.
inline std::vector<std::string> Rows(const CellGrid& grid) {
  std::vector<std::string> rows;
  for (int y = grid.size.y() - 1; y >= 0; --y) {
    rows.emplace_back();
    for (int x = 0; x < grid.size.x(); ++x) rows.back() += ".?#"[static_cast<int>(grid.cells[grid.Index(x, y)])];
  }
  return rows;
}

/// The same, read back.
inline CellGrid GridOf(const std::vector<std::string>& rows, double cell = 1) {
  CellGrid grid;
  grid.size = {static_cast<int>(rows[0].size()), static_cast<int>(rows.size()), 1};
  grid.cell = cell;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    for (const char c : *row)
      grid.cells.push_back(c == '.' ? Cell::kFree : c == '?' ? Cell::kUnknown : Cell::kOccupied);
  }
  return grid;
}

/// What the UsageError says; empty when there is none.
inline std::string ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

}  // namespace cairn
