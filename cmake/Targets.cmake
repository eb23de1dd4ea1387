# impedraw_library(NAME SOURCES … LINKS …): a folder of src as the target impedraw::NAME.
# Headers are included as #include "impedraw/control/impedance.h", in the tree as in an installed copy: build/…/include/impedraw is a link
# to src.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/include)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/src ${PROJECT_BINARY_DIR}/include/impedraw SYMBOLIC)

function(impedraw_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(ARG_SOURCES)
    add_library(impedraw_${name} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    impedraw_warnings(impedraw_${name})
    target_link_libraries(impedraw_${name} PRIVATE ${ARG_PRIVATE_LINKS})
  else()
    add_library(impedraw_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(impedraw::${name} ALIAS impedraw_${name})
  target_include_directories(impedraw_${name} ${scope} $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(impedraw_${name} ${scope} ${ARG_LINKS})
endfunction()

# impedraw_test(NAME SOURCES … LINKS …): one GoogleTest program, run by ctest from the root of the tree.
function(impedraw_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  find_package(GTest REQUIRED)
  add_executable(${name} ${ARG_SOURCES})
  impedraw_warnings(${name})
  target_compile_options(${name} PRIVATE -O1)  # what is tested is compiled as ever; the tests themselves need not be fast
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} GTest::gtest_main GTest::gmock)
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()

function(impedraw_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-maybe-uninitialized)  # the last one: false alarms inside Eigen
endfunction()
