cairn_add_benchmark(company SOURCES company_benchmark.cc LIBS cairn_config cairn_learner_process)
target_compile_definitions(cairn-bench-company PRIVATE CAIRN_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
add_dependencies(cairn-bench-company cairn-actor cairn-planner)
