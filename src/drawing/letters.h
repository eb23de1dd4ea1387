// Composes letters beyond ASCII from a Hershey font's glyphs: é is e with an acute above it.
//
// Latin-1 and Latin Extended-A letters are composed of a base letter and marks. A mark above i or j
// replaces the dot; marks above one another are stacked. Ligatures such as æ are their two letters
// moved together. Letters without such parts (ß, þ, ð, ŋ, …) and a few signs (° × ÷ « » € …) are
// drawn here in plain single strokes, for every font. Typographic quotes, dashes and spaces become
// ASCII. Combining marks (from U+0300) attach to the letter before them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "impedraw/drawing/hershey.h"

namespace impedraw {

// Strict UTF-8. InputError names the byte.
std::u32string decoded_utf8(std::string_view text);
std::string encoded_utf8(char32_t c);

bool is_combining_mark(char32_t c);  // a supported one

// The letter with the combining marks that follow it; nullopt if the font lacks a part.
std::optional<Glyph> glyph_of(const HersheyFont& font, char32_t letter,
                              std::u32string_view combining = {});

}  // namespace impedraw
