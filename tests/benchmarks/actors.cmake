cairn_add_benchmark(actors
  SOURCES actors_benchmark.cc
  LIBS cairn_actors cairn_testing)
