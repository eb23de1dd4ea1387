#include "floor_model.h"

#include <pinocchio/parsers/urdf.hpp>

namespace impedraw {

pinocchio::Model floor_model(const char* urdf) {
  pinocchio::Model model;
  pinocchio::urdf::buildModel(urdf, model);
  return model;
}

}  // namespace impedraw
