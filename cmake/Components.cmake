# What IMPEDRAW_LIBRARY_ONLY builds: the folders of the components asked for, with what they need
# from where CMake finds it (CMAKE_PREFIX_PATH).
find_package(Eigen3 QUIET NO_MODULE)  # a version asked for would exclude the next major one
if(NOT Eigen3_FOUND OR Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "the library needs Eigen from 3.4 on, and CMake finds none: install libeigen3-dev, or "
    "name a folder that holds one, as in -DCMAKE_PREFIX_PATH=/opt/eigen")
endif()
set(valid control sensing perception planning arm)
foreach(component ${IMPEDRAW_COMPONENTS})
  if(NOT component IN_LIST valid)
    list(JOIN valid ", " valid)
    message(FATAL_ERROR "IMPEDRAW_COMPONENTS: there is no '${component}'; valid are ${valid}")
  endif()
endforeach()
set(parts ${IMPEDRAW_COMPONENTS})
list(REMOVE_ITEM parts control sensing)
if(parts)
  find_package(Threads REQUIRED)
  find_package(fmt REQUIRED)
endif()
if("planning" IN_LIST parts)
  list(APPEND IMPEDRAW_FOLDERS drawing)  # its library of strokes
endif()
list(APPEND IMPEDRAW_FOLDERS ${parts})
