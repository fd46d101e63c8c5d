cairn_add_benchmark(learner
  SOURCES fma_peak.cc learner_benchmark.cc
  LIBS cairn_learner)
