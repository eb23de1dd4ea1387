# What people lift out: control and sensing, which need Eigen alone. `cmake --install build/release --component library --prefix …` copies
# them, and find_package(impedraw) finds them there as impedraw::common, impedraw::control and impedraw::sensing.
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
set(generated ${PROJECT_BINARY_DIR}/package)
configure_file(cmake/built_alike.cc.in ${generated}/built_alike.cc @ONLY)
configure_package_config_file(cmake/impedraw-config.cmake.in ${generated}/impedraw-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${generated}/impedraw-config-version.cmake COMPATIBILITY SameMinorVersion)

target_compile_features(impedraw_common INTERFACE cxx_std_20)
target_sources(impedraw_common INTERFACE $<INSTALL_INTERFACE:${package_dir}/built_alike.cc>)
foreach(folder common control sensing)
  set_target_properties(impedraw_${folder} PROPERTIES EXPORT_NAME ${folder})
  install(TARGETS impedraw_${folder} EXPORT impedraw COMPONENT library)
  install(DIRECTORY src/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/impedraw COMPONENT library FILES_MATCHING PATTERN "*.h")
endforeach()
install(EXPORT impedraw NAMESPACE impedraw:: FILE impedraw-targets.cmake DESTINATION ${package_dir} COMPONENT library)
install(FILES ${generated}/built_alike.cc ${generated}/impedraw-config.cmake ${generated}/impedraw-config-version.cmake
  DESTINATION ${package_dir} COMPONENT library)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)
