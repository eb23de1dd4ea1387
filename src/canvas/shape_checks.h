// What every built-in canvas asks of its sizes. Each throws InputError: the shape, the setting, its
// value and what would be valid.
#pragma once

#include <string_view>

#include <Eigen/Core>

namespace impedraw {

void require_positive(std::string_view shape, std::string_view name,
                      double value);  // a finite length [m] above 0
void require_finite(std::string_view shape, std::string_view name, double value,
                    std::string_view unit);
void require_finite(std::string_view shape, std::string_view name, const Eigen::Vector3d& value);
void require_at_most(std::string_view shape, std::string_view name, double value,
                     std::string_view what, double most);  // [m]
void require_fair_size(std::string_view shape, double edge,
                       double triangles);  // no more of them than a computer holds with ease

}  // namespace impedraw
