# What people use without the program. `cmake --install build/release --component library --prefix …`
# copies it, and find_package(impedraw COMPONENTS …) finds it there. Without COMPONENTS it gives
# impedraw::common, impedraw::control and impedraw::sensing, which need Eigen alone. The others bring
# needs of their own, listed in impedraw-config.cmake.in.
include(CMakePackageConfigHelpers)
include(CheckCXXSourceCompiles)
include(GNUInstallDirs)

# What Eigen aligns to hangs on the compiler's flags, and with it where members stand and how memory is freed: a program with -march=native
# on a library without would corrupt its memory. So every target that links the library compiles a check that both were built alike.
set(IMPEDRAW_EIGEN_ALIGNMENT 16)
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
foreach(bytes 32 64)
  check_cxx_source_compiles("#include <Eigen/Core>
    static_assert(EIGEN_DEFAULT_ALIGN_BYTES == ${bytes});
    int main() {}" EIGEN_ALIGNS_TO_${bytes})
  if(EIGEN_ALIGNS_TO_${bytes})
    set(IMPEDRAW_EIGEN_ALIGNMENT ${bytes})
  endif()
endforeach()
unset(CMAKE_REQUIRED_LIBRARIES)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/impedraw)
set(include_dir ${CMAKE_INSTALL_INCLUDEDIR}/impedraw)
set(generated ${PROJECT_BINARY_DIR}/package)

# impedraw_install(SET LIBRARIES …): exports libraries to impedraw-SET.cmake.
function(impedraw_install set)
  foreach(library ${ARGN})
    set_target_properties(impedraw_${library} PROPERTIES EXPORT_NAME ${library})
    install(TARGETS impedraw_${library} EXPORT impedraw_${set} COMPONENT library)
  endforeach()
  install(EXPORT impedraw_${set} NAMESPACE impedraw:: FILE impedraw-${set}.cmake DESTINATION ${package_dir}
    COMPONENT library)
endfunction()

target_compile_features(impedraw_common INTERFACE cxx_std_20)
target_sources(impedraw_common INTERFACE $<INSTALL_INTERFACE:${package_dir}/built_alike.cc>)
impedraw_install(targets common control sensing)
set(components control sensing)
set(header_folders common control sensing)
if(TARGET impedraw_perception)
  impedraw_install(perception perception)
  list(APPEND components perception)
  list(APPEND header_folders perception)
endif()
if(TARGET impedraw_planning)
  impedraw_install(planning strokes planning)
  list(APPEND components planning)
  list(APPEND header_folders planning)
  get_target_property(sources impedraw_strokes SOURCES)
  list(TRANSFORM sources REPLACE "(.*)\\.cc$" "${PROJECT_SOURCE_DIR}/src/drawing/\\1.h")
  install(FILES ${sources} DESTINATION ${include_dir}/drawing COMPONENT library)
endif()
if(TARGET impedraw_arm)
  impedraw_install(arm arm)
  list(APPEND components arm)
  list(APPEND header_folders arm)
endif()
list(TRANSFORM header_folders PREPEND src/)
install(DIRECTORY ${header_folders} DESTINATION ${include_dir} COMPONENT library FILES_MATCHING PATTERN "*.h"
  PATTERN preflight EXCLUDE PATTERN wrap EXCLUDE  # they need a canvas and an arm, or Python
  PATTERN kinematic_tree.h EXCLUDE                # Pinocchio's types, for the folder's own sources
  PATTERN urdf_model.h EXCLUDE                    # the same
  PATTERN urdf_inertia.h EXCLUDE                  # TinyXML-2's
  PATTERN urdf_tree.h EXCLUDE                     # TinyXML-2's
  PATTERN child_process.h EXCLUDE
  PATTERN input_file.h EXCLUDE)                   # POSIX: for sources that open what a user names

configure_file(cmake/built_alike.cc.in ${generated}/built_alike.cc @ONLY)
configure_package_config_file(cmake/impedraw-config.cmake.in ${generated}/impedraw-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${generated}/impedraw-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${generated}/built_alike.cc DESTINATION ${include_dir} RENAME built_alike.h COMPONENT library)  # see impedraw.pc.in
install(FILES ${generated}/built_alike.cc ${generated}/impedraw-config.cmake ${generated}/impedraw-config-version.cmake
  DESTINATION ${package_dir} COMPONENT library)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)

# Beside the archives, one shared library of all components that are built, for a Debian package and pkg-config. Interfaces may change with a minor version.
if(IMPEDRAW_LIBRARY_ONLY)
  get_property(libraries GLOBAL PROPERTY IMPEDRAW_LIBRARIES)
  foreach(library ${libraries})
    get_target_property(type impedraw_${library} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND archives impedraw_${library})
      list(APPEND objects $<TARGET_OBJECTS:impedraw_${library}>)
    endif()
  endforeach()
  add_library(impedraw_shared SHARED ${objects})
  target_link_libraries(impedraw_shared PRIVATE ${archives})  # for what they link; all that they hold is in the objects
  set_target_properties(impedraw_shared PROPERTIES OUTPUT_NAME impedraw LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  install(TARGETS impedraw_shared LIBRARY COMPONENT library)
  set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH up /${pkgconfig_dir} /)
  configure_file(cmake/impedraw.pc.in ${generated}/impedraw.pc @ONLY)
  install(FILES ${generated}/impedraw.pc DESTINATION ${pkgconfig_dir} COMPONENT library)
endif()
