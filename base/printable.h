// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Texts of others (names of files, what a file or a wire says) may hold characters that are no letters but
// commands to the terminal that shows them, or that end the line of a script that they stand in.
namespace kestrel {

// Whether a text holds a control character: a newline, a tab and ESC among them, and those of Unicode beyond
// ASCII.
bool HasControl(std::string_view text);

// A text as it may be shown: newlines and tabs stay, every other control character and each byte that is not
// UTF-8 becomes \x1b.
std::string Printable(std::string_view text);

}  // namespace kestrel
