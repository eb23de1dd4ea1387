// The floor of a controller step: what any operational-space controller on Pinocchio has to
// compute, each called once.
#pragma once

#include <memory>

#include <Eigen/Core>

namespace impedraw {

class Floor {
 public:
  explicit Floor(const char* urdf);
  ~Floor();
  double compute(const Eigen::VectorXd& q,
                 const Eigen::VectorXd& v);  // a number that depends on all of it

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace impedraw
