cairn_add_benchmark(run SOURCES run_benchmark.cc LIBS nlohmann_json::nlohmann_json)
target_compile_definitions(cairn-bench-run PRIVATE CAIRN_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
add_dependencies(cairn-bench-run cairn cairn-actor cairn-learner cairn-planner)
