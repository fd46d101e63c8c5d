#include "deploy/launcher/stress_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace cairn::deploy {
namespace {

constexpr int kColumns = 3;
constexpr double kCellWidth = 300, kCellHeight = 230;                           // of a chart with its margins [px]
constexpr double kLeft = 46, kRight = 14, kTop = 34, kBottom = 44, kHead = 84;  // margins [px]
constexpr double kWidth = kCellWidth - kLeft - kRight, kHeight = kCellHeight - kTop - kBottom;

struct Series {
  const char* controller;
  const char* name;
  const char* color;
  double shift;  // of its marks, so that whiskers stand side by side [px]
};
constexpr Series kSeries[] = {{"policy", "learned policy", "#0b62a4", -2},
                              {"pure_pursuit", "pure pursuit", "#e08700", 2}};

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return escaped;
}

class Chart {
 public:
  Chart(const Knob& knob, double x, double y, std::string* svg) : knob_(knob), x_(x + kLeft), y_(y + kTop), svg_(*svg) {
    low_ = high_ = knob.points[0].value;
    for (const ConditionPoint& point : knob.points) {
      low_ = std::min(low_, point.value);
      high_ = std::max(high_, point.value);
    }
    if (high_ == low_) high_ = low_ + 1;
  }

  void DrawAxes() {
    Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"13\" font-weight=\"bold\">{}</text>\n", x_, y_ - 12,
        Escape(knob_.name));
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      Add("<line x1=\"{0:.1f}\" y1=\"{2:.1f}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"#d8dee4\"/>\n", x_, x_ + kWidth,
          Y(share));
      Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"10\" text-anchor=\"end\">{:.2f}</text>\n", x_ - 6,
          Y(share) + 3.5, share);
    }
    for (const ConditionPoint& point : knob_.points) {
      Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"10\" text-anchor=\"middle\">{:.4g}</text>\n", X(point.value),
          y_ + kHeight + 14, point.value);
    }
    Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"10\" fill=\"#57606a\" text-anchor=\"middle\">{}</text>\n",
        x_ + 0.5 * kWidth, y_ + kHeight + 30, Escape(knob_.unit));
  }

  void DrawSeries(const Series& series, const std::vector<StressResult>& results) {
    std::string line;
    for (const StressResult& result : results) {
      if (result.knob != &knob_ || result.controller != series.controller) continue;
      const double x = X(result.point->value) + series.shift, y = Y(result.summary.success_rate);
      line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, y);
      Add("<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>\n", x,
          Y(result.summary.success_interval.low), Y(result.summary.success_interval.high), series.color);
      Add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>\n", x, y, series.color);
    }
    Add("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", line, series.color);
  }

 private:
  double X(double value) const { return x_ + 8 + (value - low_) / (high_ - low_) * (kWidth - 16); }
  double Y(double share) const { return y_ + (1 - share) * kHeight; }

  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  const Knob& knob_;
  double x_, y_, low_, high_;
  std::string& svg_;
};

bool Has(const std::vector<StressResult>& results, const Series& series) {
  return std::any_of(results.begin(), results.end(), [&](const auto& r) { return r.controller == series.controller; });
}

}  // namespace

std::string DrawStress(const std::string& title, const std::string& subtitle,
                       const std::vector<StressResult>& results) {
  std::vector<const Knob*> knobs;
  for (const StressResult& result : results) {
    if (knobs.empty() || knobs.back() != result.knob) knobs.push_back(result.knob);
  }
  const auto count = static_cast<int>(knobs.size());
  const double width = std::min(count, kColumns) * kCellWidth + 20;
  const double height = kHead + (count + kColumns - 1) / kColumns * kCellHeight;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif\" fill=\"#24292f\">\n"
      "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#fff\"/>\n"
      "<text x=\"16\" y=\"28\" font-size=\"17\" font-weight=\"bold\">{2}</text>\n"
      "<text x=\"16\" y=\"47\" font-size=\"12\" fill=\"#57606a\">{3}</text>\n",
      width, height, Escape(title), Escape(subtitle));
  double legend = 16;
  for (const Series& series : kSeries) {
    if (!Has(results, series)) continue;
    svg += fmt::format(
        "<circle cx=\"{:.0f}\" cy=\"65\" r=\"4\" fill=\"{}\"/><text x=\"{:.0f}\" y=\"69\" font-size=\"12\">{}</text>\n",
        legend + 4, series.color, legend + 14, series.name);
    legend += 130;
  }
  for (int i = 0; i < count; ++i) {
    Chart chart(*knobs[static_cast<size_t>(i)], i % kColumns * kCellWidth, kHead + i / kColumns * kCellHeight, &svg);
    chart.DrawAxes();
    for (const Series& series : kSeries) chart.DrawSeries(series, results);
  }
  return svg + "</svg>\n";
}

}  // namespace cairn::deploy
