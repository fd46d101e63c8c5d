cairn_add_benchmark(bus SOURCES bus_benchmark.cc LIBS cairn_bus cairn_test_broker)
