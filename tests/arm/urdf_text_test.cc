// What is refused before urdfdom, Pinocchio or MuJoCo see it.
#include "impedraw/arm/urdf_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/arm/arm_model.h"
#include "impedraw/common/errors.h"
#include "impedraw/simulation/world.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    require_urdf(text, "a.urdf");
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_THAT(error.what(), ::testing::StartsWith("arm description a.urdf: "));
    return error.what();
  }
  return "accepted";
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(UrdfText, AcceptsWhatIsShipped) {
  for (const char* file : {"models/iiwa14_pen.urdf", "tests/data/slider.urdf"})
    EXPECT_NO_THROW(require_urdf_file(file));
  EXPECT_EQ(refusal("\xef\xbb\xbf<?xml version='1.0'?>\n<!-- a > b --><robot name = \"r\"\n>"
                    "<link name='a'/><x>&lt;<![CDATA[<y>]]></x><mujoco><compiler/></mujoco>"
                    "</robot >\n"),
            "accepted");
}

TEST(UrdfText, OnlyRobots) {
  EXPECT_THAT(refusal("<mujoco><asset><hfield name='h' nrow='100000' ncol='100000' "
                      "size='1 1 1 1'/></asset></mujoco>"),
              HasSubstr("line 1: the root element is <mujoco>, must be <robot>"));
  EXPECT_THAT(refusal("<robot>\n<include file='/dev/zero'/></robot>"),
              HasSubstr("line 2: <include> is not read"));
  EXPECT_THAT(refusal("<robot>\n<xacro:arm prefix='a'/></robot>"),
              HasSubstr("line 2: <xacro:arm> is xacro"));
  EXPECT_EQ(refusal("<robot><xacro:property name='m' value='${2 * 3}'/></robot>"), "accepted");
  EXPECT_THAT(refusal("<robot><mass value='${m}'/></robot>"),
              HasSubstr("the value of value is xacro"));
  EXPECT_THAT(refusal("<robot><mujoco><size memory='100T'/></mujoco></robot>"),
              HasSubstr("<size> in <mujoco>"));
  EXPECT_THAT(refusal("<robot/><mujoco/>"), HasSubstr("a second root element, <mujoco>"));
  EXPECT_THAT(refusal("<!DOCTYPE robot [<!ENTITY a 'b'>]><robot/>"), HasSubstr("document type"));
  EXPECT_THAT(refusal(""), HasSubstr("holds no element"));
  EXPECT_THAT(refusal("# An arm\n"), HasSubstr("text outside of the root element"));
  EXPECT_THAT(refusal(std::string("<robot>\0</robot>", 16)), HasSubstr("not a text"));
}

TEST(UrdfText, NoMoreThanStated) {
  EXPECT_EQ(refusal("<robot>" + repeated("<link/><joint/>", kMostUrdfLinks) + "</robot>"),
            "accepted");
  EXPECT_THAT(refusal("<robot>" + repeated("<link/>\n", 20000) + "</robot>"),
              HasSubstr("line 257: more than 256 links"));
  EXPECT_THAT(refusal("<robot>" + repeated("<joint/>", 257) + "</robot>"),
              HasSubstr("more than 256 joints"));
  EXPECT_THAT(refusal("<robot><link>" + repeated("<visual/>", 30000) + "</link></robot>"),
              HasSubstr("more than 20000 elements"));
  EXPECT_THAT(refusal("<robot>" + repeated("<a>", 200000)),
              HasSubstr("nested deeper than 16 elements"));
  EXPECT_THAT(refusal("<robot>" + repeated(" ", 5'000'000) + "</robot>"),
              HasSubstr("5.0 MB, at most 4 MB are read"));
}

// Where XML libraries guess, they guess differently.
TEST(UrdfText, BrokenXmlIsNamed) {
  EXPECT_THAT(refusal("<robot>\n<link>\n</robot>"), HasSubstr("line 3: not valid XML: </robot> "
                                                              "closes <link>"));
  EXPECT_THAT(refusal("<robot><link>"), HasSubstr("the file ends within <link>"));
  EXPECT_THAT(refusal("<robot></robot></robot>"), HasSubstr("</robot> without <robot>"));
  EXPECT_THAT(refusal("<robot name=r/>"), HasSubstr("the value of name must be in quotes"));
  EXPECT_THAT(refusal("<robot name/>"), HasSubstr("name has no value"));
  EXPECT_THAT(refusal("<robot a='1'b='2'/>"), HasSubstr("<robot does not end"));
  EXPECT_THAT(refusal("<robot a='<mujoco>'/>"), HasSubstr("'<' in the value of a"));
  EXPECT_THAT(refusal("<robot a='1"), HasSubstr("must be in quotes"));
  EXPECT_THAT(refusal("<robot><!-- </robot>"), HasSubstr("a comment that does not end"));
  EXPECT_THAT(refusal("<robot>< link/></robot>"), HasSubstr("a name is expected"));
}

class UrdfFiles : public ScratchFolder {};

// Both readers, before their libraries do.
TEST_F(UrdfFiles, BothReadersRefuse) {
  const auto file = write("arm.urdf",
                          "<mujoco><asset><hfield name='h' nrow='100000' ncol='100000' "
                          "size='1 1 1 1'/></asset></mujoco>");
  const auto expect = [&](auto read) {
    try {
      read();
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the root element is <mujoco>, must be <robot>"));
    }
  };
  expect([&] { ArmModel{file.string()}; });
  expect([&] { World(file, nullptr, {}); });
}

}  // namespace
}  // namespace impedraw
