// World, roadmap and planner on the paper's car maze with the recipe's settings.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

#include "common/bus/goal_table_client.h"
#include "common/config/experiment.h"
#include "common/core/check.h"
#include "common/core/random.h"
#include "common/roadmap/roadmap_lookup.h"
#include "common/world/distance_field.h"
#include "common/world/obstacle_grid.h"
#include "common/world/reachability.h"
#include "planner/collision/swept_sphere_checker.h"
#include "planner/planner.h"
#include "planner/repair.h"
#include "planner/roadmap_service.h"
#include "tests/planner/cost_error.h"
#include "tests/planner/cost_worlds.h"

namespace cairn {
namespace {

using planner::CostWorld;
using planner::RecipeWorld;
using planner::RoomsFloor;

constexpr double kInscribed = 0.025;  // of the paper's car [m]
constexpr size_t kQueries = 4096;     // a power of two

struct Maze {
  World world = MakeWorld(WorldConfig{});
  DistanceField field{world, WorldConfig{}.field_resolution};
  std::vector<Vector3d> points;  // uniform, at least 0.03 m from walls

  Maze() {
    RandomStream random(1, RandomPurpose::kTest);
    while (points.size() < kQueries) {
      const double side = world.bounds.max.x();
      const Vector3d p(random.Uniform(0, side), random.Uniform(0, side), 0);
      if (field.Distance(p) >= 0.03) points.push_back(p);
    }
  }
};

const Maze& SharedMaze() {
  static const Maze maze;
  return maze;
}

PlannerConfig Config(int spacing_mm) {
  PlannerConfig config;
  config.min_spacing = 0.001 * spacing_mm;
  return config;
}

RoadmapLookup MakeLookup(int spacing_mm) {
  const Maze& maze = SharedMaze();
  const planner::BuiltRoadmap built = planner::BuildRoadmap(maze.world, maze.field, Config(spacing_mm), kInscribed);
  return RoadmapLookup(2, built.roadmap.positions,
                       planner::ComputeCostTable(built.roadmap, maze.world, maze.world.goal), 0.05,
                       built.roadmap.num_bends);
}

void WorldField(benchmark::State& state) {
  const World world = MakeWorld(WorldConfig{});
  for (auto _ : state) benchmark::DoNotOptimize(DistanceField(world, 0.001 * state.range(0)));
}
BENCHMARK(WorldField)->Name("world/field_build/resolution_mm")->Arg(5)->Arg(2)->Unit(benchmark::kMillisecond);

void FieldQuery(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(maze.field.Distance(maze.points[i++ % kQueries]));
}
BENCHMARK(FieldQuery)->Name("world/field_query");

void Scan(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  const ObstacleGrid grid(maze.world, 0.044);
  const auto beams = static_cast<int>(state.range(0));
  std::vector<std::pair<double, double>> directions;
  for (int k = 0; k < beams; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.3) / beams;
    directions.emplace_back(std::cos(angle), std::sin(angle));
  }
  size_t i = 0;
  for (auto _ : state) {
    const Vector3d& p = maze.points[i++ % kQueries];
    double sum = 0;
    for (const auto& [x, y] : directions) sum += grid.CastRay(p.x(), p.y(), x, y, 0.4);
    benchmark::DoNotOptimize(sum);
  }
}
BENCHMARK(Scan)->Name("world/scan/beams")->Arg(16);

void Overlap(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  const ObstacleGrid grid(maze.world, 0.044);
  const Footprint car{0.035, 0.025};
  size_t i = 0;
  for (auto _ : state) {
    const Vector3d& p = maze.points[i++ % kQueries];
    benchmark::DoNotOptimize(grid.Overlaps(p.x(), p.y(), 0.01 * static_cast<double>(i % 628), car));
  }
}
BENCHMARK(Overlap)->Name("world/footprint_overlap");

void Reach(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  for (auto _ : state) benchmark::DoNotOptimize(Reachability(maze.world, maze.field, 0.03));
}
BENCHMARK(Reach)->Name("world/reachability")->Unit(benchmark::kMillisecond);

// Capsules of the roadmap's edges.
void CapsuleCheck(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  const planner::SweptSphereChecker checker(maze.world, 0.03);
  RandomStream random(2, RandomPurpose::kTest);
  std::vector<Vector3d> ends;
  for (const Vector3d& p : maze.points) {
    const double angle = random.Uniform(0, 2 * std::numbers::pi), length = random.Uniform(0.05, 0.1);
    ends.push_back(p + length * Vector3d(std::cos(angle), std::sin(angle), 0));
  }
  size_t i = 0, free = 0;
  for (auto _ : state) {
    free += checker.MotionFree(maze.points[i % kQueries], ends[i % kQueries]);
    ++i;
  }
  state.counters["share_free"] = static_cast<double>(free) / static_cast<double>(i);
}
BENCHMARK(CapsuleCheck)->Name("planner/capsule_check");

void RoadmapBuild(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  planner::BuildInfo info;
  for (auto _ : state) {
    info = planner::BuildRoadmap(maze.world, maze.field, Config(static_cast<int>(state.range(0))), kInscribed).info;
  }
  state.counters["V"] = info.vertices;
  state.counters["E"] = info.edges;
  state.counters["samples"] = info.samples;
  state.counters["coverage"] = info.coverage;
}
BENCHMARK(RoadmapBuild)
    ->Name("planner/roadmap_build/spacing_mm")
    ->Arg(50)
    ->Arg(25)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond);

