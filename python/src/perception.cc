#include <algorithm>
#include <cmath>
#include <cstdint>

#include "impedraw/perception/normals.h"
#include "module.h"
#include "record.h"

namespace impedraw::python {

namespace {

PointCloud cloud_of(nb::handle points, nb::handle viewpoint, nb::handle weight) {
  const DoubleArray p = doubles_of(points, "points");
  require_shape(p, "points", {-1, 3});
  PointCloud cloud;
  const auto* first = reinterpret_cast<const Eigen::Vector3d*>(p.data());
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  cloud.points.assign(first, first + p.shape(0));
  cloud.camera.assign(p.shape(0), 0);
  Eigen::Vector3d eye;
  assign(viewpoint, eye, "viewpoint");
  if (!eye.allFinite()) refuse("viewpoint", viewpoint, "finite");
  cloud.eyes = {eye};
  std::vector<std::size_t> whole;  // the points that are somewhere
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (cloud.points[i].allFinite()) whole.push_back(i);
  const std::size_t left_out = cloud.points.size() - whole.size();
  if (!weight.is_none()) {
    const DoubleArray w = doubles_of(weight, "weight");
    require_shape(w, "weight", {static_cast<long>(p.shape(0))});
    cloud.weight.assign(w.data(), w.data() + w.shape(0));
    for (const double x : cloud.weight)
      if (!(x > 0.0) || !std::isfinite(x)) refuse("weight", weight, "positive and finite");
  }
  if (whole.empty() && left_out > 0) refuse("points", points, "with a finite point at least");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    cloud.points[i] = cloud.points[whole[i]];
    if (!cloud.weight.empty()) cloud.weight[i] = cloud.weight[whole[i]];
  }
  cloud.points.resize(whole.size());
  cloud.camera.resize(whole.size());
  if (!cloud.weight.empty()) cloud.weight.resize(whole.size());
  if (left_out > 0 &&
      PyErr_WarnFormat(PyExc_RuntimeWarning, 1, "%zu of %zu points are not finite and are left out",
                       left_out, left_out + whole.size()) < 0)
    throw nb::python_error();
  return cloud;
}

nb::object points_view(const std::vector<Eigen::Vector3d>& points, nb::handle owner) {
  auto* data = const_cast<double*>(points.empty() ? nullptr : points.front().data());
  return nb::cast(nb::ndarray<nb::numpy, const double>(data, {points.size(), 3}, owner));
}

}  // namespace

