cairn_add_benchmark(actors
  SOURCES actors_benchmark.cc episode_tapes.cc
  LIBS cairn_actors cairn_testing)
