#pragma once
/// Depth as samples of a video picture, and pictures as video codecs take and give them: one to three planes of 8-bit
/// bytes, or of words that hold 9 to 16 bits. Views borrow their samples.
#include <equistream/camera.h>
#include <equistream/depth_code_info.h>
#include <equistream/image.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace equistream {

/// gray: one plane. yuv420: y, cb, cr, those of chroma half as wide and high. yuv444, gbr: three of one size.
enum class PlaneLayout { gray, yuv420, yuv444, gbr };

struct PlaneFormat {
    PlaneLayout layout = PlaneLayout::gray;
    int bits = 8;  ///< of each sample, in the low bits of a byte or word

    int plane_count() const { return layout == PlaneLayout::gray ? 1 : 3; }
    /// Of chroma planes, in pixels a sample; 1 for all others.
    int step(int plane) const { return layout == PlaneLayout::yuv420 && plane > 0 ? 2 : 1; }
    bool operator==(const PlaneFormat&) const = default;
};

/// `Byte` and `Word` are std::uint8_t and std::uint16_t, or const. Only one of the two arrays is used.
template <typename Byte, typename Word>
struct AnyPlanesView {
    PlaneFormat format;
    std::array<ImageView<Byte>, 3> bytes{};  ///< of 8-bit formats, one channel each
    std::array<ImageView<Word>, 3> words{};  ///< of all others

    operator AnyPlanesView<const Byte, const Word>() const {
        return {format, {bytes[0], bytes[1], bytes[2]}, {words[0], words[1], words[2]}};
    }
};
using PlanesView = AnyPlanesView<std::uint8_t, std::uint16_t>;
using ConstPlanesView = AnyPlanesView<const std::uint8_t, const std::uint16_t>;

// Radial depth as the samples of a video picture, and back. One interface, several codes:
//
//   w8 w10 w12  x in one plane of 8, 10 or 12 bits: steps of x are steps of w, so the bound (bound.h) holds for every
//               depth alike. `box_radius_m` and `near_m` are those of DepthRange.
//   pece444     Pece, Kautz, Weyrich: Adapting Standard Video Codecs for Depth Streaming (2011). x in 16 bits: its top
//   pece420     8 in luma, two triangle waves of a period of 1/128 in 8 bits of chroma each; in 4:2:0 a chroma sample
//               is the mean of its four pixels'.
//   hue         Sonoda, Grunnet-Jepsen: Depth image compression by colorization for Intel RealSense depth cameras
//               (2021). x in 1,529 steps along the hues of full colour; black is no surface.
//   lossless    the float's own bits over three planes of 12: the yardstick, exact.
//
// Codes hold no state: any number of threads may share one. Sides are even. Rows run in parallel; SIMD is chosen at
// run time, and the scalar path gives the same samples and depths to the bit.

class DepthCode {
public:
    virtual ~DepthCode() = default;
    virtual DepthCodeId id() const = 0;
    virtual PlaneFormat format() const = 0;
    /// Of how many equal steps of x, from 0 to 1, half a one bounds what rounding changes: those that x is coded in,
    /// fewer where a code rounds twice; 0 for `lossless`, which loses nothing.
    virtual int levels(const DepthRange& range) const = 0;
    /// The most by which coding changes x. Only pece420 changes more than rounding does: where depths that share a
    /// sample differ.
    virtual double max_error(const DepthRange& range) const;
    /// Fills `planes`, which are of format() and depth's size. +inf, NaN and 0 are allowed in `depth_m` (1 channel);
    /// NaN is coded as +inf unless range.has_empty. Returns how many pixels were nearer than range.near_m.
    virtual std::int64_t pack(ImageView<const float> depth_m, const DepthRange& range,
                              const PlanesView& planes) const = 0;
    /// Fills `depth_m` for any samples whatever: never below range.near_m, +inf for a miss, NaN only for pixels without
    /// a surface. What lossless gives is as it was packed.
    virtual void unpack(const ConstPlanesView& planes, const DepthRange& range, ImageView<float> depth_m) const = 0;
};

const char* depth_code_name(DepthCodeId code);
/// Names that make_depth_code accepts, by DepthCodeId.
std::span<const std::string_view> depth_code_names();

std::unique_ptr<DepthCode> make_depth_code(DepthCodeId code);
/// Throws InputError naming the accepted ones.
std::unique_ptr<DepthCode> make_depth_code(std::string_view name);

/// The largest angle by which an eye in the head box sees a point displaced that was packed and unpacked with no codec
/// between: the code's max_error as an angle. 0 for lossless.
double quantisation_bound_rad(const DepthCode& code, const DepthRange& range);
/// The same as a difference of w, for depth that came as this says; 0 where nothing says so: it is the renderer's own.
double depth_tolerance_w(const std::optional<DepthCodeInfo>& code);

/// The range of some pictures' depths: as near as the nearest surface, but not nearer than where rounding takes the
/// whole error budget at this focal length (what is nearer is clamped). `nearest_m` is +inf where all pixels miss;
/// `has_empty` is DepthRange's, and takes a part of the levels.
DepthRange depth_range(const DepthCode& code, double box_radius_m, double nearest_m, bool has_empty,
                       double focal_length_px);

/// What the bound asks for: the w code of the fewest bits whose steps stay within a quarter of the error budget on
/// either side; w12 where none does.
DepthCodeId code_for_bound(double box_radius_m, double nearest_m, bool has_empty, double focal_length_px);

// Radial depth at half the columns and half the rows, for tracks that get few bits. No depth is ever made up: each
// sample is one of those that it stands for. Depths are 1 channel, NaN where there is no surface; sides are even.
// Functions are pure; rows run in parallel.

/// The nearest of each four, NaN where none of them is a surface. What stands before something else keeps its outline
/// and its thin parts, at most a pixel too wide; the farthest or the first would lose them.
FloatImage halve_depth(ImageView<const float> depth_m);

/// Each sample four times. As good as it gets without the colour; with it: decoded_pictures.h of the client's.
FloatImage double_depth(ImageView<const float> half_m);

}  // namespace equistream
