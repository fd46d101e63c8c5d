#include "common/world/import/moving_ai.h"

#include <charconv>

#include "common/core/check.h"

namespace cairn {
namespace {

// Lines of a text, without their ends (\n or \r\n), counted.
class Lines {
 public:
  Lines(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  std::string_view Next(const char* wanted) {
    if (text_.empty()) ThrowUsageError("{}: torn: it ends after line {}, before {}", file_, number_, wanted);
    ++number_;
    const size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

  // A line `name number`.
  int64_t Number(std::string_view name) {
    const std::string_view line = Next(std::string(name).c_str());
    int64_t value = 0;
    const bool named = line.size() > name.size() && line.substr(0, name.size()) == name && line[name.size()] == ' ';
    const char* begin = line.data() + (named ? name.size() + 1 : 0);
    const auto [end, error] = std::from_chars(begin, line.data() + line.size(), value);
    if (!named || error != std::errc() || end != line.data() + line.size() || value < 1 || value > INT32_MAX) {
      Throw(line, fmt::format("it must be `{} N` with a whole number N > 0", name));
    }
    return value;
  }

  [[noreturn]] void Throw(std::string_view line, const std::string& rule) const {
    std::string shown;
    for (const char c : line.substr(0, 40)) shown += c >= ' ' && c <= '~' ? c : '?';
    ThrowUsageError("{}:{}: \"{}\"; {}", file_, number_, shown, rule);
  }

  size_t left() const { return text_.size(); }
  int64_t number() const { return number_; }

 private:
  std::string_view text_;
  const std::string& file_;
  int64_t number_ = 0;
};

}  // namespace

CellGrid ReadMovingAi(std::string_view text, const std::string& file, double cell, int64_t max_cells) {
  Lines lines(text, file);
  if (const std::string_view type = lines.Next("`type octile`"); type != "type octile") {
    lines.Throw(type, "a Moving AI map begins with `type octile`");
  }
  const int64_t height = lines.Number("height"), width = lines.Number("width");
  if (const std::string_view map = lines.Next("`map`"); map != "map") lines.Throw(map, "it must be `map`");
  const Vector3d sizes(static_cast<double>(width), static_cast<double>(height), 1);
  CheckGrid(file, sizes, cell, Vector3d::Zero(), max_cells);
  if (static_cast<double>(lines.left()) < sizes.x() * sizes.y()) {
    ThrowUsageError("{}: torn: {} rows of {} cells need more than the {} bytes left after line 4", file, height, width,
                    lines.left());
  }
  CellGrid grid;
  grid.size = sizes.cast<int>();
  grid.cell = cell;
  grid.cells.resize(static_cast<size_t>(width * height));
  for (int y = grid.size.y() - 1; y >= 0; --y) {
    const std::string_view row = lines.Next("the last row");
    if (static_cast<int64_t>(row.size()) != width) {
      lines.Throw(row, fmt::format("a row of {} cells; width says {}", row.size(), width));
    }
    for (int x = 0; x < grid.size.x(); ++x) {
      const char c = row[static_cast<size_t>(x)];
      const bool free = c == '.' || c == 'G' || c == 'S';
      if (!free && c != '@' && c != 'O' && c != 'T' && c != 'W') {
        ThrowUsageError(
            "{}:{}: cell {} is character {}; it must be one of . G S (free) @ O T W (occupied)", file, lines.number(),
            x + 1, c >= ' ' && c <= '~' ? fmt::format("'{}'", c) : fmt::format("0x{:02x}", static_cast<uint8_t>(c)));
      }
      grid.cells[grid.Index(x, y)] = free ? Cell::kFree : Cell::kOccupied;
    }
  }
  return grid;
}

}  // namespace cairn
