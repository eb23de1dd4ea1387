#include "report/run_data.h"

#include <algorithm>
#include <cmath>

#include "common/errors.h"
#include "report/h5.h"

namespace impedraw {
namespace {

// Reads datasets of one file; every error becomes an InputError that names file and dataset.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {
    h5::quiet_errors();
    if (!std::filesystem::exists(path)) throw InputError(path.string() + ": no such file; a run's log (run.h5) is needed");
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) throw InputError(path.string() + ": not an HDF5 file, or a broken one; a run's log (run.h5) is needed");
    file_ = h5::Id(file, H5Fclose);
  }

  [[noreturn]] void fail(const std::string& what) const { throw InputError(path_.string() + ": " + what); }

  h5::Id open(const std::string& name) const {
    const hid_t dataset = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    if (dataset < 0) fail("dataset " + name + " is missing; this is not a log that impedraw wrote");
    return h5::Id(dataset, H5Dclose);
  }

  // Rows of the dataset, whose rows must have `width` values.
  std::size_t rows(const h5::Id& dataset, const std::string& name, int width) const {
    const h5::Id space = h5::own(H5Dget_space(dataset), H5Sclose, name);
    const int rank = H5Sget_simple_extent_ndims(space);
    hsize_t shape[2] = {0, 1};
    if (rank == 1 || rank == 2) H5Sget_simple_extent_dims(space, shape, nullptr);
    if (rank < 1 || rank > 2 || shape[1] != static_cast<hsize_t>(width)) {
      fail("dataset " + name + " has the wrong shape; it should have " + std::to_string(width) + " values a row");
    }
    return shape[0];
  }

  // The first rows, at most `limit` of them, into what resize(n) returns; returns how many.
  template <typename Resize>
  std::size_t read(const std::string& name, int width, hid_t type, std::size_t limit, Resize resize) const {
    const h5::Id dataset = open(name);
    for (std::size_t n = std::min(limit, rows(dataset, name, width));; n = (n - 1) / 4096 * 4096) {  // a killed run may lack its last chunk
      void* out = resize(n);
      if (n == 0) return 0;
      const hsize_t start[2] = {0, 0}, count[2] = {n, static_cast<hsize_t>(width)};
      const h5::Id file_space = h5::own(H5Dget_space(dataset), H5Sclose, name);
      const int rank = H5Sget_simple_extent_ndims(file_space);
      const h5::Id memory = h5::own(H5Screate_simple(rank, count, nullptr), H5Sclose, name);
      H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, nullptr, count, nullptr);
      if (H5Dread(dataset, type, memory, file_space, H5P_DEFAULT, out) >= 0) return n;
    }
  }

  static constexpr std::size_t kAll = static_cast<std::size_t>(-1);

  std::size_t numbers(const std::string& name, std::vector<double>& out, std::size_t limit = kAll) const {
    return read(name, 1, H5T_NATIVE_DOUBLE, limit, [&](std::size_t n) { return out.resize(n), out.data(); });
  }
  std::size_t integers(const std::string& name, std::vector<int>& out, std::size_t limit = kAll) const {
    return read(name, 1, H5T_NATIVE_INT, limit, [&](std::size_t n) { return out.resize(n), out.data(); });
  }
  std::size_t points(const std::string& name, RunData::Points& out, std::size_t limit = kAll) const {
    return read(name, 3, H5T_NATIVE_DOUBLE, limit, [&](std::size_t n) { return out.resize(n), out.data(); });
  }
  std::size_t joints(const std::string& name, int j, RunData::Joints& out, std::size_t limit) const {
    return read(name, j, H5T_NATIVE_DOUBLE, limit, [&](std::size_t n) { return out.resize(n, j), out.data(); });
  }
  std::size_t quaternions(const std::string& name, std::vector<Eigen::Quaterniond>& out, std::size_t limit) const {
    std::vector<Eigen::Vector4d> wxyz;
    const std::size_t n = read(name, 4, H5T_NATIVE_DOUBLE, limit, [&](std::size_t m) { return wxyz.resize(m), wxyz.data(); });
    out.clear();
    for (const Eigen::Vector4d& q : wxyz) out.emplace_back(q[0], q[1], q[2], q[3]);
    return n;
  }

  // Names of the links in a group, in alphabetical order.
  std::vector<std::string> members(const std::string& group) const {
    std::vector<std::string> names;
    if (H5Lexists(file_, group.c_str(), H5P_DEFAULT) <= 0) return names;
    const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) {
      static_cast<std::vector<std::string>*>(out)->push_back(name);
      return herr_t{0};
    };
    const h5::Id id = h5::own(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose, group);
    h5::check(H5Literate(id, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names), group);
    return names;
  }

  double wall(const char* name) const {
    if (H5Aexists(file_, name) <= 0) return LogRow::kNone;
    const std::vector<double> value = h5::read_numbers(file_, name);
    return value.empty() ? LogRow::kNone : value.front();
  }

  std::map<std::string, std::string> texts() const {
    std::map<std::string, std::string> found;
    const auto collect = [](hid_t file, const char* name, const H5A_info_t*, void* out) {
      const hid_t attribute = H5Aopen(file, name, H5P_DEFAULT), type = H5Aget_type(attribute);
      const bool text = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0;
      H5Tclose(type);
      H5Aclose(attribute);
      if (text) (*static_cast<std::map<std::string, std::string>*>(out))[name] = h5::read_text(file, name);
      return herr_t{0};
    };
    h5::check(H5Aiterate2(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &found), "attributes");
    return found;
  }

 private:
  std::filesystem::path path_;
  h5::Id file_;
};

