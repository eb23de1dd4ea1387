# Dependencies. The venv has the pinned wheels (Pinocchio with its own Eigen and Boost, MuJoCo); the
# rest comes from Debian.
set(venv "$ENV{IMPEDRAW_VENV}")
if(NOT venv)
  set(venv ${PROJECT_SOURCE_DIR}/.venv)
endif()
set(IMPEDRAW_VENV ${venv} CACHE PATH "venv with the wheels of requirements.txt")
file(GLOB IMPEDRAW_SITE_PACKAGES ${IMPEDRAW_VENV}/lib/python3.*/site-packages)
if(NOT EXISTS ${IMPEDRAW_SITE_PACKAGES}/cmeel.prefix)
  message(FATAL_ERROR "${IMPEDRAW_VENV} lacks Pinocchio's wheel: run ./impedraw once, it installs what is missing")
endif()
set(CMEEL_PREFIX ${IMPEDRAW_SITE_PACKAGES}/cmeel.prefix)

# Pinocchio requires its wheel's Eigen and Boost on the include path. Every target uses that Eigen, so
# that there is only one.
list(PREPEND CMAKE_PREFIX_PATH ${CMEEL_PREFIX})
set(BOOST_ROOT ${CMEEL_PREFIX})
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)  # g++ 12 lacks std::format

# MuJoCo's wheel has headers and a versioned library but no CMake package.
file(GLOB MUJOCO_LIBRARY ${IMPEDRAW_SITE_PACKAGES}/mujoco/libmujoco.so.*)
add_library(mujoco SHARED IMPORTED)
set_target_properties(mujoco PROPERTIES
  IMPORTED_LOCATION ${MUJOCO_LIBRARY}
  INTERFACE_INCLUDE_DIRECTORIES ${IMPEDRAW_SITE_PACKAGES}/mujoco/include)
