// Figures of a nozzle by the truth: where its jet meets the canvas, while it is open. It is while a
// stroke is drawn.
//
//   stand_off_error   t − stand_off, t: way of the jet from the nozzle to the canvas           [mm]
//   jet_speed         of the place where it meets the canvas, there, within a stroke         [mm/s]
//   jet_missed_share  share of the rows in which it meets nothing
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/log/log.h"

namespace impedraw {

class Canvas;

class JetFigures {
 public:
  // canvas: the true one, in the frame K that it moves with. The tip of the rows lies stand_off [m]
  // before the nozzle, along z_E.
  JetFigures(const TriangleMesh& canvas, double stand_off);
  ~JetFigures();

  void add(const LogRow& row);
  // As metrics.json has them; null where nothing was met.
  nlohmann::ordered_json metrics() const;
  double stand_off() const { return stand_off_; }

 private:
  std::unique_ptr<const Canvas> canvas_;
  double stand_off_;
  double time_ = -1.0;
  int stroke_ = -1;
  std::optional<Eigen::Vector3d> met_K_;                // in the row before [m]
  double rows_ = 0.0, hits_ = 0.0;                      // while it is open; where it met the canvas
  double square_ = 0.0, most_ = 0.0;                    // of the stand-off's error [m², m]
  double open_ = 0.0, way_ = 0.0, square_speed_ = 0.0;  // [s], [m], [m²/s]
};

}  // namespace impedraw
