// A stub of ros2_control's interface (ROS 2 Humble) with what examples/04_ros2_control calls: names
// and signatures alone, so that the sketch is compiled. Not ROS.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace rclcpp {
class Time {};
class Duration {};
class Parameter {
 public:
  std::string as_string() const { return {}; }
};
}  // namespace rclcpp

namespace rclcpp_lifecycle {
class State {};
class LifecycleNode {
 public:
  rclcpp::Parameter get_parameter(const std::string&) const { return {}; }
};
namespace node_interfaces {
class LifecycleNodeInterface {
 public:
  enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
};
}  // namespace node_interfaces
}  // namespace rclcpp_lifecycle

namespace hardware_interface {
class LoanedStateInterface {
 public:
  double get_value() const { return 0.0; }
};
class LoanedCommandInterface {
 public:
  void set_value(double) {}
};
}  // namespace hardware_interface

namespace controller_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};

class ControllerInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
 public:
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return {}; }
  unsigned int get_update_rate() const { return 1000; }

 protected:
  template <typename T>
  void auto_declare(const std::string&, const T&) {}
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
};

}  // namespace controller_interface
