cairn_add_benchmark(learner
  SOURCES fma_peak.cc learner_benchmark.cc
  LIBS cairn_bus cairn_learner)

# The same updates in libtorch: apt-get install libtorch-dev libopenblas0-pthread libopenblas-dev.
option(CAIRN_BENCH_TORCH "Compare the learner's updates with libtorch's in cairn-bench-learner" OFF)
if(CAIRN_BENCH_TORCH)
  find_library(TORCH_LIBRARY torch REQUIRED)
  find_library(TORCH_CPU_LIBRARY torch_cpu REQUIRED)
  find_library(C10_LIBRARY c10 REQUIRED)
  find_library(OPENBLAS_LIBRARY openblas REQUIRED)
  find_path(TORCH_INCLUDE_DIR torch/csrc/api/include/torch/torch.h REQUIRED)
  target_sources(cairn-bench-learner PRIVATE torch_update.cc)
  # The engine's headers keep their own warnings.
  set_source_files_properties(torch_update.cc PROPERTIES COMPILE_OPTIONS -w
                              INCLUDE_DIRECTORIES ${TORCH_INCLUDE_DIR}/torch/csrc/api/include)
  target_compile_definitions(cairn-bench-learner PRIVATE CAIRN_BENCH_TORCH)
  # Before libxsmm's stub of BLAS, which would take its place.
  target_link_options(cairn-bench-learner BEFORE PRIVATE -Wl,--no-as-needed ${OPENBLAS_LIBRARY} -Wl,--as-needed)
  target_link_libraries(cairn-bench-learner PRIVATE ${TORCH_CPU_LIBRARY} ${C10_LIBRARY} ${CMAKE_DL_LIBS})
endif()
