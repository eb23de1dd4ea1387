// The arm stands clear of the canvas when a run begins, or the run is refused before.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/draw_options.h"

namespace impedraw {
namespace {

// The cylinder's top lies on both sides of the arm's base.
TEST(StartPosture, ACanvasThroughTheArmIsRefusedByNameBeforeThePlan) {
  DrawOptions options;
  options.assignments = {"canvas.kind=cylinder", "canvas.cylinder.length=2"};
  try {
    prepare_plan(resolve(options));
    FAIL() << "is planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("link_1 touches the canvas in the start"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("arm.start"));
  }
  options.assignments = {"canvas.kind=cylinder", "canvas.cylinder.length=0.6"};
  EXPECT_NO_THROW(prepare_plan(resolve(options)));
}

}  // namespace
}  // namespace impedraw
