// See controller_interface.hpp. Instantiates the class, so that a function that is still pure shows.
#pragma once

#define PLUGINLIB_EXPORT_CLASS(CLASS, BASE) \
  BASE* make_exported_class();              \
  BASE* make_exported_class() { return new CLASS; }
