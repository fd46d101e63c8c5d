cairn_add_benchmark(vehicles
  SOURCES episode_tapes.cc fma_peak.cc vehicles_benchmark.cc
  LIBS cairn_actors cairn_config cairn_ode cairn_testing)

# The same scenes in Bullet, where libbullet-dev is installed.
pkg_check_modules(BULLET IMPORTED_TARGET bullet)
if(BULLET_FOUND)
  cairn_system_library(cairn_bullet INCLUDES ${BULLET_INCLUDE_DIRS} LIBS PkgConfig::BULLET)
  target_sources(cairn-bench-vehicles PRIVATE bullet_scene.cc)
  target_compile_definitions(cairn-bench-vehicles PRIVATE CAIRN_BENCH_BULLET)
  target_link_libraries(cairn-bench-vehicles PRIVATE cairn_bullet)
endif()
