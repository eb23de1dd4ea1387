// Letters beyond ASCII, made of a Hershey font's own: é is e with an acute over it.
//
// Latin-1 and Latin Extended-A are composed of a base letter and marks; a mark above i or j takes
// their dot's place, marks above one another are stacked. æ and its like are their two letters
// moved together. Letters without such parts (ß, þ, ð, ŋ, …) and a few signs (° × ÷ « » € …) are
// drawn here, in plain single strokes, whatever the font. Typographic quotes, dashes and blanks
// become ASCII's. Combining marks (U+0300 and on) go onto the letter before them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "impedraw/drawing/hershey.h"

namespace impedraw {

// Strict UTF-8. InputError names the byte.
std::u32string decoded_utf8(std::string_view text);
std::string encoded_utf8(char32_t c);

bool is_combining_mark(char32_t c);  // one of those that are known

// The letter with the combining marks that follow it; none where the font has not what it takes.
std::optional<Glyph> glyph_of(const HersheyFont& font, char32_t letter,
                              std::u32string_view combining = {});

}  // namespace impedraw
