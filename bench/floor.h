// The floor of a controller step: the quantities that any operational-space controller computes
// with Pinocchio, each computed once.
#pragma once

#include <memory>

#include <Eigen/Core>

namespace impedraw {

class Floor {
 public:
  explicit Floor(const char* urdf);
  ~Floor();
  double compute(const Eigen::VectorXd& q,
                 const Eigen::VectorXd& v);  // a number that depends on all results

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace impedraw
