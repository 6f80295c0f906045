#pragma once
/// Both eyes in one picture, for displays that have but one, seen through coloured glasses; one beside the other is
/// equistream/stream.h. Pictures are display-referred sRGB, 8-bit RGB. Pure
/// functions; rows run in parallel.
#include <equistream/image.h>

#include <glm/mat3x3.hpp>

#include <span>
#include <string_view>

namespace equistream {

/// How glasses with a red filter before the left eye and a cyan one before the right get both pictures: colour =
/// left * L + right * R, on linear Rec.709, clamped to what a display has.
///
///   dubois       least squares over filters and display: least ghosts, colours nearest (Dubois, A projection method to
///                generate anaglyph stereo images, 2001; its figures as Sanders and McAllister, Producing anaglyphs
///                from synthetic images, 2003, compute them for a CRT)
///   colour       red from the left eye, green and blue from the right
///   half-colour  the left eye's luminance for red: less rivalry where things are red
///   grey         luminance alone
struct Anaglyph {
    std::string_view name;
    glm::mat3 from_left, from_right;  ///< columns are what a channel of the eye adds
};
/// The default comes first.
std::span<const Anaglyph> anaglyphs();
/// Throws InputError naming the accepted ones.
const Anaglyph& find_anaglyph(std::string_view name);

ByteImage make_anaglyph(const Anaglyph& kind, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);

}  // namespace equistream
