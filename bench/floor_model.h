// Reading is a separate translation unit because Pinocchio's parser and algorithms are each slow to
// compile.
#pragma once

#include <pinocchio/multibody/model.hpp>

namespace impedraw {

pinocchio::Model floor_model(const char* urdf);

}  // namespace impedraw
