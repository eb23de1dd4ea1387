# What IMPEDRAW_LIBRARY_ONLY builds: the folders of the components asked for, with what they need
# from where CMake finds it (CMAKE_PREFIX_PATH).
find_package(Eigen3 3.4 QUIET NO_MODULE)
if(NOT Eigen3_FOUND)
  message(FATAL_ERROR "the library needs Eigen 3.4, and CMake finds none: install libeigen3-dev, or "
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