void Table(benchmark::State& state) {
  const Maze& maze = SharedMaze();
  const planner::BuiltRoadmap built =
      planner::BuildRoadmap(maze.world, maze.field, Config(static_cast<int>(state.range(0))), kInscribed);
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner::ComputeCostTable(built.roadmap, maze.world, maze.world.goal));
  }
  state.counters["V"] = built.info.vertices;
  state.counters["E"] = built.info.edges;
}
BENCHMARK(Table)->Name("planner/cost_table/spacing_mm")->Arg(50)->Arg(10)->Unit(benchmark::kMillisecond);

// The recipes' worlds at default density: how much longer ways along the roadmap are than the shortest ones.
CostWorld MakeScene(int64_t number) {
  if (number == 0) return RoomsFloor(3);
  return number > 0 ? RecipeWorld("car_maze.textproto", static_cast<int>(number))
                    : RecipeWorld("quadrotor_maze.textproto", static_cast<int>(-number));
}

void CostErrors(benchmark::State& state) {
  const CostWorld scene = MakeScene(state.range(0));
  planner::BuiltRoadmap built;
  planner::CostError error;
  for (auto _ : state) {
    built = scene.Build();
    error = planner::MeasureCosts(scene, built.roadmap, 400);
  }
  state.counters["mean_error"] = error.mean;
  state.counters["largest_error"] = error.largest;
  state.counters["smallest_error"] = error.smallest;
  state.counters["build_s"] = built.info.build_s;
  state.counters["V"] = built.info.vertices;
  state.counters["bends"] = built.info.bends;
  state.counters["E"] = built.info.edges;
}
BENCHMARK(CostErrors)
    ->Name("planner/cost_error/car_maze_seed")
    ->Arg(1)
    ->Arg(2)
    ->Arg(11)
    ->Arg(12)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(CostErrors)->Name("planner/cost_error/floor")->Arg(0)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(CostErrors)
    ->Name("planner/cost_error/cube_minus_seed")
    ->Arg(-1)
    ->Arg(-21)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void ThroughWalls(benchmark::State& state) {
  const CostWorld scene = MakeScene(state.range(0));
  const Roadmap roadmap = scene.Build().roadmap;
  int read = 0, finite = 0;
  for (auto _ : state) read = planner::CountReadThroughWalls(scene, roadmap, 100000, &finite);
  state.counters["read_through_walls"] = read;
  state.counters["finite"] = finite;
}
BENCHMARK(ThroughWalls)
    ->Name("planner/through_walls_of_100000/scene")
    ->Arg(1)
    ->Arg(0)
    ->Arg(-1)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// Mazes so large that their roadmaps have about 8,000 vertices at default density; dimension as argument.
struct Large {
  CostWorld scene;
  Roadmap roadmap;

  explicit Large(int64_t dimension) {
    scene = dimension == 2 ? RecipeWorld("car_maze.textproto", 1, {"world.cells=33"})
                           : RecipeWorld("quadrotor_maze.textproto", 1, {"world.floors=5", "world.rooms=5"});
    roadmap = scene.Build().roadmap;
  }
  void Count(benchmark::State& state) const {
    state.counters["V"] = roadmap.num_vertices();
    state.counters["bends"] = roadmap.num_bends;
    state.counters["E"] = roadmap.num_edges();
  }
};

void LargeTable(benchmark::State& state) {
  const Large large(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner::ComputeCostTable(large.roadmap, large.scene.world, large.scene.world.goal));
  }
  large.Count(state);
}
BENCHMARK(LargeTable)->Name("planner/table_of_8000/dimension")->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

// An unknown obstacle of the size of a door is marked, its edges are cut, the goal's table is computed anew.
void Repair(benchmark::State& state) {
  const Large large(state.range(0));
  const World& world = large.scene.world;
  const Vector3d middle = world.bounds.center();
  const std::vector<Box> marks{{middle, middle + 0.14 * Vector3d::Ones()}};
  int cut = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Roadmap blocked = large.roadmap;
    state.ResumeTiming();
    cut = planner::BlockEdges(marks, large.scene.config.radius, &blocked);
    benchmark::DoNotOptimize(planner::ComputeCostTable(blocked, world, world.goal));
  }
  large.Count(state);
  state.counters["cut"] = cut;
}
BENCHMARK(Repair)->Name("planner/repair_of_8000/dimension")->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

