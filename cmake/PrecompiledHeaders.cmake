# Precompiles Eigen, fmt and the standard library, which saves about 2 s of 5.5 s per unit. A compiler
# accepts a precompiled header only with the flags that it was made with, so tests have a set of
# their own. The folders that people use without the rest have one with Eigen alone. Off with a
# compiler launcher: ccache does not cache a unit with a precompiled header.
if(CMAKE_CXX_COMPILER_LAUNCHER OR NOT CMAKE_CXX_COMPILER_ID MATCHES "^(GNU|Clang)$")
  set(precompile OFF)
else()
  set(precompile ON)
endif()
option(IMPEDRAW_PRECOMPILED_HEADERS "Precompile the headers that most units include" ${precompile})

set(IMPEDRAW_COMMON_HEADERS
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <fmt/format.h>
  <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <optional> <string> <vector>)
if(IMPEDRAW_PRECOMPILED_HEADERS)
  set(empty ${PROJECT_BINARY_DIR}/precompiled/empty.cc)
  file(CONFIGURE OUTPUT ${empty} CONTENT "int main() {}\n")

  # g++ takes the level of optimisation from the header, whatever it is told beside it.
  foreach(set library less_optimised)
    add_library(impedraw_${set}_headers OBJECT EXCLUDE_FROM_ALL ${empty})
    target_link_libraries(impedraw_${set}_headers PRIVATE Eigen3::Eigen fmt::fmt)
    target_precompile_headers(impedraw_${set}_headers PRIVATE ${IMPEDRAW_COMMON_HEADERS})
  endforeach()
  target_compile_options(impedraw_less_optimised_headers PRIVATE ${IMPEDRAW_LESS_OPTIMISED})

  add_library(impedraw_eigen_headers OBJECT EXCLUDE_FROM_ALL ${empty})
  target_compile_options(impedraw_eigen_headers PRIVATE ${IMPEDRAW_MORE_OPTIMISED})
  target_link_libraries(impedraw_eigen_headers PRIVATE Eigen3::Eigen)
  target_precompile_headers(impedraw_eigen_headers PRIVATE
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/SVD>)

  if(NOT SKBUILD)
    find_package(GTest REQUIRED)
    add_executable(impedraw_test_headers EXCLUDE_FROM_ALL ${empty})  # as tests are: -fPIE
    target_compile_options(impedraw_test_headers PRIVATE -O1)
    target_link_libraries(impedraw_test_headers PRIVATE Eigen3::Eigen fmt::fmt GTest::gtest GTest::gmock)
    target_precompile_headers(impedraw_test_headers PRIVATE
      ${IMPEDRAW_COMMON_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
  endif()
endif()
