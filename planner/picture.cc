#include "planner/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "common/core/check.h"
#include "common/world/import/cell_grid.h"
#include "planner/color_map.h"
#include "planner/outcome_style.h"
#include "planner/path.h"
#include "planner/shown_edges.h"

namespace cairn::planner {
namespace {

constexpr int kColors = 48;  // steps of the colour scale: edges of a step share one SVG path
constexpr double kLeft = 62, kTop = 66, kBottom = 84, kRight = 96;  // margins [px]
constexpr double kMaxAspect = 4;  // of a map's height to its width before it is drawn narrower
constexpr const char* kInk = "#24292f";
constexpr const char* kPathColor = "#e0115f";

const char* OutcomeColor(Outcome outcome) {
  for (const OutcomeStyle& style : kOutcomeStyles) {
    if (style.outcome == outcome) return style.color;
  }
  return kInk;
}

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// 1, 2 or 5 times a power of ten, so that `span` has about `count` steps.
double NiceStep(double span, double count) {
  const double raw = span / count, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power * (1 + 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<double> Multiples(double low, double high, double step) {
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push_back(k * step + 0.0);
  return ticks;
}

std::vector<double> Ticks(double low, double high, double count) {
  return Multiples(low, high, NiceStep(high - low, count));
}

// Draws one picture; every Draw… appends one layer.
class Painter {
 public:
  Painter(const World& world, const Roadmap* roadmap, const CostTable* table, const PictureOptions& options)
      : world_(world), roadmap_(roadmap), table_(roadmap ? table : nullptr), options_(options) {
    scale_ = options.width / world.bounds.size().x();
    height_ = scale_ * world.bounds.size().y();
    max_cost_ = table_ ? std::max(table_->max_cost(), 1e-6f) : 1;
    scale_high_ = max_cost_;
    if (options.values) SetScaleOf(options.values->values);
  }

  std::string Paint(const std::vector<Trajectory>& trajectories) {
    Open();
    DrawCostField();
    DrawValues();
    DrawGrid();
    DrawRegions();
    DrawWalls();
    DrawRoadmap(trajectories.empty() ? 1 : 0.35);
    DrawOptimalPath(trajectories.empty() ? 3.4 : 2.0);
    if (options_.door_numbers) DrawDoorNumbers();
    for (const Trajectory& trajectory : trajectories) DrawTrajectory(trajectory);
    DrawFrame();
    DrawColorBar();
    DrawLegend(trajectories);
    return svg_ + "</svg>\n";
  }

 private:
  double X(double x) const { return kLeft + (x - world_.bounds.min.x()) * scale_; }
  double Y(double y) const { return kTop + (world_.bounds.max.y() - y) * scale_; }

  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  void Open() {
    const double w = kLeft + options_.width + kRight, h = kTop + height_ + kBottom;
    Add("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
        "{1:.0f}\" "
        "font-family=\"Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif\" fill=\"{2}\">\n",
        w, h, kInk);
    Add("<rect width=\"{:.0f}\" height=\"{:.0f}\" fill=\"#fff\"/>\n", w, h);
    Add("<clipPath id=\"map\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/></clipPath>\n", kLeft,
        kTop, options_.width, height_);
    Add("<text x=\"{:.1f}\" y=\"30\" font-size=\"19\" font-weight=\"bold\">{}</text>\n", kLeft, Escape(options_.title));
    Add("<text x=\"{:.1f}\" y=\"51\" font-size=\"13\" fill=\"#57606a\">{}</text>\n", kLeft, Escape(options_.subtitle));
  }

  void AddBox(const Box& box, const std::string& style) {
    Add("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" {}/>\n", X(box.min.x()), Y(box.max.y()),
        box.size().x() * scale_, box.size().y() * scale_, style);
  }

  // Discs of radius r_ball, dearest first: what stays visible at a point is the cheapest vertex around it, D(s).
  void DrawCostField() {
    if (!table_ || options_.r_ball <= 0) return;
    std::vector<int> order(static_cast<size_t>(roadmap_->num_places()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return table_->cost[a] > table_->cost[b]; });
    Add("<g clip-path=\"url(#map)\" opacity=\"0.3\">\n");
    for (const int v : order) {
      if (!std::isfinite(table_->cost[v])) continue;
      const Vector3d p = roadmap_->position(v);
      Add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.2f}\" fill=\"{}\"/>\n", X(p.x()), Y(p.y()),
          options_.r_ball * scale_, CostColor(table_->cost[v] / max_cost_));
    }
    Add("</g>\n");
  }

  // Cells of one step of the colour scale share a path; neighbours in a row are one rectangle. Whole pixels, so that
  // nothing shows between them.
  void DrawValues() {
    if (!options_.values) return;
    const ValueMap& map = *options_.values;
    const auto x = [&](int column) { return std::lround(X(world_.bounds.min.x() + column * map.cell)); };
    const auto y = [&](int row) { return std::lround(Y(world_.bounds.min.y() + row * map.cell)); };
    std::array<std::string, kColors> paths;
    for (int row = 0; row < map.rows; ++row) {
      const auto step = [&](int column) { return column < map.columns ? ValueStep(row, column) : -1; };
      for (int column = 0, end; column < map.columns; column = end) {
        end = column + 1;
        while (step(end) == step(column) && end < map.columns) ++end;
        if (step(column) < 0) continue;
        paths[step(column)] += fmt::format("M{0} {1}H{2}V{3}H{0}z", x(column), y(row), x(end), y(row + 1));
      }
    }
    Add("<g shape-rendering=\"crispEdges\" clip-path=\"url(#map)\">\n");
    for (int i = 0; i < kColors; ++i) {
      if (!paths[i].empty()) Add("<path fill=\"{}\" d=\"{}\"/>\n", ValueColor(i), paths[i]);
    }
    Add("</g>\n");
  }

  // Step of a cell's value on the colour scale, -1 where it has none.
  int ValueStep(int row, int column) const {
    const ValueMap& map = *options_.values;
    const double value = map.values[static_cast<size_t>(row) * map.columns + column];
    if (!std::isfinite(value)) return -1;
    return std::clamp(static_cast<int>((value - scale_low_) / (scale_high_ - scale_low_) * kColors), 0, kColors - 1);
  }

  // High values have the colour of low costs.
  std::string ValueColor(int step) const { return CostColor(1 - (step + 0.5) / kColors); }

  // The range of colours is that of the finite values.
  void SetScaleOf(const std::vector<float>& values) {
    scale_low_ = std::numeric_limits<double>::infinity();
    scale_high_ = -scale_low_;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      scale_low_ = std::min(scale_low_, value);
      scale_high_ = std::max(scale_high_, value);
    }
    if (scale_low_ > scale_high_) scale_low_ = scale_high_ = 0;
    if (scale_high_ - scale_low_ < 1e-6) scale_high_ = scale_low_ + 1e-6;
  }