Eigen::VectorXd to_vector(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

RunData read(const Reader& in) {
  RunData run;
  {
    const h5::Id position = in.open("/joint/position");
    run.joint_lower = to_vector(h5::read_numbers(position, "lower"));
    run.joint_upper = to_vector(h5::read_numbers(position, "upper"));
    run.torque_limit = to_vector(h5::read_numbers(position, "torque_limit"));
    if (H5Aexists(position, "names") > 0) run.joint_names = h5::read_texts(position, "names");
    run.mode_names = h5::read_texts(in.open("/mode"), "names");
  }
  const int j = static_cast<int>(run.joint_lower.size());
  if (run.joint_upper.size() != j || run.torque_limit.size() != j) in.fail("attributes lower, upper and torque_limit differ in length");

  // Each dataset is read no further than the shortest before it; at the end all are cut to the shortest.
  std::size_t n = in.numbers("/time", run.time);
  while (n > 0 && !std::isfinite(run.time[n - 1])) --n;  // the fill value: extended, not written
  const auto shorten = [&n](std::size_t rows) { n = std::min(n, rows); };
  shorten(in.joints("/joint/position", j, run.joint_position, n));
  shorten(in.joints("/joint/velocity", j, run.joint_velocity, n));
  shorten(in.joints("/joint/torque", j, run.joint_torque, n));
  for (const std::string& term : in.members("/torque")) {
    RunData::Joints values;
    shorten(in.joints("/torque/" + term, j, values, n));
    if (run.torque_before_limits.rows() == 0) {
      run.torque_before_limits = values;
    } else {
      const Eigen::Index m = std::min(values.rows(), run.torque_before_limits.rows());
      run.torque_before_limits.topRows(m) += values.topRows(m);
    }
  }
  shorten(in.points("/tip/position", run.tip_position, n));
  shorten(in.quaternions("/tip/orientation", run.tip_orientation, n));
  shorten(in.points("/desired/position", run.desired_position, n));
  shorten(in.points("/contact/force", run.contact_force, n));
  shorten(in.points("/contact/point", run.contact_point, n));
  shorten(in.points("/contact/normal", run.contact_normal, n));
  shorten(in.points("/disturbance/force", run.disturbance_force, n));
  shorten(in.points("/surface/normal", run.surface_normal, n));
  shorten(in.numbers("/surface/distance", run.surface_distance, n));
  shorten(in.numbers("/push", run.push, n));
  shorten(in.integers("/mode", run.mode, n));
  shorten(in.integers("/stroke", run.stroke, n));
  shorten(in.numbers("/controller/step_time", run.step_time, n));

  for (auto* column : {&run.time, &run.surface_distance, &run.push, &run.step_time}) column->resize(n);
  for (auto* column : {&run.tip_position, &run.desired_position, &run.contact_force, &run.contact_point, &run.contact_normal,
                       &run.disturbance_force, &run.surface_normal}) {
    column->resize(n);
  }
  for (auto* column : {&run.mode, &run.stroke}) column->resize(n);
  run.tip_orientation.resize(n);
  for (auto* column : {&run.joint_position, &run.joint_velocity, &run.joint_torque, &run.torque_before_limits}) {
    if (column->rows() > static_cast<Eigen::Index>(n)) column->conservativeResize(static_cast<Eigen::Index>(n), Eigen::NoChange);
  }

  in.points("/canvas/vertices", run.canvas_vertices);
  in.read("/canvas/triangles", 3, H5T_NATIVE_INT, Reader::kAll,
          [&](std::size_t m) { return run.canvas_triangles.resize(m), run.canvas_triangles.data(); });
  in.points("/cloud/points", run.cloud_points);
  in.points("/target/points", run.target_points);
  in.integers("/target/stroke", run.target_stroke);
  if (run.target_stroke.size() != run.target_points.size()) in.fail("/target/points and /target/stroke differ in length");
  run.wall = {in.wall("wall_start_up"), in.wall("wall_loop"), in.wall("wall_writing")};
  run.attributes = in.texts();
  return run;
}

}  // namespace

RunData read_run(const std::filesystem::path& path) {
  const Reader in(path);
  try {
    return read(in);
  } catch (const h5::Error& e) {
    in.fail(e.what());
  }
}

}  // namespace impedraw
