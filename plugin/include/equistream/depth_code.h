#pragma once
/// Depth as samples of a video picture, and pictures in the layouts of video codecs: one to three planes of 8-bit
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

/// gray: one plane. yuv420: Y', Cb, Cr, the two chroma planes half as wide and high. yuv444: Y', Cb, Cr of one size.
/// gbr: green, blue, red of one size.
enum class PlaneLayout { gray, yuv420, yuv444, gbr };

struct PlaneFormat {
    PlaneLayout layout = PlaneLayout::gray;
    int bits = 8;  ///< of each sample, in the low bits of a byte or word

    int plane_count() const { return layout == PlaneLayout::gray ? 1 : 3; }
    /// Pixels per sample along each axis: 2 for the chroma planes of yuv420, else 1.
    int step(int plane) const { return layout == PlaneLayout::yuv420 && plane > 0 ? 2 : 1; }
    bool operator==(const PlaneFormat&) const = default;
};

/// Views of a picture's planes. `Byte` and `Word` are std::uint8_t and std::uint16_t, or const. The format decides
/// which of the two arrays is used.
template <typename Byte, typename Word>
struct AnyPlanesView {
    PlaneFormat format;
    std::array<ImageView<Byte>, 3> bytes{};  ///< 8-bit formats; one channel each
    std::array<ImageView<Word>, 3> words{};  ///< all other formats; one channel each

    operator AnyPlanesView<const Byte, const Word>() const {
        return {format, {bytes[0], bytes[1], bytes[2]}, {words[0], words[1], words[2]}};
    }
};
using PlanesView = AnyPlanesView<std::uint8_t, std::uint16_t>;
using ConstPlanesView = AnyPlanesView<const std::uint8_t, const std::uint16_t>;

// Radial depth as the samples of a video picture, and back. One interface, several codes:
//
//   w8 w10 w12  x (DepthRange) in one plane of 8, 10 or 12 bits. Steps of x are steps of w, so the bound (bound.h) is
//               the same for every depth.
//   pece444     Pece, Kautz, Weyrich: Adapting Standard Video Codecs for Depth Streaming (2011). x in 16 bits: its top
//   pece420     8 bits in luma, two triangle waves with a period of 1/128 of x in 8 bits of chroma each. In 4:2:0 a
//               chroma sample is the mean of four pixels.
//   hue         Sonoda, Grunnet-Jepsen: Depth image compression by colorization for Intel RealSense depth cameras
//               (2021). x in 1,529 steps along the fully saturated hues; black is no surface.
//   lossless    the bits of the float in three planes of 12 bits: exact, the reference for the other codes.
//
// Codes hold no state: any number of threads may share one. Widths and heights are even. Rows run in parallel. SIMD is
// chosen at run time; the scalar path gives bit-identical samples and depths.

class DepthCode {
public:
    virtual ~DepthCode() = default;
    virtual DepthCodeId id() const = 0;
    virtual PlaneFormat format() const = 0;
    /// The number n for which rounding changes x, in [0, 1], by at most 1 / (2 n): the steps of x, or fewer if a code
    /// rounds twice. 0 for `lossless`, which is exact.
    virtual int levels(const DepthRange& range) const = 0;
    /// The largest change of x by packing and unpacking. It is rounding alone, except for pece420: there the four
    /// depths that share a chroma sample may differ.
    virtual double max_error(const DepthRange& range) const;
    /// Fills `planes`, which have format() and the size of `depth_m` (metres, 1 channel). +inf, NaN and 0 are allowed;
    /// NaN is coded as +inf unless range.has_empty. Returns the number of pixels nearer than range.near_m, which are
    /// coded as near_m; 0 for lossless, which codes every depth.
    virtual std::int64_t pack(ImageView<const float> depth_m, const DepthRange& range,
                              const PlanesView& planes) const = 0;
    /// Fills `depth_m`, in metres, from any samples, damaged ones too: at least range.near_m, +inf for a miss, NaN for
    /// pixels without a surface. lossless gives the depths that were packed.
    virtual void unpack(const ConstPlanesView& planes, const DepthRange& range, ImageView<float> depth_m) const = 0;
};

/// Static storage.
const char* depth_code_name(DepthCodeId code);
/// Names that make_depth_code accepts, indexed by DepthCodeId; static storage.
std::span<const std::string_view> depth_code_names();

std::unique_ptr<DepthCode> make_depth_code(DepthCodeId code);
/// Throws InputError for an unknown name, listing the accepted ones.
std::unique_ptr<DepthCode> make_depth_code(std::string_view name);

/// The largest angle by which an eye in the head box sees a point displaced by packing and unpacking, without a codec
/// between them: asin(w(near_m) max_error). 0 for lossless.
double quantisation_bound_rad(const DepthCode& code, const DepthRange& range);
/// The same bound as a difference of w, for depth decoded with this code; 0 for nullopt, which is the renderer's depth.
double depth_tolerance_w(const std::optional<DepthCodeInfo>& code);

/// A range for pictures whose nearest depth is `nearest_m` (+inf if all pixels miss). near_m is `nearest_m`, or
/// farther: rounding of a depth at near_m takes at most the whole error budget at this focal length. `box_radius_m` and
/// `focal_length_px` are above 0; `has_empty` is DepthRange's.
DepthRange depth_range(const DepthCode& code, double box_radius_m, double nearest_m, bool has_empty,
                       double focal_length_px);

/// The smallest of w8, w10 and w12 whose rounding stays within a quarter of the error budget at this focal length; w12
/// if none does.
DepthCodeId code_for_bound(double box_radius_m, double nearest_m, bool has_empty, double focal_length_px);

// Radial depth at half the columns and half the rows, for tracks with few bits. Depths are never interpolated: each
// sample is one of the four that it represents. Depths have 1 channel and are NaN without a surface; widths and heights
// are even. Functions are pure; rows run in parallel.

/// The nearest of each four depths; NaN if all four are. So a foreground object keeps its outline and its thin parts,
/// at most a pixel too wide. The farthest or the first depth would lose them.
FloatImage halve_depth(ImageView<const float> depth_m);

/// Repeats each sample in its four pixels. The client refines edges by the colour picture instead (decoded_pictures.h).
FloatImage double_depth(ImageView<const float> half_m);

}  // namespace equistream
