# impedraw_library(NAME SOURCES … LINKS … PRIVATE_LINKS …): a folder of src as impedraw::NAME.
# Headers are included as #include "impedraw/control/impedance.h", in the tree as in an installed
# copy: build/…/include/impedraw is a link to src.
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
  # A folder without fmt is one that people use without the rest: it compiles without our headers.
  if(TARGET impedraw_library_headers AND ARG_SOURCES AND "fmt::fmt" IN_LIST ARG_PRIVATE_LINKS)
    target_precompile_headers(impedraw_${name} REUSE_FROM impedraw_library_headers)
  endif()
endfunction()

# impedraw_test(NAME SOURCES … LINKS … [LABEL unit|simulation|cli]): one GoogleTest program, run by
# ctest from the root of the tree. Labels: unit (the default) simulates no arm; simulation does; cli
# starts the program. A test is left out where IMPEDRAW_PARTS leaves out a library that it links.
function(impedraw_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;LINKS" ${ARGN})
  foreach(link ${ARG_LINKS})
    if(link MATCHES "^impedraw::" AND NOT TARGET ${link})
      return()
    endif()
  endforeach()
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  find_package(GTest REQUIRED)
  add_executable(${name} ${ARG_SOURCES})
  impedraw_warnings(${name})
  target_compile_options(${name} PRIVATE -O1)  # what is tested is compiled as ever; the tests themselves need not be fast
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} fmt::fmt GTest::gtest_main GTest::gmock)
  if(TARGET impedraw_test_headers)
    target_precompile_headers(${name} REUSE_FROM impedraw_test_headers)
  endif()
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL})
endfunction()

function(impedraw_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)  # false alarms inside Eigen
  endif()
endfunction()
