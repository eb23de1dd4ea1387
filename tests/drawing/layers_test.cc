// Layers: their marks, their order, their choice, and colours as layers.
#include "impedraw/drawing/layers.h"

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {
namespace {

Artwork page(const std::string& body, LayerSource layers = LayerSource::automatic) {
  return parse_svg(
      "<svg xmlns='http://www.w3.org/2000/svg' "
      "xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' width='100mm' height='100mm' "
      "viewBox='0 0 100 100'>" +
          body + "</svg>",
      "test", {.may_be_empty = true, .layers = layers});
}

std::string layer(const std::string& label, int y, const std::string& colour = "black") {
  return "<g inkscape:groupmode='layer' inkscape:label='" + label + "'><path d='M10 " +
         std::to_string(y) + "H90' stroke='" + colour + "'/></g>";
}

using Names = std::vector<std::string>;

TEST(Layers, NamesHoldMarks) {
  const LayerMarks all = layer_marks("!12+S50+H30+D1500 dark red");
  EXPECT_TRUE(all.pause && all.height && !all.off);
  EXPECT_EQ(all.number, 12);
  EXPECT_EQ(all.speed, 0.5);
  EXPECT_EQ(all.wait, 1.5);
  EXPECT_EQ(all.name, "dark red");
  EXPECT_TRUE(layer_marks("% 3 guides").off);
  EXPECT_EQ(layer_marks(" +s20 x").speed, 0.2);
  for (const std::string plain :
       {"black", "C+S", "+Sx", "+", "red 2", "", "+X5", "9999999999999"}) {
    const LayerMarks none = layer_marks(plain);
    EXPECT_EQ(none.name, plain);
    EXPECT_TRUE(!none.off && !none.pause && !none.number && none.speed == 1 && none.wait == 0);
  }
}

TEST(Layers, ColoursAreReadAsTheyAreNamed) {
  for (const std::uint32_t colour : {0xff0000u, 0x123456u, 0x00000au})
    EXPECT_EQ(named_colour(colour_name(colour)), colour);
  for (const std::string no : {"", "reddish", "#12345", "#12345g", "123456"})
    EXPECT_FALSE(named_colour(no).has_value()) << no;
}

TEST(Layers, NumbersOrderAndPercentSwitchesOff) {
  const Artwork a = page(layer("%guides", 5) + layer("3 c", 10) + layer("any", 20) +
                         layer("!1+H50 a", 30) + layer("2", 40));
  EXPECT_EQ(a.layers, (Names{"!1+H50 a", "any", "2", "3 c"}));
  ASSERT_EQ(a.strokes.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(a.strokes[i].layer, static_cast<int>(i));
  EXPECT_NEAR(a.strokes[0].points[0].y(), 30, 1e-4);
  EXPECT_EQ(
      a.warnings,
      (Names{"the layer '%guides' is off (%): 1 stroke left out",
             "heights in layer names are passed over, since force holds the pen: '!1+H50 a'"}));
  // What is off hides nothing.
  EXPECT_NEAR(pen_down_length(page("<path d='M0 50H100' stroke='red'/><g id='%a'><rect width='100' "
                                   "height='100' fill='#fff'/></g>")
                                  .strokes),
              100, 1e-3);
}

TEST(Layers, SomeAreChosen) {
  const std::string file = layer("1 black", 10) + layer("!2 Red", 20) + layer("rest", 30);
  for (const auto& [choice, names] :
       std::vector<std::pair<std::string, Names>>{{"2,black", {"1 black", "!2 Red"}},
                                                  {" red ", {"!2 Red"}},
                                                  {"3", {"rest"}},
                                                  {"1 BLACK, rest", {"1 black", "rest"}}}) {
    Artwork a = page(file);
    choose_layers(a, choice);
    EXPECT_EQ(a.layers, names) << choice;
    EXPECT_EQ(a.strokes.size(), names.size());
  }
  Artwork a = page(file);
  try {
    choose_layers(a, "2,blue");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "test: no layer 'blue'; there are 1 black, !2 Red, rest");
  }
}

TEST(Layers, ColoursAreLayersWhereThereIsNoGroup) {
  const std::string lines =
      "<path d='M0 9H9' stroke='red'/><path d='M0 5H9' stroke='#1c2a3a'/>"
      "<path d='M0 7H9' stroke='#f00'/>";
  EXPECT_EQ(page(lines).layers, (Names{"red", "#1c2a3a"}));
  EXPECT_EQ(page("<g>" + lines + "</g>").layers, (Names{"red", "#1c2a3a"}));
  EXPECT_EQ(page("<g id='a'>" + lines + "</g>").layers, (Names{"a"}));
  EXPECT_EQ(page("<g id='a'>" + lines + "</g>", LayerSource::colours).layers,
            (Names{"red", "#1c2a3a"}));
  EXPECT_EQ(page(lines, LayerSource::groups).layers, (Names{"page"}));
  std::string many;
  for (int i = 10; i < 19; ++i)
    many += "<path d='M0 " + std::to_string(i) + "H9' stroke='#0000" + std::to_string(i) + "'/>";
  EXPECT_EQ(page(many).layers, (Names{"page"}));
  // A fill has a layer of its own, for its hatch.
  const Artwork both = page("<rect x='9' y='9' width='9' height='9' fill='red' stroke='blue'/>");
  EXPECT_EQ(both.layers, (Names{"blue", "red"}));
  EXPECT_EQ(both.strokes.at(0).layer, 0);
  EXPECT_EQ(both.areas.at(0).layer, 1);
}

}  // namespace
}  // namespace impedraw
