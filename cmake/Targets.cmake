# impedraw_library(NAME SOURCES … LINKS … PRIVATE_LINKS … BLIND_TO …): a folder of src as impedraw::NAME.
# BLIND_TO: libraries whose headers none of its files may include, though others that it links do.
# Headers are included as #include "impedraw/control/impedance.h", in the tree as in an installed
# copy: include/impedraw is a link to src, which a source distribution lacks.
if(NOT EXISTS ${PROJECT_SOURCE_DIR}/include/impedraw)
  file(MAKE_DIRECTORY ${PROJECT_SOURCE_DIR}/include)
  file(CREATE_LINK ../src ${PROJECT_SOURCE_DIR}/include/impedraw SYMBOLIC)
endif()

set(IMPEDRAW_LESS_OPTIMISED $<$<CONFIG:Release>:-O1>)
set(IMPEDRAW_MORE_OPTIMISED $<$<CONFIG:Release>:-O3>)
# A precompiled header must be compiled with the same -m options as what includes it: from g++ 13 on, x86's -O2 sets these two.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13 AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  list(APPEND IMPEDRAW_LESS_OPTIMISED $<$<CONFIG:Release>:-munroll-only-small-loops> $<$<CONFIG:Release>:-mvzeroupper>)
endif()

function(impedraw_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS;BLIND_TO" ${ARGN})
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
  set_property(GLOBAL APPEND PROPERTY IMPEDRAW_LIBRARIES ${name})
  set_property(GLOBAL PROPERTY IMPEDRAW_BLIND_${name} ${ARG_BLIND_TO})
  target_include_directories(impedraw_${name} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(impedraw_${name} ${scope} ${ARG_LINKS})
  # Many small units share their headers and Eigen's templates: together they compile in less than half
  # the time. Names in unnamed namespaces are therefore unique within a folder. More than fourteen at a
  # time take more memory, and are hardly faster. control, sensing and arm stay apart: what is inlined
  # in a step counts there, and who links sensing needs fmt only where it identifies touches.
  if(ARG_SOURCES AND NOT name MATCHES "^(control|sensing|arm)$")
    impedraw_compile_together(impedraw_${name} 14)
  endif()
  # What runs once in a call, or waits for files, sockets and processes, is not worth the optimiser's time. A control step
  # is: with -O3 it takes a tenth less.
  set(level "")
  set(headers library)
  if(name MATCHES "^(settings|terminal|files|experiment|page|judge|live|app)$")
    set(level ${IMPEDRAW_LESS_OPTIMISED})
    set(headers less_optimised)
  elseif(name MATCHES "^(control|sensing|arm|ink)$")
    set(level ${IMPEDRAW_MORE_OPTIMISED})
    set(headers eigen)
  endif()
  if(NOT ARG_SOURCES)
    return()
  endif()
  target_compile_options(impedraw_${name} PRIVATE ${level})
  # A folder without fmt is one that people use without the rest: it compiles with Eigen alone.
  if(TARGET impedraw_${headers}_headers AND (headers STREQUAL "eigen" OR "fmt::fmt" IN_LIST ARG_PRIVATE_LINKS))
    target_precompile_headers(impedraw_${name} REUSE_FROM impedraw_${headers}_headers)
  endif()
endfunction()

# Refuses a header that includes all of nlohmann/json, and an include that runs upwards: a library's files may include headers of the library itself
# and of those that it links. A header belongs to the library that compiles the source beside it; one
# without a source, to the library named as the folder.
function(impedraw_check_layers)
  get_property(libraries GLOBAL PROPERTY IMPEDRAW_LIBRARIES)
  foreach(name ${libraries})
    get_target_property(folder impedraw_${name} SOURCE_DIR)
    get_target_property(sources impedraw_${name} SOURCES)
    foreach(source ${sources})
      string(REGEX REPLACE "\\.(cc|h)$" "" stem "${source}")
      cmake_path(ABSOLUTE_PATH stem BASE_DIRECTORY ${folder} NORMALIZE)
      cmake_path(RELATIVE_PATH stem BASE_DIRECTORY ${PROJECT_SOURCE_DIR}/src)
      set(owner_of_${stem} ${name})
    endforeach()
  endforeach()
  # Libraries are listed in the order of their folders, so that what a library links is complete.
  file(GLOB_RECURSE files RELATIVE ${PROJECT_SOURCE_DIR}/src
    ${PROJECT_SOURCE_DIR}/src/*.h ${PROJECT_SOURCE_DIR}/src/*.cc)
  foreach(name ${libraries})
    set(sees_${name} ${name})
    foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
      get_target_property(links impedraw_${name} ${property})
      foreach(link ${links})
        if(link MATCHES "^impedraw::(.*)")
          list(APPEND sees_${name} ${CMAKE_MATCH_1} ${sees_${CMAKE_MATCH_1}})
        endif()
      endforeach()
    endforeach()
  endforeach()
  foreach(file ${files})
    impedraw_owner(${file} owner)
    if(NOT TARGET impedraw_${owner})
      continue()
    endif()
    file(STRINGS ${PROJECT_SOURCE_DIR}/src/${file} includes REGEX "^#include [\"<](impedraw/|nlohmann/json.hpp)")
    foreach(include ${includes})
      if(include MATCHES "nlohmann")
        if(file MATCHES "\\.h$")
          message(FATAL_ERROR "src/${file} includes nlohmann/json.hpp, 1 s for each unit that includes it; "
            "a header needs nlohmann/json_fwd.hpp")
        endif()
        continue()
      endif()
      string(REGEX REPLACE "^#include \"impedraw/(.*)\".*" "\\1" header "${include}")
      impedraw_owner(${header} seen)
      get_property(blind GLOBAL PROPERTY IMPEDRAW_BLIND_${owner})
      if(seen IN_LIST blind)
        message(FATAL_ERROR "src/${file} includes ${header}: impedraw::${owner} is blind to impedraw::${seen}")
      endif()
      if(seen AND NOT seen IN_LIST sees_${owner} AND NOT seen STREQUAL "usvg")  # built_alike.h is nobody's
        message(FATAL_ERROR "src/${file} includes ${header}, which belongs to impedraw::${seen}; "
          "impedraw::${owner} does not link it")
      endif()
    endforeach()
  endforeach()
endfunction()

# In the scope of impedraw_check_layers: the library that a file of src belongs to.
macro(impedraw_owner file result)
  string(REGEX REPLACE "\\.(cc|h)$" "" stem "${file}")
  if(DEFINED owner_of_${stem})
    set(${result} ${owner_of_${stem}})
  else()
    cmake_path(GET stem PARENT_PATH ${result})
    if(NOT EXISTS ${PROJECT_SOURCE_DIR}/src/${${result}}/CMakeLists.txt)  # planning/path
      cmake_path(GET ${result} PARENT_PATH ${result})
    endif()
    cmake_path(GET ${result} FILENAME ${result})
  endif()
endmacro()

# impedraw_extra_test(NAME): tests/NAME/*.py by pytest, in the environment that setup/extra.sh NAME makes.
function(impedraw_extra_test name)
  add_test(NAME ${name}_venv COMMAND bash ${PROJECT_SOURCE_DIR}/setup/extra.sh ${name})
  set_tests_properties(${name}_venv PROPERTIES FIXTURES_SETUP ${name}_venv LABELS unit)
  add_test(NAME ${name}_test
    COMMAND ${PROJECT_SOURCE_DIR}/build/${name}-venv/bin/python -P -m pytest -q -p no:cacheprovider .
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  set_tests_properties(${name}_test PROPERTIES FIXTURES_REQUIRED ${name}_venv LABELS unit TIMEOUT 600
    ENVIRONMENT "OMP_NUM_THREADS=1;PYTHONDONTWRITEBYTECODE=1")
endfunction()

# impedraw_test(NAME SOURCES … UNSHARED … LINKS … [LABEL unit|simulation|cli]): one GoogleTest program, run by
# ctest from the root of the tree. Labels: unit (the default) simulates no arm; simulation does; cli
# starts the program. A test is left out where IMPEDRAW_PARTS leaves out a library that it links.
function(impedraw_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;UNSHARED;LINKS" ${ARGN})
  foreach(link ${ARG_LINKS})
    if(IMPEDRAW_PARTS AND link MATCHES "^impedraw::" AND NOT TARGET ${link})
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
  impedraw_compile_together(${name} 4 ${ARG_UNSHARED})
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL})
endfunction()

# Compiles the sources of a target `batch` at a time, except those that follow.
function(impedraw_compile_together target batch)
  if(IMPEDRAW_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
    if(ARGN)
      set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endif()
endfunction()

# Leaves cases of a test program out of a build with sanitizers: a GoogleTest pattern for each.
function(impedraw_skip_under_sanitizers name)
  if(IMPEDRAW_FUZZ AND TARGET ${name})
    list(JOIN ARGN ":" patterns)
    set_tests_properties(${name} PROPERTIES ENVIRONMENT "GTEST_FILTER=-${patterns}")
  endif()
endfunction()

function(impedraw_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)  # false alarms inside Eigen
    if(CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12)  # and, since then, where sources are compiled together
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
endfunction()
