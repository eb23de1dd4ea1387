# Dependencies. The venv has the pinned wheels (Pinocchio with its own Eigen and Boost, MuJoCo); the
# rest comes from Debian.
if(SKBUILD)  # pip builds the Python package (pyproject.toml): the wheels are wherever its interpreter looks
  find_package(Python 3.11 COMPONENTS Interpreter REQUIRED)
  set(IMPEDRAW_PYTHON_EXECUTABLE ${Python_EXECUTABLE})
  execute_process(
    COMMAND ${Python_EXECUTABLE} -c "import os, sys; print(next((p for p in sys.path if os.path.isdir(p + '/cmeel.prefix')), ''))"
    OUTPUT_VARIABLE IMPEDRAW_SITE_PACKAGES OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT IMPEDRAW_SITE_PACKAGES)
    message(FATAL_ERROR "${Python_EXECUTABLE} finds no Pinocchio (libpinocchio): install what pyproject.toml lists under build-system.requires")
  endif()
else()
  set(venv "$ENV{IMPEDRAW_VENV}")
  if(NOT venv)
    set(venv ${PROJECT_SOURCE_DIR}/.venv)
  endif()
  set(IMPEDRAW_VENV ${venv} CACHE PATH "venv with the wheels of requirements.txt")
  set(IMPEDRAW_PYTHON_EXECUTABLE ${IMPEDRAW_VENV}/bin/python)
  file(GLOB IMPEDRAW_SITE_PACKAGES ${IMPEDRAW_VENV}/lib/python3.*/site-packages)
  if(NOT EXISTS ${IMPEDRAW_SITE_PACKAGES}/cmeel.prefix)
    message(FATAL_ERROR "${IMPEDRAW_VENV} lacks Pinocchio's wheel: run ./impedraw once, it installs what is missing")
  endif()
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