  // Ten lines to a labelled one, to read coordinates from.
  void DrawFineGrid() {
    const Vector3d low = world_.bounds.min, high = world_.bounds.max;
    const double step = 0.1 * NiceStep(high.x() - low.x(), LabelCount());
    std::string lines;
    for (const double x : Multiples(low.x(), high.x(), step)) {
      lines += fmt::format("M{:.1f} {:.1f}v{:.1f}", X(x), kTop, height_);
    }
    for (const double y : Multiples(low.y(), high.y(), step)) {
      lines += fmt::format("M{:.1f} {:.1f}h{:.1f}", kLeft, Y(y), options_.width);
    }
    Add("<path d=\"{}\" stroke=\"{}\" stroke-opacity=\"0.12\" stroke-width=\"0.5\" fill=\"none\"/>\n", lines, kInk);
  }

  double LabelCount() const { return std::max(4.0, options_.width / (world_.imported ? 60 : 95)); }

  void DrawGrid() {
    if (world_.imported) DrawFineGrid();
    const Vector3d low = world_.bounds.min, high = world_.bounds.max;
    const double count = LabelCount();
    const double rows = count * height_ / options_.width;
    std::string lines;
    Add("<g font-size=\"13\" text-anchor=\"middle\">\n");
    for (const double x : Ticks(low.x(), high.x(), count)) {
      lines += fmt::format("M{0:.1f} {1:.1f}V{2:.1f}", X(x), kTop, kTop + height_ + 6);
      Add("<text x=\"{:.1f}\" y=\"{:.1f}\">{:.6g}</text>\n", X(x), kTop + height_ + 22, x);
    }
    for (const double y : Ticks(low.y(), high.y(), rows)) {
      lines += fmt::format("M{0:.1f} {1:.1f}H{2:.1f}", kLeft - 6, Y(y), kLeft + options_.width);
      Add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>\n", kLeft - 10, Y(y) + 4.5, y);
    }
    Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-style=\"italic\">x [m]</text>\n", kLeft + options_.width / 2,
        kTop + height_ + 42);
    Add("<text transform=\"translate(18 {:.1f}) rotate(-90)\" font-style=\"italic\">y [m]</text>\n</g>\n",
        kTop + height_ / 2);
    Add("<path d=\"{}\" stroke=\"{}\" stroke-opacity=\"0.22\" stroke-width=\"0.8\" fill=\"none\"/>\n", lines, kInk);
  }

