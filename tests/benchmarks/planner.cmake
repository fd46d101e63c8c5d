cairn_add_benchmark(planner
  SOURCES planner_benchmark.cc
  LIBS cairn_planner cairn_planner_service cairn_roadmap cairn_world benchmark::benchmark_main)
