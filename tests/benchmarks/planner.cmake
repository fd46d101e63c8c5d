cairn_add_benchmark(planner
  SOURCES planner_benchmark.cc ../planner/any_angle.cc ../planner/cost_error.cc
  LIBS cairn_planner cairn_planner_service cairn_config cairn_roadmap cairn_world benchmark::benchmark_main)
