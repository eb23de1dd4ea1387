// A sketch of a ros2_control controller around impedraw's law. It is compiled against a stub of
// ros2_control's interface (tests/examples/ros2_stub), as of ROS 2 Humble. No robot and no ROS has
// ever run it. What a real one needs beside: a path from a node of its own, through a realtime
// buffer; the surface from perception; the ramp, limits and watchdog of docs/arm-safety.md.
#include <memory>
#include <string>
#include <vector>

#include <controller_interface/controller_interface.hpp>
#include <pluginlib/class_list_macros.hpp>

#include "impedraw/arm/arm_model.h"
#include "impedraw/control/impedance.h"

namespace impedraw_ros {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

class DrawingController : public controller_interface::ControllerInterface {
 public:
  CallbackReturn on_init() override {
    auto_declare<std::string>("urdf", "");
    return CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override {
    return interfaces({"effort"});
  }
  InterfaceConfiguration state_interface_configuration() const override {
    return interfaces({"position", "velocity"});
  }

  CallbackReturn on_configure(const rclcpp_lifecycle::State&) override {
    try {
      arm_ = std::make_unique<impedraw::ArmModel>(get_node()->get_parameter("urdf").as_string());
      impedraw::ImpedanceSettings settings;
      settings.timing.dt = 1.0 / get_update_rate();
      settings.wrench = impedraw::WrenchFeedback::none;
      settings.inertia = impedraw::InertiaShaping::natural;
      settings.limits.torque = arm_->limits().torque;
      settings.joint_range.lower = arm_->limits().lower;
      settings.joint_range.upper = arm_->limits().upper;
      law_ = std::make_unique<impedraw::ImpedanceController>(settings, arm_->joints());
    } catch (const std::exception&) {
      return CallbackReturn::ERROR;
    }
    terms_ = impedraw::ArmTerms(arm_->joints());
    q_ = v_ = impedraw::JointVector::Zero(arm_->joints());
    return CallbackReturn::SUCCESS;
  }

  // The pen stays where it is until somebody gives it a path.
  CallbackReturn on_activate(const rclcpp_lifecycle::State&) override {
    read_state();
    const impedraw::Pose X_WE = arm_->tip_pose(q_);
    goal_.p_WD = X_WE.p;
    goal_.n_WD = -X_WE.R.col(2);
    return CallbackReturn::SUCCESS;
  }

  // No allocation, no lock, no log. Effort is without gravity where the hardware compensates it, as
  // Franka's and KUKA's do.
  return_type update(const rclcpp::Time&, const rclcpp::Duration&) override {
    read_state();
    arm_->compute(q_, v_, &terms_);
    const impedraw::ImpedanceTorque& out =
        law_->step(terms_, goal_, impedraw::SurfaceEstimate(), impedraw::Wrench::Zero(), {});
    for (std::size_t j = 0; j < command_interfaces_.size(); ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      command_interfaces_[j].set_value(out.tau[i] - out.terms(i, impedraw::kGravity));
    }
    return return_type::OK;
  }

 private:
  InterfaceConfiguration interfaces(const std::vector<std::string>& kinds) const {
    InterfaceConfiguration all{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
    if (!arm_) return all;
    for (const std::string& joint : arm_->joint_names())
      for (const std::string& kind : kinds) all.names.push_back(joint + "/" + kind);
    return all;
  }

  void read_state() noexcept {
    for (Eigen::Index j = 0; j < q_.size(); ++j) {
      q_[j] = state_interfaces_[static_cast<std::size_t>(2 * j)].get_value();
      v_[j] = state_interfaces_[static_cast<std::size_t>(2 * j + 1)].get_value();
    }
  }

  std::unique_ptr<impedraw::ArmModel> arm_;
  std::unique_ptr<impedraw::ImpedanceController> law_;
  impedraw::ArmTerms terms_;
  impedraw::TipReference goal_;
  impedraw::JointVector q_, v_;
};

}  // namespace impedraw_ros

PLUGINLIB_EXPORT_CLASS(impedraw_ros::DrawingController, controller_interface::ControllerInterface)
