// Things too thin for the cameras, and sheets beside the text that show the pen their back.
#include <algorithm>

#include <gmock/gmock.h>

#include "drawn_scenario.h"

namespace impedraw {
namespace {

// "Hello", 60 mm wide, on a mesh of tests/data.
Figures hello_on(const std::string& mesh) {
  DrawOptions options;
  options.text = "Hello";
  options.skip_unreachable = true;
  options.assignments = {"canvas.kind=mesh", "canvas.mesh.file=tests/data/" + mesh,
                         "canvas.move=[0.6, 0, 0.02]", "drawing.placement.fit_radius=0.06"};
  return draw_scenario(resolve(options));
}

double highest(const Figures& f) {
  double most = 0.0;
  for (const Eigen::Vector3d& force : f.run.contact_force) most = std::max(most, force.norm());
  return most;
}

// An upright sheet 8 mm beside a stroke's end: a pen in free air got 171 N as it rose past it.
TEST(ThinThings, ASheetBesideThePenDoesNotPushIt) {
  const Figures f = hello_on("fin_8mm_back.obj");
  EXPECT_LT(highest(f), 8.0);
  EXPECT_EQ(f["coverage"], 1.0);
}

// Wires of 0.2 mm, 1 mm above a plate: the ball meets them and the plate at a time. The run ended
// and blamed the contact's stiffness; solved as one contact, six pressed the ball with 18 N.
TEST(ThinThings, WiresAndTheGroundBeneathThemBearTheTipTogether) {
  const Figures two = hello_on("wires2.obj");
  EXPECT_GT(two["coverage"], 0.98);
  EXPECT_LT(highest(two), 9.0);
  EXPECT_LT(two["touchdown_peak"], 8.0);
  const Figures six = hello_on("wires.obj");
  EXPECT_GT(six["coverage"], 0.93);
  EXPECT_LT(six["force_sd"], 0.7);
  EXPECT_LT(highest(six), 14.0);
}

// One wire 12 mm above the plate, which the pen's shaft met: the run ended there.
TEST(ThinThings, APartBelowAWireIsGivenUpAndTheRestDrawn) {
  const Figures f = hello_on("wire_high_0.obj");
  EXPECT_GT(f["coverage"], 0.95);
  EXPECT_FALSE(f.outcome.lacking.empty());
}

}  // namespace
}  // namespace impedraw