  void DrawRegion(const Box& box, const char* label, const char* color) {
    if (box.size().x() <= 0) return;  // not in this slice of a world
    AddBox(box, fmt::format("fill=\"{0}\" fill-opacity=\"0.14\" stroke=\"{0}\" stroke-width=\"2\"", color));
    const double size = std::clamp(0.2 * box.size().x() * scale_, 9.0, 26.0);
    labels_ += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.1f}\" font-weight=\"bold\" text-anchor=\"middle\" fill=\"{}\" "
        "stroke=\"#fff\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\">{}</text>\n",
        X(box.center().x()), Y(box.min.y() + 0.2 * box.size().y()) + 0.35 * size, size, color, label);
  }

  void DrawRegions() {
    if (!options_.regions) return;
    const bool everywhere = world_.start.min == world_.bounds.min && world_.start.max == world_.bounds.max;
    if (!everywhere) DrawRegion(world_.start, "start", "#1a7f37");
    DrawRegion(world_.goal, "goal", "#c2540a");
  }

  void DrawDoorNumbers() {
    Add("<g id=\"doors\" text-anchor=\"middle\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"2.5\" "
        "stroke-linejoin=\"round\" "
        "paint-order=\"stroke\">\n",
        kInk);
    for (size_t i = 0; i < world_.doors.size(); ++i) {
      const Box& door = world_.doors[i];
      const double side = std::max(door.size().x(), door.size().y()) * scale_;
      const double size = std::clamp(0.3 * side, 5.0, 12.0);  // [px]
      const Vector3d at = door.center();
      Add("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.1f}\">{}</text>\n", X(at.x()), Y(at.y()) + 0.36 * size, size,
          i);
    }
    Add("</g>\n");
  }

  void DrawWalls() {
    Add("<g fill=\"{}\" clip-path=\"url(#map)\">\n", kInk);
    if (world_.imported) {
      AddBoxesAsOnePath();
    } else {
      for (const Box& box : world_.boxes) AddBox(box, "");
    }
    for (const Cylinder& c : world_.cylinders) {
      Add("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\"/>\n", X(c.base.x()), Y(c.base.y()), c.radius * scale_);
    }
    Add("</g>\n");
  }

  // A map's cells, which may be a million boxes, as runs of half pixels: what is finer nobody sees, and it bounds the
  // file. A half pixel that a box touches is dark.
  void AddBoxesAsOnePath() {
    const double step = 0.5;  // [px]
    CellGrid grid;
    grid.cell = step;
    grid.size = {static_cast<int>(std::ceil(options_.width / step)), static_cast<int>(std::ceil(height_ / step)), 1};
    grid.cells.assign(static_cast<size_t>(grid.size.x()) * grid.size.y(), Cell::kFree);
    const auto index = [&](double pixels, int count) { return std::clamp(static_cast<int>(pixels / step), 0, count); };
    for (const Box& box : world_.boxes) {
      const double left = X(box.min.x()) - kLeft, right = X(box.max.x()) - kLeft;
      const double top = Y(box.max.y()) - kTop, bottom = Y(box.min.y()) - kTop;
      const int x0 = index(left + 1e-6, grid.size.x()), x1 = index(right + step - 1e-6, grid.size.x());
      const int y0 = index(top + 1e-6, grid.size.y()), y1 = index(bottom + step - 1e-6, grid.size.y());
      for (int y = y0; y < y1; ++y) {
        const auto row = grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.Index(0, y));
        std::fill(row + x0, row + std::max(x0, x1), Cell::kOccupied);
      }
    }
    Add("<path d=\"");
    for (const Box& box : MergeBoxes(std::move(grid))) {
      Add("M{:.6g} {:.6g}h{:.6g}v{:.6g}h-{:.6g}z", kLeft + box.min.x(), kTop + box.min.y(), box.size().x(),
          box.size().y(), box.size().x());
    }
    Add("\"/>\n");
  }

  int ColorStep(double cost) const { return std::clamp(static_cast<int>(cost / max_cost_ * kColors), 0, kColors - 1); }

  // One path of edges and one of vertices (round caps of zero-length lines) per step of the colour scale; the last
  // entry is for vertices that cannot reach the goal.
  void DrawRoadmap(double opacity) {
    if (!roadmap_) return;
    std::array<std::string, kColors + 1> edges, vertices;
    const auto step = [&](double cost) { return std::isfinite(cost) ? ColorStep(cost) : kColors; };
    const auto cost_of = [&](int v) { return table_ ? double{table_->cost[v]} : double{kUnreachable}; };
    for (int v = 0; v < roadmap_->num_places(); ++v) {
      const Vector3d p = roadmap_->position(v);
      vertices[step(cost_of(v))] += fmt::format("M{:.1f} {:.1f}h0", X(p.x()), Y(p.y()));
    }
    ForEachShownEdge(*roadmap_, options_.longest_edge, [&](int v, int u) {
      const Vector3d p = roadmap_->position(v), q = roadmap_->position(u);
      edges[step(0.5 * (cost_of(v) + cost_of(u)))] +=
          fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", X(p.x()), Y(p.y()), X(q.x()), Y(q.y()));
    });
    const double spacing = std::sqrt(options_.width * height_ / std::max(1, roadmap_->num_places()));  // [px]
    Add("<g fill=\"none\" stroke-linecap=\"round\" opacity=\"{}\">\n", opacity);
    AddStrokes(edges, std::clamp(0.05 * spacing, 0.4, 1.4));
    AddStrokes(vertices, std::clamp(0.18 * spacing, 1.0, 5.0));
    Add("</g>\n");
  }

  void AddStrokes(const std::array<std::string, kColors + 1>& paths, double width) {
    for (int i = 0; i <= kColors; ++i) {
      if (paths[i].empty()) continue;
      const std::string color = i == kColors ? "#8c959f" : CostColor((i + 0.5) / kColors);
      Add("<path stroke=\"{}\" stroke-width=\"{:.2f}\" d=\"{}\"/>\n", color, width, paths[i]);
    }
  }

  std::string Polyline(const std::vector<Vector3d>& points) const {
    std::string d;
    for (const Vector3d& p : points) d += fmt::format("{}{:.1f} {:.1f}", d.empty() ? "M" : "L", X(p.x()), Y(p.y()));
    return d;
  }

  void AddCasedLine(const std::vector<Vector3d>& points, const std::string& color, double width) {
    const std::string d = Polyline(points);
    Add("<path fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\" d=\"{}\" stroke=\"#fff\" "
        "stroke-width=\"{:.1f}\" stroke-opacity=\"0.85\"/>\n",
        d, width + 2.4);
    Add("<path fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\" d=\"{}\" stroke=\"{}\" "
        "stroke-width=\"{:.1f}\"/>\n",
        d, color, width);
  }

  void DrawOptimalPath(double width) {
    if (!table_ || !options_.optimal_path) return;
    const Path path = OptimalPath(world_, *roadmap_, *table_);
    if (path.points.empty()) return;
    path_length_ = path.length;
    AddCasedLine(path.points, kPathColor, width);
    const Vector3d& p = path.points.front();
    Add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"6\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"2\"/>\n", X(p.x()),
        Y(p.y()), kPathColor);
  }

  // A ring where it starts; where it ends a dot, or a cross for a collision.
  void DrawTrajectory(const Trajectory& trajectory) {
    if (trajectory.points.empty()) return;
    const char* color = OutcomeColor(trajectory.outcome);
    AddCasedLine(trajectory.points, color, 1.9);
    const Vector3d &first = trajectory.points.front(), &last = trajectory.points.back();
    Add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"2\"/>\n", X(first.x()),
        Y(first.y()), color);
    AddEndMark(X(last.x()), Y(last.y()), trajectory.outcome);
  }

  void AddEndMark(double x, double y, Outcome outcome) {
    const char* color = OutcomeColor(outcome);
    if (outcome == Outcome::kCollision) {
      const std::string cross = fmt::format("M{:.1f} {:.1f}l10 10m0 -10l-10 10", x - 5, y - 5);
      Add("<path d=\"{0}\" stroke=\"#fff\" stroke-width=\"6\"/><path d=\"{0}\" stroke=\"{1}\" stroke-width=\"3\"/>\n",
          cross, color);
    } else {
      Add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.6\" fill=\"{}\"/>\n", x, y, color);
    }
  }

  void DrawFrame() {
    AddBox(world_.bounds, fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"1.2\"", kInk));
    svg_ += labels_;
  }

  void DrawColorBar() {
    if (!table_ && !options_.values) return;
    const double x = kLeft + options_.width + 22, width = 16;
    Add("<g shape-rendering=\"crispEdges\">\n");
    for (int i = 0; i < kColors; ++i) {
      Add("<rect x=\"{:.1f}\" y=\"{:.2f}\" width=\"{:.1f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", x,
          kTop + height_ * (kColors - 1 - i) / kColors, width, height_ / kColors + 0.5,
          options_.values ? ValueColor(i) : CostColor((i + 0.5) / kColors));
    }
    Add("</g>\n<g font-size=\"13\">\n");
    for (const double tick : Ticks(scale_low_, scale_high_, std::max(3.0, height_ / 70))) {
      const double y = kTop + height_ * (1 - (tick - scale_low_) / (scale_high_ - scale_low_));
      Add("<path d=\"M{:.1f} {:.1f}h5\" stroke=\"{}\"/><text x=\"{:.1f}\" y=\"{:.1f}\">{:.6g}</text>\n", x + width, y,
          kInk, x + width + 9, y + 4.5, tick);
    }
    Add("<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" text-anchor=\"middle\" font-style=\"italic\">"
        "{}</text>\n</g>\n",
        x + width + 49, kTop + height_ / 2, options_.values ? Escape(options_.values->label) : "cost-to-go [m]");
  }

  // Below the map: the optimal path with its length, then each outcome with its count.
  void DrawLegend(const std::vector<Trajectory>& trajectories) {
    const double y = kTop + height_ + 66;
    double x = kLeft;
    const auto add = [&](const char* color, const std::string& text) {
      Add("<path d=\"M{:.1f} {:.1f}h26\" stroke=\"{}\" stroke-width=\"3.4\" stroke-linecap=\"round\"/>"
          "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"13\">{}</text>\n",
          x, y - 4.5, color, x + 34, y, text);
      x += 34 + 7.0 * static_cast<double>(text.size()) + 24;
    };
    if (path_length_ > 0) add(kPathColor, fmt::format("optimal path, {:.2f} m", path_length_));
    for (const OutcomeStyle& style : kOutcomeStyles) {
      const auto same = [&](const Trajectory& t) { return t.outcome == style.outcome; };
      const auto count = std::count_if(trajectories.begin(), trajectories.end(), same);
      if (count > 0) add(style.color, fmt::format("{} {}", count, OutcomeName(style.outcome)));
    }
  }

  const World& world_;
  const Roadmap* roadmap_;
  const CostTable* table_;
  const PictureOptions& options_;
  double scale_;            // [px/m]
  double height_;           // of the map [px]
  double max_cost_;         // [m]
  double path_length_ = 0;  // [m]
  double scale_low_ = 0;    // of the colour bar
  double scale_high_;
  std::string labels_;  // drawn last
  std::string svg_;
};

}  // namespace

std::string DrawScene(const World& world, const Roadmap* roadmap, const CostTable* table,
                      const std::vector<Trajectory>& trajectories, const PictureOptions& options) {
  if (world.dimension != 2) ThrowError("pictures are of plane worlds, this one has dimension {}", world.dimension);
  if (roadmap && table && static_cast<int>(table->cost.size()) != roadmap->num_vertices()) {
    ThrowError("picture: cost table of {} vertices, roadmap of {}", table->cost.size(), roadmap->num_vertices());
  }
  PictureOptions fitted = options;  // a corridor is drawn narrower, not a kilometre high
  const double aspect = world.bounds.size().y() / world.bounds.size().x();
  fitted.width = options.width * std::min(1.0, kMaxAspect / aspect);
  return Painter(world, roadmap, table, fitted).Paint(trajectories);
}

}  // namespace cairn::planner
