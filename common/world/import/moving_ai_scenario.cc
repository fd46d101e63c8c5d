#include "common/world/import/moving_ai_scenario.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr size_t kFields = 9;
constexpr const char* kNames[kFields] = {"bucket",  "map",    "width",  "height", "start x",
                                         "start y", "goal x", "goal y", "length"};
constexpr int kMaxSide = 1 << 27;

// One line of a scenario, split into its fields.
class Fields {
 public:
  Fields(std::string_view line, const std::string& file, int number) : file_(file), number_(number) {
    // A map's name may have spaces, so tabs divide where there are any.
    const char* dividers = line.find('\t') != std::string_view::npos ? "\t" : " ";
    for (size_t at = line.find_first_not_of(dividers); at < line.size(); at = line.find_first_not_of(dividers, at)) {
      const size_t end = std::min(line.find_first_of(dividers, at), line.size());
      fields_.push_back(line.substr(at, end - at));
      at = end;
    }
    if (fields_.size() == kFields) return;
    ThrowUsageError(
        "{}:{}: {} fields; a scenario's line has {}: bucket map width height start-x start-y goal-x goal-y "
        "length",
        file, number, fields_.size(), kFields);
  }

  std::string_view text(size_t field) const { return fields_[field]; }

  // A whole number in [least, limit).
  int Whole(size_t field, int least, int limit) const {
    const int value = Parse<int>(field);
    if (value >= least && value < limit) return value;
    ThrowUsageError("{}:{}: {} = {}; it must be from {} to {}", file_, number_, kNames[field], value, least, limit - 1);
  }

  double Length() const {
    const double value = Parse<double>(8);
    if (value >= 0 && std::isfinite(value)) return value;
    ThrowUsageError("{}:{}: length = {}; it must be 0 or more", file_, number_, value);
  }

 private:
  template <typename T>
  T Parse(size_t field) const {
    T value{};
    const char* last = fields_[field].data() + fields_[field].size();
    const auto [end, error] = std::from_chars(fields_[field].data(), last, value);
    if (error == std::errc() && end == last) return value;
    std::string shown;
    for (const char c : fields_[field].substr(0, 20)) shown += c >= ' ' && c <= '~' ? c : '?';
    ThrowUsageError("{}:{}: {} = \"{}\"; it must be a number", file_, number_, kNames[field], shown);
  }

  const std::string& file_;
  int number_;
  std::vector<std::string_view> fields_;
};

void ReadMapOf(const Fields& fields, const std::string& file, int line, Scenario* scenario) {
  const std::string map(fields.text(1));
  const int width = fields.Whole(2, 1, kMaxSide), height = fields.Whole(3, 1, kMaxSide);
  if (scenario->paths.empty()) {
    scenario->map = map;
    scenario->width = width;
    scenario->height = height;
  }
  if (map == scenario->map && width == scenario->width && height == scenario->height) return;
  ThrowUsageError("{}:{}: a map of {} x {} cells, not the {} x {} of line {}, or of another name", file, line, width,
                  height, scenario->width, scenario->height, scenario->paths.front().line);
}

}  // namespace

Scenario ReadScenario(std::string_view text, const std::string& file) {
  Scenario scenario;
  scenario.ends_in_line = text.empty() || text.back() == '\n';
  for (int number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (number == 1) {
      if (line == "version 1" || line == "version 1.0") continue;
      ThrowUsageError("{}:1: a Moving AI scenario begins with `version 1`", file);
    }
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    const Fields fields(line, file, number);
    ReadMapOf(fields, file, number, &scenario);
    ScenarioPath path;
    path.line = number;
    path.start = {fields.Whole(4, 0, scenario.width), fields.Whole(5, 0, scenario.height)};
    path.goal = {fields.Whole(6, 0, scenario.width), fields.Whole(7, 0, scenario.height)};
    path.length = fields.Length();
    scenario.paths.push_back(path);
  }
  if (scenario.paths.empty()) ThrowUsageError("{}: torn: no path after the line `version 1`", file);
  return scenario;
}

}  // namespace cairn