void bind_perception(nb::module_& m) {
  nb::enum_<NeighbourWeighting>(m, "NeighbourWeighting", "Weights of a query's neighbours.")
      .value("uniform", NeighbourWeighting::uniform)
      .value("smooth", NeighbourWeighting::smooth);
  nb::enum_<SurfaceFit>(m, "SurfaceFit", "What is fitted to them.")
      .value("plane", SurfaceFit::plane)
      .value("quadric", SurfaceFit::quadric);
  Record<NormalSettings>(m, "NormalSettings", "Settings of the surface estimator.")
      .field("k", &NormalSettings::k, "neighbours of a query (18), 8 to 128")
      .field("max_radius", &NormalSettings::max_radius, "search radius [m], 0.001 to 1")
      .field("weighting", &NormalSettings::weighting, "of the neighbours")
      .field("fit", &NormalSettings::fit, "plane or quadric")
      .field("max_one_sidedness", &NormalSettings::max_one_sidedness,
             "above it a query is off the cloud's edge, above 0 to 1")
      .done();
  nb::class_<SurfaceEstimator>(
      m, "SurfaceEstimator",
      "Normal and distance of the surface under a point, from a cloud: equations (18), (19).\n"
      "Queries may run in any number of threads.")
      .def(
          "__init__",
          [](SurfaceEstimator* self, nb::handle points, nb::handle viewpoint,
             const NormalSettings& settings, nb::handle weight) {
            PointCloud cloud = cloud_of(points, viewpoint, weight);
            const nb::gil_scoped_release no_gil;
            new (self) SurfaceEstimator(std::move(cloud), settings);
          },
          nb::arg("points"), nb::arg("viewpoint"), nb::arg("settings") = NormalSettings(),
          nb::arg("weight").none() = nb::none(),
          nb::sig("def __init__(self, points: numpy.typing.ArrayLike, viewpoint: "
                  "numpy.typing.ArrayLike, settings: NormalSettings = ..., weight: "
                  "numpy.typing.ArrayLike | None = None) -> None"),
          "points: shape (N, 3), W [m]; viewpoint: (3,), where they were seen from: normals point\n"
          "there; weight: (N,), the pixels that each stands for. Points that are not finite, as\n"
          "organised clouds have them, are left out, with a RuntimeWarning that counts them.\n"
          "Raises ValueError for an empty cloud or a bad setting.")
      .def(
          "estimate",
          [](const SurfaceEstimator& e, nb::handle p_W) {
            Eigen::Vector3d p;
            assign(p_W, p, "p_W");
            return e.estimate(p);
          },
          nb::arg("p_W"),
          nb::sig("def estimate(self, p_W: numpy.typing.ArrayLike) -> SurfaceEstimate"),
          "At a point, shape (3,), W [m].")
      .def(
          "estimate_all",
          [](const SurfaceEstimator& e, nb::handle p_W) {
            const DoubleArray p = doubles_of(p_W, "p_W");
            require_shape(p, "p_W", {-1, 3});
            const std::size_t n = p.shape(0);
            auto* normals = new double[3 * n + 1];
            auto* distances = new double[n + 1];
            auto* status = new std::int8_t[n + 1];
            const auto owner = [](auto* x) {
              return nb::capsule(x, [](void* memory) noexcept {
                delete[] static_cast<std::remove_pointer_t<decltype(x)>*>(memory);
              });
            };
            const nb::capsule of_normals = owner(normals), of_distances = owner(distances),
                              of_status = owner(status);
            {
              const nb::gil_scoped_release no_gil;
              for (std::size_t i = 0; i < n; ++i) {
                const SurfaceEstimate s =
                    e.estimate(Eigen::Map<const Eigen::Vector3d>(p.data() + 3 * i));
                std::copy_n(s.n_W.data(), 3, normals + 3 * i);
                distances[i] = s.distance;
                status[i] = static_cast<std::int8_t>(s.status);
              }
            }
            return nb::make_tuple(nb::ndarray<nb::numpy, double>(normals, {n, 3}, of_normals),
                                  nb::ndarray<nb::numpy, double>(distances, {n}, of_distances),
                                  nb::ndarray<nb::numpy, std::int8_t>(status, {n}, of_status));
          },
          nb::arg("p_W"),
          nb::sig("def estimate_all(self, p_W: numpy.typing.ArrayLike) -> "
                  "tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int8]]"),
          "At points, shape (N, 3), W [m]: normals (N, 3), distances (N,) [m], and statuses (N,)\n"
          "as numbers: 0 ok, 2 too_few, 3 off_edge. Without the GIL.")
      .def_prop_ro(
          "points",
          [](nb::handle_t<SurfaceEstimator> self) {
            return points_view(nb::cast<SurfaceEstimator&>(self).cloud().points, self);
          },
          nb::for_getter(nb::sig("def points(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "The cloud in the order of the search tree, shape (N, 3), W [m]; read-only, no copy.")
      .def_prop_ro(
          "normals",
          [](nb::handle_t<SurfaceEstimator> self) {
            return points_view(nb::cast<SurfaceEstimator&>(self).cloud().normals, self);
          },
          nb::for_getter(nb::sig("def normals(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "Unit normals there, shape (N, 3); NaN where none could be fitted; read-only, no copy.");
}

}  // namespace impedraw::python