void CostToGo(benchmark::State& state) {
  const RoadmapLookup lookup = MakeLookup(static_cast<int>(state.range(0)));
  const Maze& maze = SharedMaze();
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lookup.CostToGo(maze.points[i++ % kQueries]));
  state.counters["V"] = lookup.num_vertices();
}
BENCHMARK(CostToGo)->Name("roadmap/cost_to_go/spacing_mm")->Arg(50)->Arg(10);

// The yardstick of the above: all vertices, float arithmetic, vectorised by the compiler.
void CostToGoBruteForce(benchmark::State& state) {
  const RoadmapLookup lookup = MakeLookup(static_cast<int>(state.range(0)));
  const Maze& maze = SharedMaze();
  std::vector<float> x, y;
  for (int v = 0; v < lookup.num_vertices(); ++v) {  // bends too: they are what the lookup has to skip
    x.push_back(static_cast<float>(lookup.position(v).x()));
    y.push_back(static_cast<float>(lookup.position(v).y()));
  }
  const std::vector<float>& cost = lookup.table().cost;
  size_t i = 0;
  for (auto _ : state) {
    const auto px = static_cast<float>(maze.points[i % kQueries].x());
    const auto py = static_cast<float>(maze.points[i % kQueries].y());
    ++i;
    float best = kUnreachable;
    for (size_t v = 0; v < x.size(); ++v) {
      const float dx = x[v] - px, dy = y[v] - py;
      const float here = dx * dx + dy * dy <= 0.0025f ? cost[v] : kUnreachable;
      best = here < best ? here : best;
    }
    benchmark::DoNotOptimize(best);
  }
}
BENCHMARK(CostToGoBruteForce)->Name("roadmap/cost_to_go_brute_force/spacing_mm")->Arg(50)->Arg(10);

void LookAhead(benchmark::State& state) {
  const RoadmapLookup lookup = MakeLookup(50);
  const Maze& maze = SharedMaze();
  size_t i = 0;
  for (auto _ : state) {
    const Vector3d& p = maze.points[i++ % kQueries];
    const int entry = lookup.EntryVertex(p, maze.field, 0.015);
    benchmark::DoNotOptimize(lookup.PointAlong(p, entry, 0.12));
    benchmark::DoNotOptimize(lookup.PointAlong(p, entry, 0.30));
  }
}
BENCHMARK(LookAhead)->Name("roadmap/look_ahead_two_points");

// Goal tables over real LCM, from the request to the decoded table: a service in one thread, an actor's client in
// another, every goal another one, so that each is computed. `tables_per_s` counts them. Needs a multicast route:
// unshare -rn sh -c 'ip link set lo up; ip route add 224.0.0.0/4 dev lo; cairn-bench-planner --benchmark_filter=served'
void TablesServed(benchmark::State& state) {
  constexpr int kTables = 500;
  Experiment experiment;
  experiment.goals = Goals::kAny;
  experiment.planner = Config(static_cast<int>(state.range(0)));
  const BusConfig config{"239.255.76.67", 23100, 0, 1, RandomId(), std::nullopt};
  try {
    BusConfig other = config;
    other.session = RandomId();
    Bus planner_bus(config), client_bus(other);
    planner::RoadmapService service(&planner_bus, 1, experiment);
    std::jthread planner([&](const std::stop_token& stop) { service.Run([&] { return stop.stop_requested(); }); });
    int64_t come = 0, vertices = 0;
    GoalTableClient client(&client_bus, 1, [&](const WorldGoal&, const Roadmap& positions, const CostTable&) {
      ++come;
      vertices = positions.num_vertices();
    });
    client_bus.CheckPlanes();
    const Maze& maze = SharedMaze();
    const Vector3d half(0.05, 0.05, 0);
    const auto pull = [&](const Vector3d& p) { client.Want({1, {p - half, p + half}}); };
    const auto wait = [&] {
      const TimePoint end = Clock::now() + std::chrono::seconds(30);
      while (!client.idle() && Clock::now() < end) {
        client.Poll(Clock::now());
        client_bus.Poll(std::chrono::milliseconds(1));
      }
      return client.idle();
    };
    pull(maze.points.back());  // with it the roadmap's positions
    if (!wait()) return state.SkipWithError("the first table did not come");
    come = 0;
    size_t next = 0;
    for (auto _ : state) {
      for (int i = 0; i < kTables; ++i, ++next) {
        pull(maze.points[next % kQueries] + 1e-6 * Vector3d(static_cast<double>(next), 0, 0));
      }
      if (!wait()) return state.SkipWithError("a table did not come");
    }
    state.counters["tables_per_s"] = benchmark::Counter(static_cast<double>(come), benchmark::Counter::kIsRate);
    state.counters["V"] = static_cast<double>(vertices);
  } catch (const Error& error) {
    state.SkipWithError(error.what());
  }
}
BENCHMARK(TablesServed)
    ->Name("planner/tables_served/spacing_mm")
    ->Arg(50)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace cairn
