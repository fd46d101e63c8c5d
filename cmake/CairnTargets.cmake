# Compiler settings shared by every target, and the three verbs that declare targets.

add_library(cairn_options INTERFACE)
target_include_directories(cairn_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(cairn_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
                       # One rounding per written operation, so that scalar and vector code give the same bits.
                       -ffp-contract=off -fno-math-errno
                       # LCM's and GLib's pkg-config files ask for it, and all files must agree on it (_REENTRANT).
                       -pthread)
if(CAIRN_WERROR)
  target_compile_options(cairn_options INTERFACE -Werror)
endif()
if(CAIRN_ARCH)
  target_compile_options(cairn_options INTERFACE -march=${CAIRN_ARCH})
endif()
if(CAIRN_SANITIZE)
  # GCC 12 warns, wrongly, of what the sanitizers make of <regex> and std::string.
  target_compile_options(cairn_options INTERFACE -fsanitize=${CAIRN_SANITIZE} -fno-omit-frame-pointer
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-error>)
  target_link_options(cairn_options INTERFACE -fsanitize=${CAIRN_SANITIZE})
endif()

if(CAIRN_FUZZ)
  target_compile_options(cairn_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# What nearly every file reads, parsed once: two thirds of a build's time. The fenced engines stay out of it. A file that
# has compile options of its own says SKIP_PRECOMPILE_HEADERS; CMAKE_DISABLE_PRECOMPILE_HEADERS shows missing includes.
# clang refuses them for targets whose visibility differs, as OMPL's users' does.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(CAIRN_HEADERS <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <mutex>
    <optional> <random> <span> <string> <string_view> <thread> <utility> <vector> <fmt/format.h> <Eigen/Core>)
set(pch_source ${CMAKE_BINARY_DIR}/generated/precompiled.cc)
file(CONFIGURE OUTPUT ${pch_source} CONTENT "")
add_library(cairn_headers OBJECT ${pch_source})
target_link_libraries(cairn_headers PRIVATE cairn_options fmt::fmt Threads::Threads cairn_eigen)
target_precompile_headers(cairn_headers PRIVATE ${CAIRN_HEADERS})
if(CAIRN_BUILD_TESTS)
  # Programs are compiled with -fPIE, libraries with -fPIC: not the same to a precompiled header.
  add_library(cairn_test_headers OBJECT ${pch_source})
  set_target_properties(cairn_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(cairn_test_headers PRIVATE -fPIE)
  target_link_libraries(cairn_test_headers PRIVATE cairn_options fmt::fmt Threads::Threads cairn_eigen GTest::gtest GTest::gmock)
  target_precompile_headers(cairn_test_headers PRIVATE ${CAIRN_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
endif()

# cairn_add_library(NAME SOURCES … [PUBLIC lib …] [PRIVATE lib …] [OPTIONS compile option …])
# One with options of its own reads no precompiled header: that brings along the options with which it was made, and GCC
# takes others (-fno-trapping-math) back without a word.
function(cairn_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE;OPTIONS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC cairn_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  if(ARG_OPTIONS)
    target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  else()
    target_precompile_headers(${name} REUSE_FROM cairn_headers)
  endif()
endfunction()

# cairn_add_binary(NAME SOURCES … LIBS lib …)
function(cairn_add_binary name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE cairn_options cairn_cpu_check ${ARG_LIBS})
  install(TARGETS ${name} RUNTIME DESTINATION bin)
endfunction()

# cairn_add_test(NAME SOURCES … LIBS lib …): one GoogleTest program for one folder.
function(cairn_add_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE cairn_options ${ARG_LIBS} GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE CAIRN_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
  target_precompile_headers(${name} REUSE_FROM cairn_test_headers)
endfunction()

# cairn_add_network_test(NAME SOURCES … LIBS lib …): the same in a private network namespace; exit status 77 skips.
function(cairn_add_network_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES} ${CMAKE_SOURCE_DIR}/tests/testing/private_network_main.cc)
  target_link_libraries(${name} PRIVATE cairn_options ${ARG_LIBS} cairn_deploy GTest::gtest GTest::gmock)
  target_compile_definitions(${name} PRIVATE CAIRN_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                             CAIRN_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300 SKIP_RETURN_CODE 77)
  target_precompile_headers(${name} REUSE_FROM cairn_test_headers)
endfunction()

# cairn_add_benchmark(PART SOURCES … LIBS lib …): the program cairn-bench-PART.
function(cairn_add_benchmark part)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(cairn-bench-${part} ${ARG_SOURCES})
  target_link_libraries(cairn-bench-${part} PRIVATE cairn_options ${ARG_LIBS} benchmark::benchmark)
  target_compile_definitions(cairn-bench-${part} PRIVATE CAIRN_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
endfunction()
